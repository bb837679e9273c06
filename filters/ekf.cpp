#include "filters/ekf.h"

#include <algorithm>

#include "estimation/loop/frame_loop.h"
#include "estimation/modules/label_revision.h"
#include "models/points/initialisation.h"

namespace slammot {

namespace {

// The gauge's errors are kept where Jacobians are taken at the estimate, once a frame.
bool can_keep_gauge(const EkfOptions& options) {
  return options.linearisation == FilterLinearisation::kStandard && options.iterations == 1;
}

bool has_second_order(const EkfOptions& options) {
  return options.second_order && options.linearisation != FilterLinearisation::kIdeal;
}

std::string_view name_of(FilterLinearisation linearisation) {
  constexpr std::string_view kNames[] = {"standard", "fej", "ideal"};
  return kNames[static_cast<std::size_t>(linearisation)];
}

std::string without_effect(const EkfOptions& options) {
  if (options.linearisation != FilterLinearisation::kStandard) {
    return "ekf.linearisation=" + std::string(name_of(options.linearisation));
  }
  return "ekf.iterations=" + std::to_string(options.iterations);
}

}  // namespace

void check_options(const EkfOptions& options) {
  if (options.lag > 0 && options.linearisation == FilterLinearisation::kFej) {
    throw std::invalid_argument("ekf.lag needs ekf.linearisation standard or ideal");
  }
}

Ekf::Ekf(const Setup& setup, const ModelOptions& models, const EkfOptions& options)
    : setup_(setup),
      rig_(setup.rig()),
      options_(options),
      gauge_(models.gauge),
      functions_(find_landmark(models.landmark, models.point)),
      condition_(models.collapse == Collapse::kCondition),
      remembers_(motion_memory(models, functions_) > 0),
      devices_{functions_, Linearisation(options.linearisation, functions_, setup.truth), {}} {
  if (gauge_ != Gauge::kNone && can_keep_gauge(options)) {
    devices_.gauge.emplace(gauge_, functions_, setup.knows_scale());
  }
  if (has_second_order(options)) {
    devices_.second_order = setup.measures_scale ? SecondOrder::kCommon : SecondOrder::kOwn;
  }
  state_.camera = setup.initial.state;
  state_.covariance.append({}, setup.initial.sigmas().cwiseAbs2().asDiagonal().toDenseMatrix());
  const LandmarkPrior& prior = setup.prior;
  if (prior.mean_sigma > 0.0) {
    const Eigen::MatrixXd variance =
        Eigen::MatrixXd::Constant(1, 1, prior.mean_sigma * prior.mean_sigma);
    state_.scene = {prior.inverse_depth, state_.covariance.append({}, variance)};
  }
  for (int i = 0; i < options.lag; ++i) {
    state_.clones.emplace_back().block = state_.covariance.append({}, Matrix6d::Zero());
  }
}

// Thesis 2.1.1 for the camera, (2.5) for what may move; a static landmark is not predicted (3.1.3).
void Ekf::predict(const Frame& frame, double dt, const MotionNoise& noise,
                  const TrackRecords& records) {
  frame_ = frame.index;
  ++frames_;
  if (dt == 0.0) return;
  state_.time += dt;
  if (!state_.clones.empty()) state_.clone_pose(clone_of(frames_ - 1));
  const CameraState at = devices_.linearisation.camera(state_);
  camera_noise_ = camera_noise(noise, at, dt);
  state_.covariance.propagate({JointState::kCamera}, predict_jacobian(at, dt), camera_noise_);
  state_.camera = slammot::predict(state_.camera, dt);
  for (auto& [track, landmark] : state_.landmarks) {
    if (landmark.is_free()) predict_landmark(track, landmark, records.at(track).label, dt);
  }
  devices_.linearisation.predicted(state_, frame.index, dt);
}

void Ekf::add_known(const KnownLandmark& known) {
  // From here on the translation is known from elsewhere (second_order.h).
  if (devices_.second_order == SecondOrder::kOwn) devices_.second_order = SecondOrder::kCommon;
  const FilterAnchor& anchor = anchor_here();
  const NewKnownLandmark here = initialise_known(functions_.point, known, anchor.position);
  const Eigen::MatrixXd J =
      devices_.linearisation.known_birth(state_, known, frame_, here).J_y_position;
  const double variance = known.sigma * known.sigma;
  const StateBlock block =
      state_.covariance.append({{anchor.block, -J}}, variance * J * J.transpose());
  insert(known.track, here.y, block);
}

void Ekf::innovations(std::span<const Observation> measured, FrameInnovation& result) {
  linearise(state_, devices_, rig_, measured, innovation_);
  result.z = innovation_.matches;
  result.nu = innovation_.nu;
  fill_HPHt(state_, innovation_, result.HPHt);
}

void Ekf::widen(double factor) {
  state_.covariance.propagate({JointState::kCamera}, Matrix12d::Identity(),
                              (factor - 1.0) * camera_noise_);
  camera_noise_ *= factor;
}

void Ekf::predict_pixels(std::span<const int> tracks, std::vector<Prediction>& result) {
  result.clear();
  for (const int track : tracks) {
    const auto expected = predict_pixel(state_, devices_, rig_, track);
    if (expected) result.push_back(*expected);
  }
}

// One update for all, but for what is considered only, after the others.
void Ekf::update(std::span<const Observation> accepted, std::span<const int> considered,
                 StageListener& /*stages*/) {
  counting_.clear();
  considered_.clear();
  for (const Observation& z : accepted) {
    state_.landmarks.at(z.track).last_used = frames_;
    const bool is_considered = std::ranges::binary_search(considered, z.track);
    (is_considered ? considered_ : counting_).push_back(z);
  }
  updates_ += counting_.empty() ? 0 : 1;
  keep(counting_, innovation_);
  slammot::update(state_, devices_, rig_, setup_.pixel_sigma, options_.iterations, innovation_);
  update_considered(state_, devices_, rig_, considered_, setup_.pixel_sigma, of_considered_);
}

void Ekf::leave_one_out(std::vector<LeaveOneOut>& result) { nis_given_others(innovation_, result); }

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
    const StateBlock y = landmark.y_block, w = landmark.w_block;
    const JointCovariance& P = state_.covariance;
    LandmarkMatrix of_x(functions_.dim(), functions_.dim());
    of_x << P.block(y, y), P.block(y, w), P.block(w, y), P.block(w, w);
    result.push_back(motion_belief(track, functions_, landmark.x(), of_x));
  }
}

