#include "smoothers/window/window.h"

#include <algorithm>

#include "estimation/loop/frame_loop.h"
#include "estimation/modules/label_revision.h"
#include "models/points/initialisation.h"
#include "smoothers/ceres/ceres_solve.h"
#include "smoothers/scale/noise_scale.h"
#include "smoothers/window/slide_along_scale.h"

namespace slammot {
namespace {

// A frame is solved again at most so often without its measurements at a pole (Graph::is_at_pole);
// the rest waits for the next frame.
constexpr int kMostPoles = 3;

constexpr int kCeresIterations = 1000;
constexpr double kCeresTolerance = 1e-18;  // below rounding: until steps change nothing

// Why the scale is not kept though it is asked for; "": it is. Where every step is taken the window
// is to be the EKF without its gauge (docs/frame.md).
std::string without_scale(const Setup& setup, const WindowOptions& options) {
  if (!setup.known.empty()) return "landmarks known beforehand";
  if (setup.measures_scale) return "the scale is measured";
  if (options.linearisation == WindowLinearisation::kFej) return "window.linearisation=fej";
  return options.iterations > 1 ? "" : "window.iterations=1";
}

bool keeps_scale(const Setup& setup, const ModelOptions& models, const WindowOptions& options) {
  return models.gauge == Gauge::kScale && without_scale(setup, options).empty();
}

bool has_fixed_points(const WindowOptions& options) {
  return options.linearisation == WindowLinearisation::kFej;
}

}  // namespace

Window::Window(const Setup& setup, const ModelOptions& models, const WindowOptions& options,
               TrackHistories* histories)
    : setup_(setup),
      options_(options),
      gauge_(models.gauge),
      condition_(models.collapse == Collapse::kCondition),
      remembers_(motion_memory(models, find_landmark(models.landmark, models.point)) > 0),
      functions_(find_landmark(models.landmark, models.point)),
      graph_({setup.rig(), setup.pixel_sigma, setup.prior, &functions_, noise_tells_scale(setup),
              keeps_scale(setup, models, options), setup.initial.state.position},
             has_fixed_points(options)),
      cameras_(graph_),
      optimiser_(options.iterations == 1 ? StepRule::kEvery : StepRule::kDescent),
      marginals_(graph_, cameras_, landmarks_, optimiser_.equations()),
      departures_(graph_, cameras_, landmarks_),
      histories_(histories) {
  if (options.solver == WindowSolver::kCeres && graph_.fixed_points()) {
    throw std::invalid_argument(
        "window.solver ceres minimises the cost: it "
        "needs window.linearisation standard");
  }
  if (setup.prior.mean_sigma > 0.0) graph_.add_scene(setup.prior);
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
  marginals_.predict();
  for (const auto& [track, landmark] : landmarks_.current) {
    if (landmark.is_free) extend_chain(graph_, landmark.id, records.at(track).label, dt);
  }
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
  if (histories_) histories_->begin(known.track, cameras_.newest().number, l.birth, y);
  graph_.linearise(l);
}

void Window::innovations(std::span<const Observation> measured, FrameInnovation& result) {
  tracks_of(measured, measured_);
  marginals_.innovations(measured, result);
}

void Window::widen(double factor) {
  graph_.widen_newest_motion(factor);
  marginals_.widen(factor);
  if (histories_) noises_.back() = scaled(noises_.back(), factor);
}

// Marginalisation waits until here: the gate reads the last factorisation.
void Window::update(std::span<const Observation> accepted, std::span<const int> considered,
                    StageListener& stages) {
  stages.begin("marginalise");
  departures_.marginalise(options_.frames, histories_);
  departures_.reactivate(measured_);
  stages.begin("update");
  add_pixels(accepted, considered);
  refresh_noises();  // constant while the frame is solved (docs/smoother.md, Chains)
  const int steps = solve();
  for (int i = 0; i < kMostPoles && leave_out_poles(); ++i) solve();
  acted_.relinearised += steps > 1 ? 1 : 0;
  ++acted_.updated;
  acted_.held_points += graph_.fixed_points() && graph_.prior().active.cols() > 0 ? 1 : 0;
  for (auto& [track, landmark] : landmarks_.current) landmark.is_entering = false;
  camera_ = marginals_.camera();
}

void Window::add_pixels(std::span<const Observation> accepted, std::span<const int> considered) {
  tracks_of(accepted, used_);
  const WindowFrame& newest = cameras_.newest();
  for (const Observation& z : accepted) {
    WindowLandmark& landmark = landmarks_.at(z.track);
    landmark.last_used = newest.index;
    consider(landmark, std::ranges::binary_search(considered, z.track));
    const int depth = landmark.is_free ? graph_[landmark.id].steps() : 0;
    graph_.add_pixel(landmark.id, newest.camera, z, depth);
    if (histories_) histories_->measured(z, newest.number);
  }
}

// Those of the frame in hand; one that it does not measure stays what it was.
void Window::consider(const WindowLandmark& landmark, bool is_considered) {
  if (is_considered && !landmark.is_free) return;
  if (is_considered && !graph_[landmark.id].is_considered) departures_.set_apart(landmark);
  graph_.consider(landmark.id, is_considered);
}

int Window::solve() {
  const int steps = minimise();
  if (graph_.keeps_scale()) slide_along_scale(graph_);
  marginals_.start();
  return steps;
}

// At the optimum of Ceres the equations are factorised for the marginals, and the step that they
// give is taken too: Ceres judges steps by the cost, whose rounding hides a last 1e-6 sigma.
int Window::minimise() {
  const GraphCamera& newest = cameras_.newest().camera;
  if (options_.solver == WindowSolver::kOwn) {
    return optimiser_(graph_, newest, options_.iterations, options_.linearisation_error);
  }
  int iterations = 0;
  for (bool has_converged = false; !has_converged && iterations < kCeresIterations;) {
    const CeresSolution solution =
        solve_with_ceres(graph_, kCeresIterations - iterations, kCeresTolerance);
    iterations += solution.iterations;
    has_converged = solution.has_converged;
  }
  graph_.linearise();
  optimiser_.take_step(graph_, newest);
  return iterations + 1;
}

// Graph::is_at_pole(). Where every step is taken, none is held back by a pole.
bool Window::leave_out_poles() {
  if (optimiser_.takes_every_step()) return false;
  bool any = false;
  const auto leave_out = [&](const WindowLandmark& landmark, bool is_pruned) {
    std::erase_if(graph_[landmark.id].pixels, [&](const GraphPixel& pixel) {
      if (!graph_.is_at_pole(pixel)) return false;
      any = true;
      if (is_pruned) return true;
      if (pixel.position == cameras_.newest().camera.position) std::erase(used_, landmark.track);
      const WindowFrame& frame = *cameras_.find(pixel.position);
      if (histories_) histories_->discard(landmark.track, frame.number);
      return true;
    });
  };
  for (const auto& [track, landmark] : landmarks_.current) leave_out(landmark, false);
  for (const WindowLandmark& landmark : landmarks_.pruned) leave_out(landmark, true);
  return any;
}

// Where a label has changed: from the stored linearisation. Where the scale is kept, that must be
// at this estimate, or what is linearised elsewhere seems to tell the scale.
void Window::take_step() {
  if (graph_.keeps_scale()) graph_.linearise();
  graph_.prior().relinearise();
  optimiser_.take_step(graph_, cameras_.newest().camera);
  camera_ = marginals_.camera();
}

// Where there was nothing to solve.
void Window::refactorise() {
  graph_.linearise();
  optimiser_.factorise(graph_, cameras_.newest().camera);
}

double Window::refresh_noises() {
  double change = 0.0;
  for (GraphLandmark& l : graph_.landmarks) {
    if (l.is_alive) change = std::max(change, graph_.refresh_noises(l));
  }
  return change;
}

void Window::in_force(InForce& result) const {
  const bool uses_ceres = options_.solver == WindowSolver::kCeres;
  const auto state = [&](const char* name, const char* key, bool is_on, const std::string& because,
                         long acted) {
    result.push_back({name, key, is_on, is_on ? "" : because, is_on ? acted : 0});
  };
  const bool iterates = options_.iterations > 1 && !uses_ceres;
  state("relinearisation", "window.iterations", iterates, uses_ceres ? "window.solver=ceres" : "",
        acted_.relinearised);
  state("relinearisation by Ceres", "window.solver", uses_ceres, "", acted_.updated);
  state("first estimates", "window.linearisation", graph_.fixed_points(), "", acted_.held_points);
  const char* because = !setup_.prior.spread_follows_mean ? ""
                        : setup_.known.empty()            ? "the scale is measured"
                                                          : "landmarks known beforehand";
  state("scale kept by the noise (noise_scale.h)", "prior.spread",
        !graph_.models().noise_tells_scale, because, acted_.updated);
  state("scale kept while the estimate moves", "gauge", graph_.keeps_scale(),
        gauge_ == Gauge::kScale ? without_scale(setup_, options_) : "", acted_.updated);
  state("heading kept while the estimate moves", "gauge", false,
        gauge_ == Gauge::kHeading ? "a window keeps none" : "", 0);
}

double Window::scale_information() const {
  return !setup_.knows_scale() ? information_of_scale(graph_)(0) : kUndefined;
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
  inactive.values(prior.chart(), inactive_values_);
  const auto value = [&](VariableId id) -> Eigen::Vector3d {
    const Variable& v = graph_.variables[id];
    if (!v.is_active) return inactive_values_[id];
    return v.value;
  };
  for (const auto& [track, landmark] : landmarks_.current) {
    const GraphLandmark& l = graph_[landmark.id];
    result.push_back(
        {track, value(l.anchor), l.is_free() ? graph_.newest_state(l).head<3>() : value(l.y)});
  }
}

// Cameras as they left the window, without covariances, which belong to that moment and are not
// kept; then those still in it, converged, with theirs.
std::vector<CameraEstimate> Window::smoothed() {
  departures_.marginalise_motions();
  solve();
  for (int i = 0; i < kMaxRefreshes && refresh_noises() > kNegligibleNoise; ++i) solve();
  refactorise();
  std::vector<CameraEstimate> result;
  for (const CameraWindow::Left& left : cameras_.left()) {
    result.push_back({left.timestamp, left.state, Matrix12d::Constant(kUndefined)});
  }
  for (const WindowFrame& f : cameras_.frames()) {
    result.push_back({f.timestamp, cameras_.state(f),
                      optimiser_.equations().camera_covariance(graph_, f.camera)});
  }
  return result;
}

void Window::end_histories(const TrackRecords& records) const {
  for (const auto& [track, landmark] : landmarks_.current) end_history(landmark, records.at(track));
}

void Window::end_history(const WindowLandmark& landmark, const TrackRecord& record) const {
  const std::vector<LandmarkVector> states =
      landmark.is_free ? graph_.states(graph_[landmark.id])
                       : std::vector<LandmarkVector>{marginals_.at_rest(landmark)};
  histories_->end(record, cameras_.newest().number, landmark.is_free, states);
}

std::unique_ptr<Estimator> make_window(const Setup& setup, const ModelOptions& models,
                                       const WindowOptions& options) {
  return std::make_unique<FrameLoop>(setup, models,
                                     std::make_unique<Window>(setup, models, options));
}

}  // namespace slammot
