#include "estimation/loop/landmark_manager.h"

#include <algorithm>

#include "models/landmarks/true_state.h"
#include "models/points/observation.h"

namespace slammot {

LandmarkManager::LandmarkManager(const Setup& setup, const ModelOptions& models, FirstFrame& first,
                                 std::shared_ptr<const Truth> truth_for_view)
    : setup_(setup),
      models_(models),
      functions_(find_landmark(models.landmark, models.point)),
      classifier_(
          make_classifier(classifier_for(functions_, models.classifier), setup.true_labels)),
      depth_prior_(learns_depths(models.depth_prior, setup.initial, !setup.known.empty()),
                   setup.prior),
      truth_(std::move(truth_for_view)),
      first_(first),
      memory_(motion_memory(models, functions_)) {
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

// Before the update, so that their first pixel counts as well. What was stated counts once: a known
// landmark that was pruned starts anew as an unknown one.
void LandmarkManager::add_known(const Frame& frame, Belief& belief, FrameReport& report) {
  if (!first_frame_) first_frame_ = frame.index;
  for (const Observation& z : frame.observations) {
    const auto known = known_.find(z.track);
    if (known == known_.end() || holds(z.track)) continue;
    belief.add_known(known->second);
    TrackRecord& record = records_[z.track] =
        initialised(z.track, frame.index, Label::kStatic, setup_.prior);
    record.known = record.by_rule = true;
    record.observations = 0;
    known_.erase(known);
    ++report.admitted;
  }
}

void LandmarkManager::record(int frame, std::span<const Observation> accepted,
                             std::span<const int> unused) {
  for (auto& [track, record] : records_) ++record.unused_frames;
  for (const Observation& z : accepted) note_accepted(records_.at(z.track), frame);
  for (const int track : unused) note_rejected(records_.at(track));
}

void LandmarkManager::note_innovations(std::span<const LeaveOneOut> innovations) {
  for (const LeaveOneOut& z : innovations) {
    note_innovation(records_.at(z.track), z.nis, models_.labels);
  }
}

// Of the landmarks that were static before this frame's labels: the marginals are those of the
// update.
void LandmarkManager::look_at_depths(std::span<const Observation> accepted, Belief& belief) {
  tracks_.clear();
  for (const Observation& z : accepted) {
    if (records_.at(z.track).label == Label::kStatic) tracks_.push_back(z.track);
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
  complete_motions();
  for (const MotionBelief& motion : motions_) {
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
std::optional<int> LandmarkManager::undo_labels(std::span<const Observation> measured,
                                                Belief& belief) {
  tracks_.clear();
  for (const Observation& z : measured) {
    if (records_.at(z.track).label == Label::kStatic) tracks_.push_back(z.track);
  }
  belief.constrained_motions(tracks_, motions_);
  complete_motions();
  answers_.clear();
  for (const MotionBelief& motion : motions_) {
    TrackRecord& record = records_.at(motion.track);
    note_motion(record, motion);
    answers_.push_back(classifier_->decide(motion, record.classifier_memory));
  }
  find_undoing(records_, tracks_, motions_, answers_, undoing_);
  return apply(undoing_, belief);
}

// A label of the first frame is undone by processing the frames again, one at a time: the label
// whose motion is remembered, else the one that innovations reject most clearly.
std::optional<int> LandmarkManager::apply(const Undoing& undoing, Belief& belief) {
  std::optional<int> from_the_start;
  for (const int track : undoing.free) {
    TrackRecord& record = records_.at(track);
    if (!first_.undoes_from_the_start(record)) {
      note_reverted(record);
      belief.free(track, record.prior);
      ++undone_;
    } else if (!from_the_start || log_tail(record) < log_tail(records_.at(*from_the_start))) {
      from_the_start = track;
    }
  }
  if (!undoing.release) return from_the_start;
  TrackRecord& record = records_.at(*undoing.release);
  if (first_.undoes_from_the_start(record)) return undoing.release;
  note_reverted(record);
  belief.release(record.track, record.prior);
  ++released_;
  return from_the_start;
}

// With what the classifier asks besides.
void LandmarkManager::complete_motions() {
  for (MotionBelief& motion : motions_) {
    motion.prior_sigmas = functions_.prior_sigmas(records_.at(motion.track).prior);
  }
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

TrackRecord LandmarkManager::record_at_birth(int track, int frame, const LandmarkPrior& prior) {
  const Label given = classifier_->at_birth(track);
  if (given != Label::kUnknown || frame != first_frame_) {
    return initialised(track, frame, given, prior);
  }
  TrackRecord record = initialised(track, frame, first_.label(track), prior);
  record.by_rule = first_.is_rule();
  return record;
}

// Thesis 2.1.3: undelayed, at the first pixel.
void LandmarkManager::initialise_new(const Frame& frame, Belief& belief, FrameReport& report) {
  unmatched_.clear();
  for (const Observation& z : frame.observations) {
    if (!holds(z.track)) unmatched_.push_back(z);
  }
  const std::size_t wanted = births_wanted(report.accepted, models_.policy);
  if (unmatched_.size() > wanted) unmatched_.resize(wanted);
  make_room(records_, unmatched_.size(), models_.policy, tracks_);
  remove(belief, report);
  const auto most = static_cast<std::size_t>(models_.policy.max_landmarks);
  const LandmarkPrior& prior = depth_prior_.of_new();
  tracks_.clear();
  for (const Observation& z : unmatched_) {
    if (records_.size() >= most) break;
    TrackRecord record = record_at_birth(z.track, frame.index, prior);
    // A label that may be undone from the start: its motion is remembered from the start.
    const bool remembers = first_.undoes_from_the_start(record) && memory_ > 0;
    if (!belief.add(z, prior, record.label != Label::kStatic || remembers)) continue;
    if (remembers) tracks_.push_back(z.track);
    records_[z.track] = std::move(record);
    ++report.admitted;
  }
  remembered_at_birth_ += std::ssize(tracks_);
  collapse(tracks_, belief);
}

void LandmarkManager::in_force(InForce& result) const {
  const LabelOptions& labels = models_.labels;
  const ModelOptions& m = models_;
  const bool reversible = labels.rule == LabelRule::kReversible;
  const std::string no_memory = why_no_memory(m, functions_);
  const bool can_move = functions_.can_move;
  const std::string at_rest = can_move ? "" : "landmark=" + std::string(functions_.name);
  const bool odds = m.classifier.name == "odds";
  result.push_back({"labels by posterior odds", "classifier", odds && can_move, odds ? at_rest : "",
                    odds ? answered_ : 0});
  const bool by_odds = labels.first_frame == FirstFrameLabels::kOdds;
  const bool may_undo = by_odds && reversible;
  const std::string one_way = by_odds && !reversible ? "labels=one_way" : "";
  result.push_back({"first frame's labels undone from the start", "labels.first_frame", may_undo,
                    one_way, first_.dropped()});
  result.push_back({"first frame's motions remembered", "labels.first_frame",
                    may_undo && memory_ > 0, one_way, remembered_at_birth_});
  const bool condition = m.collapse == Collapse::kCondition;
  result.push_back({"rest used as a measurement", "collapse", condition && can_move,
                    condition ? at_rest : "", condition ? collapsed_ : 0});
  result.push_back(
      {"labels undone", "labels", reversible, "", undone_ + released_ + first_.dropped()});
  const bool remembers = labels.memory > 0;
  result.push_back({"labels undone by a remembered motion", "labels.memory", memory_ > 0,
                    remembers ? no_memory : "", released_});
  const bool learns = m.depth_prior != DepthPriorSource::kFixed;
  result.push_back({"depth prior learnt from the map", "prior.source", depth_prior_.learns(),
                    learns && !depth_prior_.learns() ? "nothing holds the scale" : "", learnt_});
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