void Ekf::collapse(std::span<const int> tracks) {
  if (condition_) {
    if (devices_.gauge) devices_.gauge->collapse(state_, tracks);
    condition_on_rest(tracks);
  }
  for (const int track : tracks) state_.drop_motion(track);  // unless it is constrained
}

void Ekf::free(int track, const LandmarkPrior& prior) {
  state_.forget_motion(track);
  state_.free_motion(track, functions_.prior_sigmas(prior));
}

void Ekf::remove(std::span<const int> tracks, const TrackRecords& /*records*/) {
  state_.remove_landmarks(tracks);
}

// Thesis 2.1.3, (2.7): y from pixel, rotation and prior, with its full cross-covariance.
bool Ekf::add(const FirstSight& seen, const LandmarkPrior& prior, bool is_free) {
  const bool is_shared = state_.scene && !seen.has_own_depth;
  const double depth = is_shared                 ? state_.scene->inverse_depth
                       : seen.is_of_one_camera() ? seen.prior.inverse_depth
                                                 : seen.inverse_depth;
  const auto here =
      initialise(setup_.camera, functions_.point, state_.camera.orientation, seen.pixel, depth);
  if (!here) return false;
  const NewLandmark at = devices_.linearisation.birth(state_, setup_.camera, seen, frame_, *here);
  anchor_here();
  insert(seen.z.track, here->y, append_new(seen, at, prior, is_free ? functions_.dim() : 3));
  return true;
}

// Without a positive diagonal nothing that follows means anything; that of a constrained motion is
// negative.
void Ekf::finish() {
  const auto diagonal = state_.covariance.diagonal();
  Eigen::Index negative = (diagonal.array() < 0.0).count();
  for (const auto& [track, landmark] : state_.landmarks) {
    const StateBlock block = landmark.constrained_block;
    negative -= (diagonal.segment(block.offset, block.dim).array() < 0.0).count();
  }
  if (!diagonal.allFinite() || negative != 0) {
    throw Diverged("the covariance has a negative or infinite variance");
  }
}

void Ekf::in_force(InForce& result) const {
  const bool keeps = can_keep_gauge(options_), second = has_second_order(options_);
  const auto gauge = [&](const char* name, Gauge which) {
    const bool is_on = keeps && gauge_ == which;
    const bool is_kept_off = gauge_ == which && !keeps;
    result.push_back(
        {name, "gauge", is_on, is_kept_off ? without_effect(options_) : "", is_on ? updates_ : 0});
  };
  gauge("scale kept while the estimate moves", Gauge::kScale);
  gauge("heading kept while the estimate moves", Gauge::kHeading);
  result.push_back({"noise of second order", "ekf.second_order", second,
                    options_.second_order && !second ? without_effect(options_) : "",
                    second ? updates_ : 0});
  const bool fej = options_.linearisation == FilterLinearisation::kFej;
  result.push_back({"first-estimate Jacobians", "ekf.linearisation", fej, "", fej ? updates_ : 0});
  const bool iterates = options_.iterations > 1;
  result.push_back({"iterated update", "ekf.iterations", iterates, "", iterates ? updates_ : 0});
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
  check_options(options);
  return std::make_unique<FrameLoop>(
      setup, models, std::make_unique<Ekf>(setup, models, options),
      options.linearisation == FilterLinearisation::kIdeal ? setup.truth : nullptr);
}

}  // namespace slammot
