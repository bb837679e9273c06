#include "estimation/loop/landmark_manager.h"

#include <algorithm>

#include "estimation/modules/births.h"
#include "models/landmarks/true_state.h"
#include "models/points/observation.h"

namespace slammot {

LandmarkManager::LandmarkManager(const Setup& setup, const ModelOptions& models, bool remembers,
                                 std::shared_ptr<const Truth> truth_of_jacobians)
    : setup_(setup),
      models_(models),
      functions_(find_landmark(models.landmark, models.point)),
      rig_(setup.rig()),
      classifier_(
          make_classifier(classifier_for(functions_, models.classifier), setup.true_labels)),
      outside_(classifier_->weighs_odds() ? setup.p_static : std::map<int, double>{},
               models.classifier.prior_odds),
      depth_prior_(learns_depths(models.depth_prior, setup.initial, setup.knows_scale()),
                   setup.prior),
      truth_(std::move(truth_of_jacobians)),
      remembers_(remembers),
      memory_(remembers ? motion_memory(models, functions_) : 0),
      births_(births_in_force(models.labels.births, memory_)) {
  if (!functions_.point.exists(Eigen::Vector3d::UnitZ(), setup.prior.inverse_depth)) {
    throw std::invalid_argument("point " + models.point + " needs prior.inverse_depth above 0");
  }
  for (const KnownLandmark& known : setup.known) known_[known.track] = known;
}

void LandmarkManager::remove(Belief& belief, FrameReport& report) {
  if (tracks_.empty()) return;
  const std::vector<LandmarkEstimate> removed = estimates(tracks_, belief);
  report.retired.insert(report.retired.end(), removed.begin(), removed.end());
  belief.remove(tracks_, records_);
  for (const int track : tracks_) records_.erase(track);
}

void LandmarkManager::record(int frame, std::span<const Observation> accepted,
                             std::span<const int> unused) {
  for (auto& [track, record] : records_) ++record.unused_frames;
  for (const Observation& z : accepted) note_accepted(records_.at(z.track), frame);
  for (const int track : unused) note_rejected(records_.at(track));
}

void LandmarkManager::note_innovations(std::span<const LeaveOneOut> innovations) {
  for (const LeaveOneOut& z : innovations) {
    note_innovation(records_.at(z.track), z.nis, models_.labels, z.pixels);
  }
}

// Of the landmarks that were static before this frame's labels: the marginals are those of the
// update.
void LandmarkManager::look_at_depths(std::span<const Observation> accepted, Belief& belief) {
  tracks_.clear();
  for (const Observation& z : accepted) {
    if (rests(records_.at(z.track))) tracks_.push_back(z.track);
  }
  belief.inverse_depths(tracks_, depths_);
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    note_depth(records_.at(tracks_[i]), depths_[i], models_.labels);
  }
  if (!depth_prior_.learns()) return;
  depth_prior_.learn(depths_);
  learnt_ += depth_prior_.has_learnt() ? 1 : 0;
}

// Thesis 3.1.3, for every landmark measured in this frame whose label is open.
void LandmarkManager::classify(int frame, std::span<const Observation> accepted, Belief& belief) {
  tracks_.clear();
  now_static_.clear();
  for (const Observation& z : accepted) {
    if (is_asked(records_.at(z.track), models_.labels)) tracks_.push_back(z.track);
  }
  belief.motions(tracks_, motions_);
  for (MotionBelief& motion : motions_) {
    complete(motion);
    TrackRecord& record = records_.at(motion.track);
    const Label before = record.label;
    note_answer(record, answer(motion, record), frame);
    answered_ += record.label != before ? 1 : 0;
    if (record.label == Label::kStatic) now_static_.push_back(motion.track);
  }
}

void LandmarkManager::forget_motions(Belief& belief) {
  tracks_.clear();
  for (auto& [track, record] : records_) {
    if (!record.is_remembered) continue;
    if (is_forgotten(record, memory_)) tracks_.push_back(track);
    ++record.remembered_frames;
  }
  for (const int track : tracks_) records_.at(track).is_remembered = false;
  belief.forget_motions(tracks_);
}

void LandmarkManager::collapse(std::span<const int> tracks, Belief& belief) {
  if (tracks.empty()) return;
  for (const int track : tracks) {
    TrackRecord& record = records_.at(track);
    record.is_remembered = memory_ > 0;
    record.rests_beyond_doubt = false;
    record.remembered_frames = 0;
  }
  collapsed_ += std::ssize(tracks);
  belief.collapse(tracks);
}

// Only of landmarks that were measured in this frame: nothing else can have contradicted a label.
void LandmarkManager::undo_labels(int frame, std::span<const Observation> measured,
                                  Belief& belief) {
  tracks_.clear();
  for (const Observation& z : measured) {
    if (rests(records_.at(z.track))) tracks_.push_back(z.track);
  }
  belief.constrained_motions(tracks_, remembered_);
  const auto ask = [this](std::size_t i) { return ask_remembered(i); };
  find_undoing(records_, tracks_, remembered_, ask, undoing_);
  note_motions(frame);
  apply(undoing_, belief);
}

// What the classifier says of a landmark at rest, by the motion that it would have. One that is
// held is not asked before its third sighting, as those that are free (is_asked).
std::optional<MotionAnswer> LandmarkManager::ask_remembered(std::size_t i) {
  auto motion = remembered_.motion(i, functions_);
  if (!motion) return std::nullopt;
  TrackRecord& record = records_.at(motion->track);
  complete(*motion);
  if (record.is_held && record.observations < models_.labels.sightings) {
    return MotionAnswer{*motion, Label::kUnknown};
  }
  return MotionAnswer{*motion, answer(*motion, record)};
}

