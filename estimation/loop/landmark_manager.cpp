#include "estimation/loop/landmark_manager.h"

#include <algorithm>

#include "estimation/labels/pooled_motion.h"
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
      probation_(models.policy.probation),
      first_(first) {
  if (!functions_.point.exists(Eigen::Vector3d::UnitZ(), setup.prior.inverse_depth)) {
    throw std::invalid_argument("point " + models.point + " needs prior.inverse_depth above 0");
  }
  for (const KnownLandmark& known : setup.known) known_[known.track] = known;
}

// What was learnt of where it is leaves with the landmark; that it moves, or does not, is still
// true.
void LandmarkManager::retire_leaving(Belief& belief, FrameReport& report) {
  belief.leaving(tracks_);
  for (const int track : tracks_) labels_left_[track] = records_.at(track).label;
  remove(belief, report);
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
    if (known == known_.end() || knows(z.track)) continue;
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
  if (depth_prior_.learns()) depth_prior_.learn(depths_);
}

// Thesis 3.1.3, for every landmark measured in this frame whose label is open.
const std::vector<int>& LandmarkManager::classify(int frame, std::span<const Observation> accepted,
                                                  Belief& belief) {
  tracks_.clear();
  now_static_.clear();
  for (const Observation& z : accepted) {
    if (is_asked(records_.at(z.track), models_.labels)) tracks_.push_back(z.track);
  }
  belief.motions(tracks_, motions_);
  complete_motions(accepted);
  for (const MotionBelief& motion : motions_) {
    TrackRecord& record = records_.at(motion.track);
    note_answer(record, answer(motion, record), frame);
    if (record.label == Label::kStatic) now_static_.push_back(motion.track);
  }
  return now_static_;
}

// Only a landmark that was measured in this frame: nothing else can have been said against it.
void LandmarkManager::revert_labels(std::span<const Observation> measured, Belief& belief) {
  const TrackRecord* accused = nullptr;  // of the first frame, with no motion remembered
  tracks_.clear();
  for (const Observation& z : measured) {
    const TrackRecord& record = records_.at(z.track);
    if (record.label == Label::kStatic) tracks_.push_back(z.track);
  }
  belief.held_motions(tracks_, motions_);
  complete_motions(measured);
  for (const int track : tracks_) {
    TrackRecord& record = records_.at(track);
    const bool is_remembered =
        std::ranges::find(motions_, track, &MotionBelief::track) != motions_.end();
    if (is_remembered || !is_rejected(record, models_.labels)) continue;
    if (first_.holds(record)) {
      if (accused == nullptr || log_tail(record) < log_tail(*accused)) accused = &record;
      continue;
    }
    note_reverted(record);
    belief.free(track, record.prior);
  }
  first_.accuse(accused == nullptr ? std::nullopt : std::optional(accused->track));
  release_what_moved(belief);
}

// What is static and remembered: were its motion not held at rest, would the classifier say moving,
// or do its innovations reject the label? Only the surest in a frame: what bends the map makes
// others look moving, too.
void LandmarkManager::release_what_moved(Belief& belief) {
  double surest = 0.0;
  TrackRecord* released = nullptr;
  for (const MotionBelief& motion : motions_) {
    TrackRecord& record = records_.at(motion.track);
    const double distance = mahalanobis_from_zero(motion.w, motion.covariance);
    if (released != nullptr && distance <= surest) continue;
    if (!is_rejected(record, models_.labels) && answer(motion, record) != Label::kMoving) continue;
    surest = distance;
    released = &record;
  }
  if (released == nullptr) return;
  if (first_.holds(*released)) return first_.accuse(released->track);
  note_reverted(*released);
  belief.release(released->track, released->prior);
}

// With what the classifier asks besides; pooled with their neighbours' where that is wanted.
void LandmarkManager::complete_motions(std::span<const Observation> measured) {
  for (MotionBelief& motion : motions_) {
    const LandmarkPrior& prior = records_.at(motion.track).prior;
    motion.prior_sigmas = functions_.prior_sigmas(prior);
    motion.prior_velocity_sigma = prior.velocity_sigma();
  }
  if (models_.labels.pooled > 0.0) pool_motions(measured, models_.labels.pooled, motions_);
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
  for (const int track : tracks_) labels_left_.erase(track);
  remove(belief, report);
}

TrackRecord LandmarkManager::record_at_birth(int track, int frame, const LandmarkPrior& prior) {
  const auto left = labels_left_.find(track);
  if (left != labels_left_.end()) return initialised(track, frame, left->second, prior);
  const Label given = classifier_->at_birth(track);
  if (given != Label::kUnknown || frame != first_frame_) {
    return initialised(track, frame, given, prior);
  }
  TrackRecord record = initialised(track, frame, first_.label(track), prior);
  record.by_rule = first_.is_rule();
  if (record.decision_frame) record.decision_frame = first_.decision_frame(frame);
  return record;
}

void LandmarkManager::end_probation(const Frame& frame, Belief& belief, FrameReport& report) {
  if (!probation_.is_on()) return;
  const auto is_known = [&](const Observation& z) { return knows(z.track); };
  const auto visible = std::ranges::count_if(frame.observations, is_known);
  const auto room =
      room_for(static_cast<int>(records_.size()), static_cast<int>(visible), models_.policy);
  std::vector<Candidate> candidates;
  std::map<int, TrackRecord> births;
  for (const Observation& z : frame.observations) {
    if (candidates.size() == room) break;
    if (knows(z.track) || !probation_.is_passed(z.track)) continue;
    TrackRecord record = record_at_birth(z.track, frame.index, depth_prior_.of_new());
    candidates.push_back(
        {z.track, probation_.sightings(z.track, frame.timestamp), record.prior, record.label});
    note_sightings(record, candidates.back().sightings);
    births[z.track] = std::move(record);
  }
  belief.add_seen(candidates, tracks_);
  for (const int track : tracks_) {
    probation_.forget(track);
    births.erase(track);
  }
  report.admitted += static_cast<int>(births.size());
  records_.merge(births);
}

// Thesis 2.1.3: undelayed, at the first pixel; or on probation.
void LandmarkManager::initialise_new(const Frame& frame, Belief& belief, FrameReport& report) {
  unmatched_.clear();
  for (const Observation& z : frame.observations) {
    if (!knows(z.track)) unmatched_.push_back(z);
  }
  if (probation_.is_on() && frame.index != first_frame_) {
    return probation_.note(frame, unmatched_);
  }
  const LandmarkPrior& prior = depth_prior_.of_new();
  const auto room = room_for(static_cast<int>(records_.size()), report.accepted, models_.policy);
  if (unmatched_.size() > room) unmatched_.resize(room);
  tracks_.clear();
  for (const Observation& z : unmatched_) {
    TrackRecord record = record_at_birth(z.track, frame.index, prior);
    // A label that revise() may take back: its motion is remembered from the start.
    const bool remembers = first_.holds(record) && motion_memory(models_, functions_) > 0;
    if (!belief.add(z, prior, record.label != Label::kStatic || remembers)) continue;
    if (remembers) tracks_.push_back(z.track);
    records_[z.track] = std::move(record);
    ++report.admitted;
  }
  if (!tracks_.empty()) belief.collapse(tracks_);
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
