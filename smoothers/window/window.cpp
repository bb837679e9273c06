#include "smoothers/window/window.h"

#include "estimation/loop/frame_loop.h"
#include "models/points/initialisation.h"
#include "smoothers/graph/noise_scale.h"
#include "smoothers/window/robust_loss.h"
#include "smoothers/window/window_belief.h"

namespace slammot {
namespace {

// Whether Jacobians are taken at fixed points.
bool fixed_points(WindowLinearisation linearisation) {
  return linearisation != WindowLinearisation::kStandard;
}

// Solutions of a frame after which measurements at a pole are left out; more wait for the next.
constexpr int kMostPoles = 3;

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
      functions_(find_landmark(models.landmark, models.point)),
      memory_(motion_memory(models, functions_)),
      loss_(make_loss(options.loss)),
      graph_({setup.camera, setup.pixel_sigma, setup.prior, &functions_, loss_.get(),
              options.solver == WindowSolver::kCeres || noise_tells_scale(setup)},
             fixed_points(options.linearisation)),
      cameras_(graph_, truth_of(setup, options)),
      truth_(truth_of(setup, options), graph_, cameras_),
      optimiser_(truth_ || options.iterations == 1 ? StepRule::kEvery : StepRule::kDescent),
      histories_(histories),
      threshold_given_others_(pixel_threshold(models.gate.given_others)) {
  if (options.solver == WindowSolver::kCeres && graph_.fixed_points()) {
    throw std::invalid_argument(
        "window.solver ceres minimises the cost: it needs window.linearisation standard");
  }
  if (options.prior == WindowPrior::kCameras && !condition_) {
    throw std::invalid_argument(
        "window.prior cameras needs collapse condition: drop keeps landmarks in the prior");
  }
  if (models.policy.probation > 1 && graph_.fixed_points()) {
    throw std::invalid_argument("policy.probation above 1 needs window.linearisation standard");
  }
  if (models.policy.probation > options.frames) {
    throw std::invalid_argument("policy.probation must not exceed window.frames");
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
void Window::predict(const Frame& frame, double dt, const MotionNoise& noise,
                     const TrackRecords& records) {
  if (dt == 0.0) {
    cameras_.start(frame, setup_.initial);
    return refactorise();
  }
  cameras_.advance(frame, dt, noise);
  if (histories_) noises_.push_back(noise);
  const CameraMotionFactor& motion = graph_.motions.back();
  const Matrix12d J_inverse = motion.J_to.inverse();
  F_ = -J_inverse * motion.J_from;
  Q_ = J_inverse * J_inverse.transpose();
  for (auto& [track, landmark] : landmarks_) {
    if (landmark.is_free) extend(landmark, records.at(track).label, dt);
  }
}

void Window::widen(double factor) {
  graph_.widen_newest_motion(factor);
  Q_ *= factor;
  if (histories_) noises_.back() = scaled(noises_.back(), factor);
}

void Window::add_known(const KnownLandmark& known) {
  const VariableId anchor = cameras_.newest().camera.position;
  const Eigen::Vector3d y =
      initialise_known(functions_.point, known, graph_.variables[anchor].value).y;
  WindowLandmark& landmark = insert(known.track, anchor, y);
  landmark.is_entering = true;
  GraphLandmark& l = graph_[landmark.id];
  l.birth.kind = BirthPrior::Kind::kKnown;
  l.birth.known = known;
  if (histories_) histories_->begin(known.track, cameras_.newest().number, l.birth);
  truth_.apply(landmark);
  graph_.linearise(l);
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
    graph_.add_pixel(landmark.id, newest.camera, z, depth);
    used_.push_back(z.track);
    if (histories_) histories_->measured(z, newest.number);
  }
  refresh_noises();
  solve();
  for (int i = 0; i < kMostPoles && leave_out_poles(); ++i) solve();
  for (auto& [track, landmark] : landmarks_) landmark.is_entering = false;
  if (options_.retest) {
    note_refused(accepted);
    if (retest()) solve();
  }
  estimate_camera();
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
    landmark.rests_since = cameras_.newest().number;
    landmark.rest_time = cameras_.find(landmark.base)->timestamp;
    landmark.base = cameras_.newest().camera.position;
    if (condition_) {
      graph_.hold_at_rest(landmark.id);
      if (memory_ == 0) graph_.forget_held(landmark.id);
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
  landmark.rests_since.reset();
  graph_.forget_held(landmark.id);
  graph_.free_landmark(landmark.id, functions_.prior_sigmas(prior));
  truth_.apply(landmark);
}

// Its measurements stay in the window until they leave.
void Window::remove(std::span<const int> tracks, const TrackRecords& records) {
  for (const int track : tracks) {
    WindowLandmark& landmark = landmarks_.at(track);
    graph_.forget_held(landmark.id);
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
  WindowLandmark* landmark = insert_at(newest, z, prior, is_free);
  if (landmark == nullptr) return false;
  if (histories_) {
    histories_->begin(z.track, newest.number, graph_[landmark->id].birth);
    histories_->measured(z, newest.number);
  }
  truth_.apply(*landmark);
  graph_.linearise(graph_[landmark->id]);
  optimiser_.equations().add(graph_, landmark->id);
  return true;
}

// Its factors, not linearised yet; none when the pixel has no ray.
WindowLandmark* Window::insert_at(const WindowFrame& frame, const Observation& z,
                                  const LandmarkPrior& prior, bool is_free) {
  const auto& scene = graph_.scene;
  const double depth = scene ? graph_.variables[scene->scene].value(0) : prior.inverse_depth;
  const auto here = initialise(setup_.camera, functions_.point, cameras_.state(frame).orientation,
                               z.pixel, depth);
  if (!here) return nullptr;
  WindowLandmark& landmark = insert(z.track, frame.camera.position, here->y);
  GraphLandmark& l = graph_[landmark.id];
  l.birth.kind = scene ? BirthPrior::Kind::kSharedDepth : BirthPrior::Kind::kDepth;
  l.birth.inverse_depth = prior.inverse_depth;
  l.birth.spread = {prior.inverse_depth_sigma, scene && prior.spread_follows_mean ? depth : 0.0};
  l.birth.scene = scene ? scene->scene : -1;
  graph_.add_pixel(landmark.id, frame.camera, z, 0);
  landmark.is_free = is_free;
  if (is_free) graph_.free_landmark(landmark.id, functions_.prior_sigmas(prior));
  return &landmark;
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

std::unique_ptr<Estimator> make_window(const Setup& setup, const ModelOptions& models,
                                       const WindowOptions& options) {
  return std::make_unique<FrameLoop>(
      setup, models, [=] { return std::make_unique<Window>(setup, models, options); },
      truth_of(setup, options));
}

}  // namespace slammot