// Of those that are not released: one that is held may be static from now on, and one that is
// static may be so beyond doubt.
void LandmarkManager::note_motions(int frame) {
  for (std::size_t i = 0; i < remembered_.size(); ++i) {
    const auto answer = ask_remembered(i);
    if (!answer) continue;  // released
    TrackRecord& record = records_.at(answer->motion.track);
    if (record.is_held && answer->label == Label::kStatic) {
      record.is_held = false;
      note_answer(record, Label::kStatic, frame);
      ++answered_;
    }
    if (!record.is_held) note_motion(record, answer->motion);
  }
}

void LandmarkManager::apply(const Undoing& undoing, Belief& belief) {
  for (const int track : undoing.free) {
    note_reverted(records_.at(track));
    belief.free(track, records_.at(track).prior);
  }
  undone_ += std::ssize(undoing.free);
  for (const int track : undoing.release) {
    TrackRecord& record = records_.at(track);
    ++(record.is_held ? let_go_ : released_);  // no label is undone of one that is held
    note_reverted(record);
  }
  if (!undoing.release.empty()) belief.release(undoing.release, records_);
}

// With what the classifier asks besides.
void LandmarkManager::complete(MotionBelief& motion) const {
  motion.prior_sigmas = functions_.prior_sigmas(records_.at(motion.track).prior);
  motion.outside = outside_.evidence(motion.track);
}

Label LandmarkManager::answer(const MotionBelief& motion, TrackRecord& record) const {
  const Label label = classifier_->decide(motion, record.classifier_memory);
  return label == Label::kStatic && record.cannot_rest ? Label::kUnknown : label;
}

// Judged at the estimate. Where Jacobians are taken at the truth it is judged there: what is
// learnt, and so the covariance, must then not depend on the estimate.
bool LandmarkManager::expected_in_view(int frame, const CameraState& camera,
                                       const LandmarkPoint& point) const {
  if (!truth_) {
    return in_view(setup_.camera, functions_.point, camera.position, camera.orientation,
                   point.anchor, point.y);
  }
  const auto landmark = truth_->landmarks.find(point.track);
  if (landmark == truth_->landmarks.end()) return false;
  const TruePoint* at = landmark->second.at(frame);
  if (at == nullptr) return false;  // out of view a mover has no truth
  const CameraState& c = true_camera(*truth_, frame);
  const auto projection =
      setup_.camera.project(c.orientation.conjugate() * (at->position - c.position));
  return projection && setup_.camera.in_image(projection->pixel);
}

void LandmarkManager::prune(int frame, Belief& belief, FrameReport& report) {
  tracks_.clear();
  belief.points(points_);
  const CameraState camera = belief.camera().state;
  for (const LandmarkPoint& point : points_) {
    TrackRecord& record = records_.at(point.track);
    if (record.unused_frames > 0) note_unused(record, expected_in_view(frame, camera, point));
    if (is_pruned(record, models_.policy)) tracks_.push_back(point.track);
  }
  remove(belief, report);
}

void LandmarkManager::in_force(InForce& result) const {
  const LabelOptions& labels = models_.labels;
  const ModelOptions& m = models_;
  const bool reversible = labels.rule == LabelRule::kReversible;
  std::string no_memory = why_no_memory(m, functions_);
  if (no_memory.empty() && !remembers_) no_memory = "this estimator remembers no motions";
  const bool can_move = functions_.can_move;
  const std::string at_rest = can_move ? "" : "landmark=" + std::string(functions_.name);
  const bool remembers = labels.memory > 0;
  const bool odds = m.classifier.name == "odds";
  result.push_back({"labels by posterior odds", "classifier", odds && can_move, odds ? at_rest : "",
                    odds ? answered_ : 0});
  state_outside(at_rest, result);
  state_births(remembers ? no_memory : "labels.memory=0", result);
  const bool condition = m.collapse == Collapse::kCondition;
  result.push_back({"rest used as a measurement", "collapse", condition && can_move,
                    condition ? at_rest : "", condition ? collapsed_ : 0});
  result.push_back({"labels undone", "labels", reversible, "", undone_ + released_});
  result.push_back({"labels undone by a remembered motion", "labels.memory", memory_ > 0,
                    remembers ? no_memory : "", released_});
  const bool learns = m.depth_prior != DepthPriorSource::kFixed;
  result.push_back({"depth prior learnt from the map", "prior.source", depth_prior_.learns(),
                    learns && !depth_prior_.learns() ? "nothing holds the scale" : "", learnt_});
}

// `at_rest`: why nothing can move, or empty.
void LandmarkManager::state_outside(const std::string& at_rest, InForce& result) const {
  if (setup_.p_static.empty()) return;
  const bool weighs = classifier_->weighs_odds();
  const std::string other = at_rest.empty() ? "classifier=" + models_.classifier.name : at_rest;
  result.push_back(
      {"births with odds from outside", "priors.csv", weighs, weighs ? "" : other, with_odds_});
}

// `no_memory`: why nothing is remembered, or empty.
void LandmarkManager::state_births(const std::string& no_memory, InForce& result) const {
  const bool holds = births_ == Births::kHeld;
  const std::string because = models_.labels.births == Births::kHeld ? no_memory : "";
  result.push_back({"births held at rest", "labels.births", holds, because, held_});
  result.push_back({"births that were held released", "labels.births", holds, because, let_go_});
}

std::vector<LandmarkEstimate> LandmarkManager::estimates(std::span<const int> tracks,
                                                         const Belief& belief) const {
  std::vector<LandmarkEstimate> result;
  if (tracks.empty()) return result;
  const std::vector<LandmarkBelief> beliefs = belief.landmarks(tracks);
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    result.push_back(landmark_estimate(functions_, records_.at(tracks[i]), beliefs[i]));
  }
  return result;
}

}  // namespace slammot
