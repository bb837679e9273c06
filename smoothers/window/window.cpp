#include "smoothers/window/window.h"

#include "estimation/frame_loop.h"
#include "models/initialisation.h"
#include "smoothers/factors/factors.h"
#include "smoothers/window/robust_loss.h"
#include "smoothers/window/window_belief.h"

namespace slammot {
namespace {

// Whether Jacobians are taken at fixed points.
bool first_estimates(WindowLinearisation linearisation) {
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
      graph_(first_estimates(options.linearisation)),
      cameras_(graph_, truth_of(setup, options)),
      truth_(truth_of(setup, options), functions_, setup.prior, graph_, cameras_),
      free_landmarks_(setup_, functions_, loss_.get(), truth_, graph_),
      scene_(add_scene(graph_, setup.prior)),
      histories_(histories) {}

// Thesis 2.1.1 and (2.5): the new camera enters at its prediction, with its motion factor. The
// oldest frame leaves, and what is measured again returns.
void Window::predict(const Frame& frame, double dt, StageListener& stages) {
  if (dt == 0.0) return cameras_.start(frame, setup_.initial);
  cameras_.advance(frame, dt, setup_.camera_noise);
  for (auto& [track, landmark] : landmarks_) {
    if (landmark.w) free_landmarks_.extend(landmark, dt);
  }
  stages.begin("marginalise");
  marginalise_oldest();
  reactivate_measured(frame);
}

void Window::add_known(const KnownLandmark& known) {
  WindowLandmark& landmark = insert(known.track);
  if (histories_) histories_->begin(known.track, cameras_.newest().number, true);
  const Eigen::Vector3d y = initialise_known(known, graph_.value(landmark.anchor)).y;
  landmark.y = graph_.add_variable(y, nullptr, known.track);
  truth_.apply(landmark);
  cameras_.newest().birth_priors.insert(
      graph_.add_factor({landmark.anchor, landmark.y}, known_landmark_cost(known)));
}

void Window::innovations(std::span<const Observation> measured,
                         std::vector<PixelInnovation>& result) {
  result.clear();
  std::vector<StateProjection> H;
  const WindowFrame& newest = cameras_.newest();
  const CameraState x = cameras_.state(newest);
  for (const Observation& z : measured) {
    const WindowLandmark& l = landmarks_.at(z.track);
    const ChainState landmark = newest_state(graph_, l);
    const auto h = expect(setup_.camera, x.position, x.orientation, graph_.value(l.anchor),
                          landmark.x.head<3>());
    if (!h) continue;
    result.push_back({z, z.pixel - h->pixel, Eigen::Matrix2d::Zero()});
    StateProjection& form = H.emplace_back();
    form.variables = {newest.position, newest.motion, l.anchor};
    for (const VariableId id : state_variables(l)) form.variables.push_back(id);
    form.J.setZero(2, 15 + landmark.J.cols());
    const ObservedPixel at = truth_ ? truth_.observe(setup_.camera, l).value_or(*h) : *h;
    form.J.leftCols<6>() = at.J_pose;
    form.J.middleCols<3>(12) = at.J_anchor;
    form.J.rightCols(landmark.J.cols()) = at.J_y * landmark.J.topRows<3>();
  }
  if (H.empty()) return;
  const std::vector<Eigen::MatrixXd> HPHt = NormalEquations(graph_).covariances(H);
  for (std::size_t i = 0; i < result.size(); ++i) result[i].HPHt = HPHt[i];
}

void Window::update(const TrackRecords& /*records*/, std::span<const Observation> accepted) {
  add_measurements(accepted);
  refresh_noises();
  optimum_ = optimise(graph_, options_.iterations, options_.cost_tolerance);
  estimate_camera();
}

void Window::add_measurements(std::span<const Observation> accepted) {
  used_.clear();
  const WindowFrame& newest = cameras_.newest();
  for (const Observation& z : accepted) {
    WindowLandmark& l = landmarks_.at(z.track);
    l.last_used = newest.index;
    const auto depth = static_cast<int>(l.noises.size());
    const WindowPixel pixel =
        free_landmarks_.measure(l, {newest.position, newest.motion, z.pixel, depth});
    used_.push_back({z.track, pixel.factor});
    if (l.w) l.pixels.push_back(pixel);
    if (histories_) histories_->measured(z.track, newest.number, z.pixel);
  }
}

double Window::refresh_noises() {
  double change = 0.0;
  for (auto& [track, l] : landmarks_) change = std::max(change, free_landmarks_.refresh_noises(l));
  for (WindowLandmark& l : pruned_) change = std::max(change, free_landmarks_.refresh_noises(l));
  return change;
}

// With r the residual that is left and I - J P J' its covariance, r' (I - J P J')^-1 r is the NIS
// given all other measurements, as the EKF has it from its innovations (mathematics.md).
void Window::leave_one_out(std::vector<LeaveOneOut>& result) {
  result.clear();
  std::vector<Eigen::Vector2d> residuals;
  std::vector<StateProjection> forms;
  for (const Used& used : used_) {
    const Factor& factor = graph_.factors().at(used.factor);
    if (landmarks_.at(used.track).w || !factor.valid) continue;
    result.push_back({used.track, 0.0});
    residuals.emplace_back(factor.r);
    forms.push_back({factor.variables, before_last_step(factor)});
  }
  const std::vector<Eigen::MatrixXd> JPJt = optimum_->equations.covariances(forms);
  for (std::size_t i = 0; i < forms.size(); ++i) {
    const Eigen::Matrix2d own = Eigen::Matrix2d::Identity() - JPJt[i];
    result[i].nis = residuals[i].dot(own.inverse() * residuals[i]);
  }
}

void Window::inverse_depths(std::span<const int> tracks, std::vector<SeenDepth>& result) {
  result.clear();
  std::vector<StateProjection> forms;
  for (const int track : tracks) {
    const WindowLandmark& l = landmarks_.at(track);
    result.push_back({graph_.value(l.y)(2), 0.0});
    forms.push_back({{l.y}, Eigen::RowVector3d::UnitZ()});
  }
  const std::vector<Eigen::MatrixXd> variances = optimum_->equations.covariances(forms);
  for (std::size_t i = 0; i < result.size(); ++i) result[i].sigma = std::sqrt(variances[i](0, 0));
}

void Window::motions(std::span<const int> tracks, std::vector<MotionBelief>& result) {
  result.clear();
  std::vector<StateProjection> forms;
  for (const int track : tracks) {
    const WindowLandmark& l = landmarks_.at(track);
    const ChainState state = newest_state(graph_, l);
    MotionBelief& motion = result.emplace_back();
    motion.track = track;
    motion.w = state.x.tail(functions_.motion);
    motion.density_scale = functions_.density_scale(state.x);
    forms.push_back({state_variables(l), state.J.bottomRows(functions_.motion)});
  }
  const std::vector<Eigen::MatrixXd> P_w = optimum_->equations.covariances(forms);
  for (std::size_t i = 0; i < result.size(); ++i) result[i].covariance = P_w[i];
}

// `condition` states that they never moved: their window's measurements change, and with them the
// estimate.
void Window::collapse(std::span<const int> tracks) {
  for (const int track : tracks) {
    WindowLandmark& landmark = landmarks_.at(track);
    if (histories_) {
      std::vector<LandmarkVector> states = chain_states(graph_, landmark);
      states.pop_back();
      histories_->passed(track, states);
    }
    condition_ ? free_landmarks_.condition(landmark) : free_landmarks_.drop(landmark);
    landmark.base = cameras_.newest().position;
    truth_.apply(landmark);
  }
  optimum_.reset();  // of the graph as it was
  if (!condition_) return;
  graph_.prior().relinearise();
  NormalEquations equations(graph_);
  Step step = equations.step();
  optimum_ = OptimiseResult{std::move(equations), std::move(step)};
  graph_.retract(optimum_->last_step);
  estimate_camera();
}

// y stays what it is, at the newest frame, where a chain begins.
void Window::free(int track, const LandmarkPrior& prior) {
  WindowLandmark& l = landmarks_.at(track);
  if (histories_) histories_->rested_until(track, cameras_.newest().number, at_rest(l));
  l.base = cameras_.newest().position;
  free_landmarks_.start(l, prior);
}

// Its measurements stay in the window until they leave.
void Window::remove(std::span<const int> tracks, const TrackRecords& records) {
  for (const int track : tracks) {
    WindowLandmark& landmark = landmarks_.at(track);
    if (histories_) end_history(landmark, records.at(track));
    if (graph_.prior().inactive.contains(landmark.y)) {
      graph_.remove_variables({landmark.y});
    } else {
      if (landmark.w) {
        free_landmarks_.end(landmark);
      } else {
        landmark.base = cameras_.newest().position;  // the last frame that can have measured it
      }
      pruned_.push_back(landmark);
    }
    landmarks_.erase(track);
  }
}

// Thesis 2.1.3, (2.7), as factors: the first pixel, and the priors of inverse depth and motion.
bool Window::add(const Observation& z, const LandmarkPrior& prior, bool is_free) {
  WindowFrame& newest = cameras_.newest();
  const auto here = initialise(setup_.camera, cameras_.state(newest).orientation, z.pixel,
                               scene_ ? graph_.value(*scene_)(0) : prior.inverse_depth);
  if (!here) return false;
  WindowLandmark& l = insert(z.track);
  if (histories_) histories_->begin(z.track, newest.number, false);
  if (histories_) histories_->measured(z.track, newest.number, z.pixel);
  l.y = graph_.add_variable(here->y, nullptr, z.track);
  truth_.apply(l);
  const WindowPixel first =
      free_landmarks_.measure(l, {newest.position, newest.motion, z.pixel, 0});
  newest.birth_priors.insert(
      scene_ ? graph_.add_factor({l.y, *scene_}, shared_inverse_depth_cost(prior))
             : graph_.add_factor({l.y}, inverse_depth_prior_cost(prior)));
  if (!is_free) return true;
  free_landmarks_.start(l, prior);
  l.pixels = {first};
  return true;
}

WindowLandmark& Window::insert(int track) {
  WindowLandmark& landmark = landmarks_[track];
  landmark.track = track;
  landmark.last_used = cameras_.newest().index;
  landmark.anchor = landmark.base = cameras_.newest().position;
  return landmark;
}

int Window::state_size() const {
  int size = graph_.prior().inactive.dim();
  for (const auto& [id, v] : graph_.variables()) size += v.dim();
  return size;
}

void Window::points(std::vector<LandmarkPoint>& result) {
  result.clear();
  const std::map<VariableId, SmallVector> all = values(graph_);
  const auto value = [&](VariableId id) { return Eigen::Vector3d(all.at(id)); };
  for (const auto& [track, l] : landmarks_) {
    const Eigen::Vector3d y =
        l.w ? Eigen::Vector3d(chain_states(graph_, l).back().head<3>()) : value(l.y);
    result.push_back({track, value(l.anchor), y});
  }
}

std::vector<LandmarkBelief> Window::landmarks(std::span<const int> tracks) const {
  std::vector<StateProjection> forms;
  std::vector<LandmarkBelief> beliefs;
  std::vector<Eigen::MatrixXd> inactive;
  for (const int track : tracks) {
    LandmarkMarginal made = landmark_marginal(graph_, landmarks_.at(track));
    beliefs.push_back(std::move(made.belief));
    StateProjection& form = forms.emplace_back(std::move(made.projection));
    inactive.push_back(substitute_inactive(graph_, form));
  }
  const std::vector<Eigen::MatrixXd> P = NormalEquations(graph_).covariances(forms);
  for (std::size_t i = 0; i < beliefs.size(); ++i) beliefs[i].covariance = P[i] + inactive[i];
  return beliefs;
}

std::unique_ptr<Estimator> make_window(const Setup& setup, const ModelOptions& models,
                                       const WindowOptions& options) {
  return std::make_unique<FrameLoop>(
      setup, models, std::make_unique<Window>(setup, models, options), truth_of(setup, options));
}

}  // namespace slammot
