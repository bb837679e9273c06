#include "smoothers/window/window.h"

#include "estimation/frame_loop.h"
#include "models/initialisation.h"
#include "smoothers/window/robust_loss.h"
#include "smoothers/window/window_belief.h"

namespace slammot {
namespace {

// Whether Jacobians are taken at fixed points.
bool fixed_points(WindowLinearisation linearisation) {
  return linearisation != WindowLinearisation::kStandard;
}

}  // namespace

std::shared_ptr<const Truth> truth_of(const Setup& setup, const WindowOptions& options) {
  if (options.linearisation != WindowLinearisation::kIdeal) return nullptr;
  if (!setup.truth) {
    throw std::invalid_argument("linearisation ideal needs the exact truth of a simulation");
  }
  return setup.truth;
}

Window::Window(const Setup& setup, const ModelOptions& models, const WindowOptions& options,
               TrackHistories* histories)
    : setup_(setup),
      options_(options),
      condition_(models.collapse == Collapse::kCondition),
      functions_(find_landmark(models.landmark)),
      loss_(make_loss(options.loss)),
      graph_({setup.camera, setup.pixel_sigma, setup.prior, &functions_, loss_.get()},
             fixed_points(options.linearisation)),
      cameras_(graph_, truth_of(setup, options)),
      truth_(truth_of(setup, options), graph_, cameras_),
      optimiser_(truth_ ? StepRule::kEvery : StepRule::kDescent),
      histories_(histories),
      gate_(models.gate_probability, setup.pixel_sigma) {
  if (options.solver == WindowSolver::kCeres && graph_.fixed_points()) {
    throw std::invalid_argument(
        "window.solver ceres minimises the cost: it needs window.linearisation standard");
  }
  if (options.prior == WindowPrior::kCameras && !condition_) {
    throw std::invalid_argument(
        "window.prior cameras needs collapse condition: drop keeps landmarks in the prior");
  }
  if (setup.prior.mean_sigma > 0.0) graph_.add_scene(setup.prior);
}

// With `window.prior=cameras` those that were born in the frame that is about to leave.
void Window::leaving(std::vector<int>& tracks) {
  tracks.clear();
  const bool is_full = std::ssize(cameras_.frames()) == options_.frames;
  if (options_.prior != WindowPrior::kCameras || !is_full) return;
  for (const auto& [track, landmark] : landmarks_) {
    if (graph_[landmark.id].anchor == cameras_.oldest().camera.position) tracks.push_back(track);
  }
}

// Thesis 2.1.1 and (2.5): the new camera enters at its prediction, with its motion factor, and the
// chain of each free landmark grows.
void Window::predict(const Frame& frame, double dt) {
  if (dt == 0.0) {
    cameras_.start(frame, setup_.initial);
    return refactorise();
  }
  cameras_.advance(frame, dt, setup_.camera_noise);
  const CameraMotionFactor& motion = graph_.motions.back();
  const Matrix12d J_inverse = motion.J_to.inverse();
  F_ = -J_inverse * motion.J_from;
  Q_ = J_inverse * J_inverse.transpose();
  for (auto& [track, landmark] : landmarks_) {
    if (landmark.is_free) extend(landmark, dt);
  }
}

void Window::add_known(const KnownLandmark& known) {
  const VariableId anchor = cameras_.newest().camera.position;
  const Eigen::Vector3d y = initialise_known(known, graph_.variables[anchor].value).y;
  const WindowLandmark& landmark = insert(known.track, anchor, y);
  if (histories_) histories_->begin(known.track, cameras_.newest().number, true);
  GraphLandmark& l = graph_[landmark.id];
  l.birth.kind = BirthPrior::Kind::kKnown;
  l.birth.known = known;
  truth_.apply(landmark);
  graph_.linearise(l);
}

void Window::innovations(std::span<const Observation> measured,
                         std::vector<PixelInnovation>& result) {
  result.clear();
  measured_.clear();
  for (const Observation& z : measured) measured_.push_back(z.track);
  prepare(measured_);
  for (const Observation& z : measured) {
    if (const auto found = innovation(z)) result.push_back(*found);
  }
  if (!options_.retest) return;
  gated_.clear();
  for (const PixelInnovation& innovation : result) gated_.push_back(innovation.z);
}

std::optional<PixelInnovation> Window::innovation(const Observation& z) const {
  const WindowLandmark& landmark = landmarks_.at(z.track);
  const GraphLandmark& l = graph_[landmark.id];
  const CameraState x = cameras_.state(cameras_.newest());
  const auto h = expect(setup_.camera, x.position, x.orientation, graph_.value(l.anchor),
                        graph_.newest_state(l).head<3>());
  if (!h) return std::nullopt;
  PixelInnovation result{z, z.pixel - h->pixel, Eigen::Matrix2d::Zero()};
  const ObservedPixel at = truth_ ? truth_.observe(landmark).value_or(*h) : *h;
  if (l.anchor == cameras_.newest().camera.position) {
    result.HPHt = innovation_of_new(landmark, at);
    return result;
  }
  const JointMatrix P = joint(landmark);
  Eigen::Matrix<double, 2, kCameraDim + 6> H;
  H << at.J_pose * F_.topRows<6>(), at.J_anchor, at.J_y;
  const auto P_seen = P.topLeftCorner<kCameraDim + 6, kCameraDim + 6>();
  result.HPHt =
      H * P_seen * H.transpose() + at.J_pose * Q_.topLeftCorner<6, 6>() * at.J_pose.transpose();
  return result;
}

// A landmark known beforehand, at its first sight: y follows from its position and the camera.
Eigen::Matrix2d Window::innovation_of_new(const WindowLandmark& landmark,
                                          const ObservedPixel& h) const {
  const GraphLandmark& l = graph_[landmark.id];
  const Eigen::Matrix3d J_y_position =
      initialise_known(l.birth.known, graph_.variables[l.anchor].point()).J_y_position;
  const Matrix23d J_position = h.J_y * J_y_position;
  Eigen::Matrix<double, 2, kCameraDim> H = Eigen::Matrix<double, 2, kCameraDim>::Zero();
  H.leftCols<6>() = h.J_pose;
  H.leftCols<3>() += h.J_anchor - J_position;
  const Matrix12d P = F_ * optimiser_.equations().camera_covariance() * F_.transpose() + Q_;
  return H * P * H.transpose() +
         std::pow(l.birth.known.sigma, 2) * J_position * J_position.transpose();
}

// What leaves the window waited for this: the frame's measurements must not be used before.
void Window::update(const TrackRecords& /*records*/, std::span<const Observation> accepted,
                    StageListener& stages) {
  stages.begin("marginalise");
  marginalise();
  reactivate_measured();
  stages.begin("update");
  used_.clear();
  const WindowFrame& newest = cameras_.newest();
  for (const Observation& z : accepted) {
    WindowLandmark& landmark = landmarks_.at(z.track);
    landmark.last_used = newest.index;
    const int depth = landmark.is_free ? graph_[landmark.id].steps() : 0;
    graph_.add_pixel(landmark.id, newest.camera, z.pixel, depth);
    used_.push_back(z.track);
    if (histories_) histories_->measured(z.track, newest.number, z.pixel);
  }
  refresh_noises();
  solve();
  if (options_.retest) {
    note_refused(accepted);
    if (retest()) solve();
  }
  estimate_camera();
}

// With r the residual that is left and I - J P J' its covariance, r' (I - J P J')^-1 r is the NIS
// given all other measurements, as the EKF has it from its innovations (mathematics.md).
void Window::leave_one_out(std::vector<LeaveOneOut>& result) {
  result.clear();
  prepare(used_);
  for (const int track : used_) {
    const WindowLandmark& landmark = landmarks_.at(track);
    const GraphPixel& pixel = graph_[landmark.id].pixels.back();
    if (landmark.is_free || !pixel.valid) continue;
    Eigen::Matrix<double, 2, kCameraDim + 6> J = Eigen::Matrix<double, 2, kCameraDim + 6>::Zero();
    J.leftCols<6>() = pixel.at.J_pose;
    J.rightCols<6>() << pixel.at.J_anchor, pixel.at.J_y;
    const auto P = optimiser_.equations().joint(landmark.id);
    const Eigen::Matrix2d own =
        Eigen::Matrix2d::Identity() -
        J * P.topLeftCorner<kCameraDim + 6, kCameraDim + 6>() * J.transpose();
    result.push_back({track, pixel.at.r.dot(own.inverse() * pixel.at.r)});
  }
}

void Window::inverse_depths(std::span<const int> tracks, std::vector<SeenDepth>& result) {
  result.clear();
  prepare(tracks);
  constexpr int kRho = kCameraDim + 5;
  for (const int track : tracks) {
    const WindowLandmark& landmark = landmarks_.at(track);
    result.push_back({graph_.value(graph_[landmark.id].y)(2),
                      std::sqrt(optimiser_.equations().joint(landmark.id)(kRho, kRho))});
  }
}

void Window::motions(std::span<const int> tracks, std::vector<MotionBelief>& result) {
  result.clear();
  prepare(tracks);
  for (const int track : tracks) {
    const WindowLandmark& landmark = landmarks_.at(track);
    const LandmarkVector x = graph_.newest_state(graph_[landmark.id]);
    MotionBelief& motion = result.emplace_back();
    motion.track = track;
    motion.w = x.tail(functions_.motion);
    motion.density_scale = functions_.density_scale(x);
    motion.covariance = joint(landmark).bottomRightCorner(functions_.motion, functions_.motion);
  }
}

// `condition` states that they never moved: their window's measurements change, and with them the
// estimate. `drop` marginalises w, at the next update.
void Window::collapse(std::span<const int> tracks) {
  for (const int track : tracks) {
    WindowLandmark& landmark = landmarks_.at(track);
    if (histories_) {
      std::vector<LandmarkVector> states = graph_.states(graph_[landmark.id]);
      states.pop_back();
      histories_->passed(track, states);
    }
    landmark.is_free = false;
    landmark.base = cameras_.newest().camera.position;
    if (condition_) {
      graph_.condition_on_rest(landmark.id);
      truth_.apply(landmark);
    } else {
      landmark.drops = true;
      forget_refused(track);  // they are of its time as a free landmark
    }
  }
  if (!condition_) return;
  graph_.prior().relinearise();
  optimiser_.take_step(graph_, cameras_.newest().camera);
  estimate_camera();
}

// y stays what it is, at the newest frame, where a chain begins.
void Window::free(int track, const LandmarkPrior& prior) {
  WindowLandmark& landmark = landmarks_.at(track);
  if (landmark.drops) {
    marginalise_drops();
    refactorise();
  }
  if (histories_) histories_->rested_until(track, cameras_.newest().number, at_rest(landmark));
  landmark.base = cameras_.newest().camera.position;
  landmark.is_free = true;
  graph_.free_landmark(landmark.id, functions_.prior_sigmas(prior));
  truth_.apply(landmark);
}

// Its measurements stay in the window until they leave.
void Window::remove(std::span<const int> tracks, const TrackRecords& records) {
  for (const int track : tracks) {
    WindowLandmark& landmark = landmarks_.at(track);
    if (histories_) end_history(landmark, records.at(track));
    const VariableId y = graph_[landmark.id].y;
    if (is_inactive(y)) {
      graph_.prior().inactive.forget({y});
      graph_.variables.remove(y);
      graph_.remove_landmark(landmark.id);
    } else {
      if (landmark.is_free) {
        end_chain(landmark);
      } else {
        // The last frame that can have measured it.
        landmark.base = cameras_.newest().camera.position;
      }
      pruned_.push_back(landmark);
    }
    forget_refused(track);
    landmarks_.erase(track);
  }
}

// Thesis 2.1.3, (2.7), as factors: the first pixel, and the priors of inverse depth and motion.
bool Window::add(const Observation& z, const LandmarkPrior& prior, bool is_free) {
  const WindowFrame& newest = cameras_.newest();
  const auto& scene = graph_.scene;
  const double depth = scene ? graph_.variables[scene->scene].value(0) : prior.inverse_depth;
  const auto here = initialise(setup_.camera, cameras_.state(newest).orientation, z.pixel, depth);
  if (!here) return false;
  WindowLandmark& landmark = insert(z.track, newest.camera.position, here->y);
  if (histories_) histories_->begin(z.track, newest.number, false);
  if (histories_) histories_->measured(z.track, newest.number, z.pixel);
  GraphLandmark& l = graph_[landmark.id];
  l.birth.kind = scene ? BirthPrior::Kind::kSharedDepth : BirthPrior::Kind::kDepth;
  l.birth.inverse_depth = prior.inverse_depth;
  l.birth.sigma = prior.inverse_depth_sigma;
  l.birth.scene = scene ? scene->scene : -1;
  graph_.add_pixel(landmark.id, newest.camera, z.pixel, 0);
  landmark.is_free = is_free;
  if (is_free) graph_.free_landmark(landmark.id, functions_.prior_sigmas(prior));
  truth_.apply(landmark);
  graph_.linearise(l);
  optimiser_.equations().add(graph_, landmark.id);
  return true;
}

WindowLandmark& Window::insert(int track, VariableId anchor, const Eigen::Vector3d& y) {
  WindowLandmark& landmark = landmarks_[track];
  landmark = {};
  landmark.track = track;
  landmark.id = graph_.add_landmark(anchor, y);
  landmark.last_used = cameras_.newest().index;
  landmark.base = anchor;
  return landmark;
}

int Window::state_size() const {
  int size = graph_.prior().inactive.dim();
  graph_.variables.for_each([&](const Variable& v) { size += v.dim(); });
  for (const GraphLandmark& l : graph_.landmarks) {
    if (l.is_alive) size += l.steps() * functions_.dim();
  }
  return size;
}

void Window::points(std::vector<LandmarkPoint>& result) {
  result.clear();
  const auto& [prior, inactive] = graph_.prior();
  inactive.values(prior.difference(), inactive_values_);
  const auto value = [&](VariableId id) -> Eigen::Vector3d {
    const Variable& v = graph_.variables[id];
    if (!v.is_active) return inactive_values_[id];
    return v.value;
  };
  for (const auto& [track, landmark] : landmarks_) {
    const GraphLandmark& l = graph_[landmark.id];
    result.push_back(
        {track, value(l.anchor), l.is_free() ? graph_.newest_state(l).head<3>() : value(l.y)});
  }
}

std::vector<LandmarkBelief> Window::landmarks(std::span<const int> tracks) const {
  std::vector<LandmarkBelief> beliefs;
  prepare(tracks);
  for (const int track : tracks) {
    const WindowLandmark& landmark = landmarks_.at(track);
    const GraphLandmark& l = graph_[landmark.id];
    const LandmarkVector x = graph_.newest_state(l);
    const Eigen::Index motion = landmark.is_free ? functions_.motion : 0;
    LandmarkBelief& belief = beliefs.emplace_back();
    belief.anchor = graph_.value(l.anchor);
    belief.y = x.head<3>();
    belief.w = x.tail(x.size() - 3).head(motion);
    belief.covariance = joint(landmark).block(kCameraDim, kCameraDim, 6 + motion, 6 + motion);
  }
  return beliefs;
}

std::unique_ptr<Estimator> make_window(const Setup& setup, const ModelOptions& models,
                                       const WindowOptions& options) {
  return std::make_unique<FrameLoop>(
      setup, models, std::make_unique<Window>(setup, models, options), truth_of(setup, options));
}

}  // namespace slammot
