#include "filters/ekf.h"

#include <algorithm>

#include "estimation/loop/frame_loop.h"
#include "filters/ekf_belief.h"
#include "models/points/initialisation.h"

namespace slammot {

Ekf::Ekf(const Setup& setup, const ModelOptions& models, const EkfOptions& options)
    : setup_(setup),
      options_(options),
      condition_(models.collapse == Collapse::kCondition),
      threshold_given_others_(pixel_threshold(models.gate.given_others)),
      functions_(find_landmark(models.landmark, models.point)),
      memory_(options.delayed ? 0 : motion_memory(models, functions_)),
      linearisation_(options, functions_, setup.truth, !setup.known.empty()) {
  if (options.deferred && options.linearisation == FilterLinearisation::kInvariant) {
    throw std::invalid_argument(
        "ekf.deferred cannot go with linearisation invariant, which changes passive rows at each "
        "update");
  }
  if (options.deferred && linearisation_.scale()) {
    throw std::invalid_argument(
        "ekf.deferred cannot go with ekf.equivariant_scale, which changes passive rows at each "
        "update");
  }
  if (options.deferred && functions_.motion != 3) {
    throw std::invalid_argument("ekf.deferred needs a landmark model with a motion of 3 numbers");
  }
  state_.camera = setup.initial.state;
  state_.covariance.append({}, setup.initial.sigmas().cwiseAbs2().asDiagonal().toDenseMatrix());
  const bool corrects_clones = options.linearisation == FilterLinearisation::kStandard ||
                               options.linearisation == FilterLinearisation::kIdeal;
  if (options.lag > 0 && (options.deferred || !corrects_clones)) {
    throw std::invalid_argument(
        "ekf.lag needs linearisation standard or ideal, and no ekf.deferred");
  }
  if (options.delayed && options.linearisation == FilterLinearisation::kInvariant) {
    throw std::invalid_argument(
        "ekf.linearisation invariant cannot go with estimator delayed, whose pending landmarks "
        "move "
        "alone");
  }
  const bool is_standard = options.linearisation == FilterLinearisation::kStandard;
  if (models.policy.probation > 1 && (options.deferred || !is_standard)) {
    throw std::invalid_argument(
        "policy.probation above 1 needs ekf.linearisation standard, and no ekf.deferred");
  }
  const LandmarkPrior& prior = setup.prior;
  if (prior.mean_sigma > 0.0) {
    const Eigen::MatrixXd variance =
        Eigen::MatrixXd::Constant(1, 1, prior.mean_sigma * prior.mean_sigma);
    state_.scene = {prior.inverse_depth, state_.covariance.append({}, variance)};
  }
  for (int i = 0; i < std::max(options.lag, models.policy.probation - 1); ++i) {
    state_.clones.emplace_back().block = state_.covariance.append({}, Matrix6d::Zero());
  }
}

// Thesis 2.1.1 for the camera, (2.5) for what may move; a static landmark is not predicted (3.1.3).
void Ekf::predict(const Frame& frame, double dt, const MotionNoise& noise,
                  const TrackRecords& records) {
  if (options_.deferred) divide(frame);
  frame_ = frame.index;
  ++frames_;
  forget_motions();
  if (dt == 0.0) return;
  if (!state_.clones.empty()) state_.clone_pose(clone_of(frames_ - 1));
  const CameraState at = linearisation_.camera(state_);
  camera_noise_ = camera_noise(noise, at, dt);
  state_.covariance.propagate({JointState::kCamera}, predict_jacobian(at, dt), camera_noise_);
  state_.camera = slammot::predict(state_.camera, dt);
  for (auto& [track, landmark] : state_.landmarks) {
    if (landmark.is_free()) predict_landmark(track, landmark, records.at(track).label, dt);
    if (landmark.is_held()) predict_held(track, landmark, dt);
  }
  linearisation_.predicted(state_, frame.index, dt);
}

void Ekf::add_known(const KnownLandmark& known) {
  const FilterAnchor& anchor = anchor_at(state_.pose(), frame_);
  const NewKnownLandmark here = initialise_known(functions_.point, known, anchor.position);
  const Eigen::MatrixXd J = linearisation_.known_birth(state_, known, frame_, here).J_y_position;
  const double variance = known.sigma * known.sigma;
  const StateBlock block =
      state_.covariance.append({{anchor.block, -J}}, variance * J * J.transpose());
  insert(known.track, frame_, here.y, block);
}

void Ekf::innovations(std::span<const Observation> measured, FrameInnovation& result) {
  linearise(state_, linearisation_, setup_.camera, measured, innovation_);
  result.z = innovation_.matches;
  result.nu = innovation_.nu;
  fill_HPHt(state_, innovation_, result.HPHt);
  measured_ = result.z.size();
}

void Ekf::widen(double factor) {
  state_.covariance.propagate({JointState::kCamera}, Matrix12d::Identity(),
                              (factor - 1.0) * camera_noise_);
  camera_noise_ *= factor;
}

void Ekf::predict_pixels(std::span<const int> tracks, std::vector<Prediction>& result) {
  state_.correct_passive();
  result.clear();
  for (const int track : tracks) {
    const auto expected = predict_pixel(state_, linearisation_, setup_.camera, track);
    if (expected) result.push_back(*expected);
  }
}

// Depth and velocity of a mover stay uncertain for long, and move. What it says about the camera
// through Jacobians taken there is overconfident (docs/consistency.md, "Movers and the camera").
bool Ekf::moves_alone(Label label, std::ptrdiff_t static_measurements) const {
  if (label == Label::kUnknown) return options_.delayed;
  const bool relies_on_static = options_.static_enough > 0 &&
                                linearisation_.movers_may_move_alone() &&
                                static_measurements >= options_.static_enough;
  return relies_on_static && label == Label::kMoving;
}

// One update for all, but for what moves only its own landmark, after the others.
void Ekf::update(const TrackRecords& records, std::span<const Observation> accepted,
                 StageListener& /*stages*/) {
  for (const Observation& z : accepted) state_.landmarks.at(z.track).last_used = frames_;
  const auto label = [&](const Observation& z) { return records.at(z.track).label; };
  const auto static_measurements = std::ranges::count(accepted, Label::kStatic, label);
  counting_.clear();
  pending_.clear();
  for (const Observation& z : accepted) {
    (moves_alone(label(z), static_measurements) ? pending_ : counting_).push_back(z);
  }
  keep(counting_, innovation_);
  slammot::update(state_, linearisation_, setup_.camera, setup_.pixel_sigma, options_.iterations,
                  innovation_);
  update_alone(state_, linearisation_, setup_.camera, pending_, setup_.pixel_sigma, alone_);
}

void Ekf::leave_one_out(std::vector<LeaveOneOut>& result) {
  result.clear();
  nis_given_others(innovation_, nis_);
  for (std::size_t i = 0; i < nis_.size(); ++i) {
    result.push_back({innovation_.matches[i].track, nis_[i]});
  }
}

void Ekf::inverse_depths(std::span<const int> tracks, std::vector<SeenDepth>& result) {
  result.clear();
  for (const int track : tracks) {
    const FilterLandmark& landmark = state_.landmarks.at(track);
    result.push_back(seen_depth(functions_.point, landmark.y,
                                state_.covariance.block(landmark.y_block, landmark.y_block)));
  }
}

void Ekf::motions(std::span<const int> tracks, std::vector<MotionBelief>& result) {
  result.clear();
  for (const int track : tracks) {
    const FilterLandmark& landmark = state_.landmarks.at(track);
    MotionBelief& motion = result.emplace_back();
    motion.track = track;
    motion.w = landmark.w;
    motion.covariance = state_.covariance.block(landmark.w_block, landmark.w_block);
    motion.density_scale = functions_.density_scale(landmark.x());
  }
}

void Ekf::collapse(std::span<const int> tracks) {
  if (condition_) {
    linearisation_.collapse(state_, tracks);
    condition_on_rest(tracks);
  }
  for (const int track : tracks) state_.drop_motion(track);  // unless it is held
}

void Ekf::free(int track, const LandmarkPrior& prior) {
  state_.forget_motion(track);
  state_.free_motion(track, functions_.prior_sigmas(prior));
}

void Ekf::remove(std::span<const int> tracks, const TrackRecords& /*records*/) {
  state_.remove_landmarks(tracks);
}

// Thesis 2.1.3, (2.7): y from pixel, rotation and prior, with its full cross-covariance.
bool Ekf::add(const Observation& z, const LandmarkPrior& prior, bool is_free) {
  return add(z, state_.pose(), frame_, prior, is_free);
}

bool Ekf::add(const Observation& z, const FilterPose& pose, int frame, const LandmarkPrior& prior,
              bool is_free) {
  const auto here = initialise(setup_.camera, functions_.point, pose.orientation, z.pixel,
                               state_.scene ? state_.scene->inverse_depth : prior.inverse_depth);
  if (!here) return false;
  const NewLandmark at = linearisation_.birth(state_, setup_.camera, z, frame, *here);
  anchor_at(pose, frame);
  insert(z.track, frame, here->y, append_new(z, at, pose, prior, is_free ? functions_.dim() : 3));
  return true;
}

// Without a positive diagonal nothing that follows means anything; what is held has a negative one.
void Ekf::finish() {
  const auto diagonal = state_.covariance.diagonal();
  const StateBlock adjoint = state_.passive.adjoint();  // no covariance stands there
  const auto negative = [](const auto& d) { return (d.array() < 0.0).count(); };
  Eigen::Index held = 0;
  for (const auto& [track, landmark] : state_.landmarks) {
    const StateBlock block = landmark.held_block;
    if (landmark.is_held()) held += negative(diagonal.segment(block.offset, block.dim));
  }
  if (!diagonal.allFinite() || negative(diagonal.head(adjoint.offset)) +
                                       negative(diagonal.tail(diagonal.size() - adjoint.end())) !=
                                   held) {
    throw Diverged("the covariance has a negative or infinite variance");
  }
}

CameraEstimate Ekf::camera() const {
  return {0.0, state_.camera, state_.covariance.block(JointState::kCamera, JointState::kCamera)};
}

FilterPose& Ekf::clone_of(int frame) {
  return state_.clones[static_cast<std::size_t>(frame) % state_.clones.size()];
}

std::optional<PoseEstimate> Ekf::pose_before(int frames) const {
  if (frames > options_.lag || frames >= frames_) return std::nullopt;
  const auto at = static_cast<std::size_t>(frames_ - frames) % state_.clones.size();
  const FilterPose& clone = state_.clones[at];
  return PoseEstimate{clone.position, clone.orientation,
                      state_.covariance.block(clone.block, clone.block)};
}

void Ekf::points(std::vector<LandmarkPoint>& result) {
  state_.correct_passive();
  result.clear();
  for (const auto& [track, landmark] : state_.landmarks) {
    result.push_back({track, state_.anchors.at(landmark.anchor).position, landmark.y});
  }
}

std::vector<LandmarkBelief> Ekf::landmarks(std::span<const int> tracks) const {
  std::vector<LandmarkBelief> result;
  for (const int track : tracks) {
    const FilterLandmark& landmark = state_.landmarks.at(track);
    result.push_back({state_.anchors.at(landmark.anchor).position, landmark.y, landmark.w,
                      state_.marginal(landmark)});
  }
  return result;
}

std::unique_ptr<Estimator> make_ekf(const Setup& setup, const ModelOptions& models,
                                    const EkfOptions& options) {
  return std::make_unique<FrameLoop>(
      setup, models, [=] { return std::make_unique<Ekf>(setup, models, options); },
      options.linearisation == FilterLinearisation::kIdeal ? setup.truth : nullptr);
}

}  // namespace slammot
