#include "estimation/loop/frame_loop.h"

#include <algorithm>
#include <iterator>

#include "estimation/modules/consider.h"

namespace slammot {

FrameLoop::FrameLoop(const Setup& setup, const ModelOptions& models, std::unique_ptr<Belief> belief,
                     std::shared_ptr<const Truth> truth_of_jacobians)
    : setup_(setup),
      models_(models),
      point_(find_point(models.point)),
      gate_(models.gate, setup.pixel_sigma),
      policy_(models.policy),
      belief_(std::move(belief)),
      manager_(setup, models, belief_->remembers_motions(), truth_of_jacobians),
      noise_(setup.camera_noise, models.adaptive_motion && !truth_of_jacobians) {
  // They need no care for movers, and a covariance there must not depend on the estimate.
  if (truth_of_jacobians) policy_.movers = Movers::kJoint;
  if (!setup.knows_scale()) scale_change_.emplace(setup.initial.state.position);
}

FrameReport FrameLoop::process(const Frame& frame, StageListener& stages) {
  if (timestamp_ && !(frame.timestamp > *timestamp_)) {
    throw std::invalid_argument("the time of a frame must be later than that of the one before");
  }
  FrameReport report;
  const CameraEstimate before = timestamp_ ? belief_->camera() : CameraEstimate{};
  const double dt = advance_time(frame);

  // Old remembered motions are forgotten; camera and free landmarks predicted; known ones enter.
  stages.begin("predict");
  manager_.forget_motions(*belief_);
  belief_->predict(frame, dt, noise_.of_next(), manager_.records());
  manager_.add_known(frame, *belief_, report);

  // Gate the measurements of landmarks in the belief.
  stages.begin("gate");
  gate(frame, dt, report);
  if (keeps_predictions_) {
    stages.begin(StageListener::kPredictions);
    note_predictions(report);
  }

  // Update with what passed; movers may be considered only.
  stages.begin("update");
  find_considered(accepted_, manager_.records(), policy_, considered_);
  considered_frames_ += considered_.empty() ? 0 : 1;
  belief_->update(accepted_, considered_, stages);

  // Read the update's marginals before labels change.
  stages.begin("marginals");
  look_at_marginals(before, dt);

  // Classify what was measured.
  stages.begin("classify");
  manager_.record(frame.index, used_, unused_);
  manager_.classify(frame.index, used_, *belief_);

  // Collapse what is static now; undo static labels that are rejected.
  stages.begin("collapse");
  manager_.collapse(manager_.now_static(), *belief_);
  manager_.undo_labels(frame.index, landmarks_in_view_, *belief_);

  // Prune landmarks and initialise new ones.
  stages.begin("manage");
  manager_.prune(frame.index, *belief_, report);
  manager_.initialise_new(frame, static_cast<int>(used_.size()), *belief_, report);
  belief_->finish();
  count_what_is_left(report);
  return report;
}

void FrameLoop::look_at_marginals(const CameraEstimate& before, double dt) {
  if (noise_.adapts() && dt > 0.0) noise_.learn(before, belief_->camera(), dt);
  if (manager_.watches_innovations()) {
    belief_->leave_one_out(given_others_);
    manager_.note_innovations(given_others_);
    manager_.note_innovations(explained_by_motion_);
  }
  manager_.look_at_depths(used_, *belief_);
}

// Of what the frame leaves behind, like the size of the state.
void FrameLoop::count_what_is_left(FrameReport& report) {
  report.state_size = belief_->state_size();
  report.scale_information = belief_->scale_information();
  belief_->points(points_);
  if (scale_change_) {
    report.scale_change =
        (*scale_change_)(points_, manager_.records(), belief_->camera().state.position);
  }
  report.negative_inverse_depth = static_cast<int>(std::ranges::count_if(
      points_, [&](const LandmarkPoint& p) { return point_.inverse_depth(p.y) < 0.0; }));
}

double FrameLoop::advance_time(const Frame& frame) {
  const double dt = timestamp_ ? frame.timestamp - *timestamp_ : 0.0;
  timestamp_ = frame.timestamp;
  return dt;
}

// The shared mechanisms, then the family's own.
InForce FrameLoop::in_force() const {
  InForce result;
  const bool adapts = models_.adaptive_motion;
  result.push_back({"camera noise that adapts", "motion.adaptive", noise_.adapts(),
                    adapts && !noise_.adapts() ? "ekf.linearisation=ideal" : "",
                    noise_.widened() + widened_});
  const bool asks_others = models_.gate.given_others < 1.0;
  result.push_back({"gate given all others", "gate.given_others", asks_others, "",
                    asks_others ? refused_by_others_ : 0});
  manager_.in_force(result);
  const bool considers = policy_.movers == Movers::kConsidered;
  const bool is_asked = models_.policy.movers == Movers::kConsidered;
  result.push_back({"movers considered", "policy.movers", considers,
                    is_asked && !considers ? "ekf.linearisation=ideal" : "",
                    considers ? considered_frames_ : 0});
  belief_->in_force(result);
  return result;
}

CameraEstimate FrameLoop::camera() const {
  CameraEstimate camera = belief_->camera();
  camera.timestamp = timestamp_.value_or(0.0);
  return camera;
}

std::vector<LandmarkEstimate> FrameLoop::landmarks() const {
  std::vector<int> tracks;
  for (const auto& [track, record] : manager_.records()) tracks.push_back(track);
  return manager_.estimates(tracks, *belief_);
}

std::vector<LandmarkEstimate> FrameLoop::landmarks_measured(int index) const {
  std::vector<int> tracks;
  for (const auto& [track, record] : manager_.records()) {
    if (record.last_frame == index) tracks.push_back(track);
  }
  return manager_.estimates(tracks, *belief_);
}

}  // namespace slammot
