#include "smoothers/batch.h"

#include "estimation/frame_loop.h"
#include "smoothers/factors/factors.h"
#include "smoothers/solver/ceres_solve.h"
#include "smoothers/window/robust_loss.h"
#include "smoothers/window/window_belief.h"

namespace slammot {

namespace {

// Of all solutions of a batch together; after that it has diverged.
constexpr int kMaxIterations = 300;

}  // namespace

// A landmark in the batch's graph.
struct BatchLandmark : LandmarkVariables {
  TrackHistory history;
};

class Batch final : public Estimator {
 public:
  Batch(const Setup& setup, const ModelOptions& models, const WindowOptions& front)
      : setup_(setup),
        functions_(find_landmark(models.landmark)),
        loss_(make_loss(front.loss)),
        graph_(false),
        scene_(add_scene(graph_, setup.prior)) {
    auto window = std::make_unique<Window>(setup, models, front, &histories_);
    window_ = window.get();
    front_ = std::make_unique<FrameLoop>(setup, models, std::move(window), truth_of(setup, front));
  }

  FrameReport process(const Frame& frame, StageListener& stages) override {
    FrameReport report = front_->process(frame, stages);
    timestamps_.push_back(frame.timestamp);
    return report;
  }
  CameraEstimate camera() const override { return front_->camera(); }
  std::vector<LandmarkEstimate> landmarks() const override {
    return landmarks_ ? *landmarks_ : front_->landmarks();
  }
  std::vector<LandmarkEstimate> landmarks_measured(int index) const override {
    return front_->landmarks_measured(index);
  }
  std::vector<CameraEstimate> smoothed(StageListener& stages) override;

 private:
  void add_cameras();
  void add_landmark(const TrackHistory& history);
  void add_chain(BatchLandmark& landmark);
  void leave_out_poles();
  double refresh_noises();  // of all landmarks
  void solve();
  LandmarkEstimate estimate(const BatchLandmark& landmark, const NormalEquations& equations) const;

  Setup setup_;
  const LandmarkFunctions& functions_;
  std::unique_ptr<ceres::LossFunction> loss_;
  TrackHistories histories_;
  const Window* window_ = nullptr;  // in the front
  std::unique_ptr<FrameLoop> front_;
  std::vector<double> timestamps_;
  Graph graph_;
  MotionManifold motion_manifold_;
  std::optional<VariableId> scene_;              // as Window's
  std::vector<VariableId> positions_, motions_;  // by frame
  std::vector<BatchLandmark> all_;
  std::optional<std::vector<LandmarkEstimate>> landmarks_;
};

void Batch::add_cameras() {
  const std::vector<CameraState> states = window_->all_cameras();
  for (std::size_t i = 0; i < states.size(); ++i) {
    Eigen::VectorXd position(3), motion(kMotionSize);
    camera_to_blocks(states[i], position.data(), motion.data());
    positions_.push_back(graph_.add_variable(position, nullptr, -1));
    motions_.push_back(graph_.add_variable(motion, &motion_manifold_, -1));
    if (i == 0) {
      graph_.add_factor({positions_[0], motions_[0]}, initial_camera_cost(setup_.initial));
      continue;
    }
    const double dt = timestamps_[i] - timestamps_[i - 1];
    const Matrix12d Q = camera_noise(setup_.camera_noise, states[i - 1], dt);
    graph_.add_factor({positions_[i - 1], motions_[i - 1], positions_[i], motions_[i]},
                      camera_motion_cost(Q, dt));
  }
}

void Batch::add_landmark(const TrackHistory& history) {
  if (history.pixels.empty()) return;
  const int owner = static_cast<int>(all_.size());  // a track may have had several lives
  BatchLandmark& l = all_.emplace_back();
  l.history = history;
  l.anchor = positions_[static_cast<std::size_t>(history.first)];
  l.y = graph_.add_variable(history.states.front().head<3>(), nullptr, owner);
  // The window's birth priors, which it may have learnt: the same information.
  if (history.known) {
    const auto known = std::ranges::find(setup_.known, history.record.track, &KnownLandmark::track);
    graph_.add_factor({l.anchor, l.y}, known_landmark_cost(*known));
  } else {
    if (scene_) {
      graph_.add_factor({l.y, *scene_}, shared_inverse_depth_cost(history.record.prior));
    } else {
      graph_.add_factor({l.y}, inverse_depth_prior_cost(history.record.prior));
    }
  }
  if (history.is_free()) {
    l.w = graph_.add_variable(history.states.front().tail(functions_.motion), nullptr, owner);
    add_chain(l);
  }
  for (const auto& [frame, pixel] : history.pixels) {
    const auto k = static_cast<std::size_t>(frame);
    add_pixel(graph_, l, {positions_[k], motions_[k], pixel, l.w ? frame - history.first : 0},
              setup_.camera, setup_.pixel_sigma, loss_.get());
  }
}

void Batch::add_chain(BatchLandmark& l) {
  graph_.add_factor({*l.w}, motion_prior_cost(functions_.prior_sigmas(l.history.record.prior)));
  l.chain = std::make_shared<Chain>(Chain{&functions_, {}});
  const int steps = l.history.pixels.back().first - l.history.first;
  for (int i = 0; i < steps; ++i) {
    const auto k = static_cast<std::size_t>(l.history.first) + static_cast<std::size_t>(i);
    l.chain->steps.push_back({timestamps_[k + 1] - timestamps_[k], {}});
  }
  const auto count = static_cast<std::ptrdiff_t>(steps) + 1;
  const std::vector<LandmarkVector> x(l.history.states.begin(), l.history.states.begin() + count);
  for (const LandmarkVector& n : lead_through(*l.chain, x, setup_.prior)) {
    l.noises.push_back(graph_.add_variable(n, nullptr, graph_.variables().at(l.y).owner));
    graph_.add_factor({l.noises.back()}, noise_prior_cost(functions_.dim()));
  }
}

// A moving landmark that may pass through the camera can explain any pixel there: the solution is
// drawn to that pole and then held by its edge (observation.h), all of it. A measurement of a
// landmark that has come so near says nothing of the rest and is left out.
void Batch::leave_out_poles() {
  constexpr double kNear = 0.05;                                            // [m]
  const double steepest = setup_.camera.fx / (kNear * setup_.pixel_sigma);  // of d residual / dr
  graph_.linearise();
  std::vector<FactorId> out;
  for (const auto& [id, factor] : graph_.factors()) {
    const bool is_pixel = factor.r.size() == 2 && factor.variables.size() >= 4;
    if (is_pixel && (!factor.valid || factor.jacobian(0).norm() > steepest)) out.push_back(id);
  }
  for (const FactorId id : out) graph_.remove_factor(id);
}

double Batch::refresh_noises() {
  double change = 0.0;
  for (const BatchLandmark& l : all_) {
    change = std::max(change, slammot::refresh_noises(graph_, l, setup_.prior));
  }
  return change;
}

// Until neither the noises change nor the measurements that can be evaluated.
void Batch::solve() {
  int left = kMaxIterations, waited = -1;
  for (;;) {
    const auto [waiting, iterations] = solve_with_ceres(graph_, left);
    if (refresh_noises() <= kNegligibleNoise && (waiting == 0 || waiting == waited)) return;
    leave_out_poles();
    waited = waiting;
    left -= iterations;
    if (left <= 0) {
      throw Diverged("the batch has not settled in " + std::to_string(kMaxIterations) +
                     " iterations");
    }
  }
}

std::vector<CameraEstimate> Batch::smoothed(StageListener& stages) {
  stages.begin("batch");
  add_cameras();
  window_->end_histories(front_->records());
  for (const TrackHistory& history : histories_.ended()) add_landmark(history);
  solve();
  stages.begin("batch_covariances");
  graph_.linearise();
  const NormalEquations equations(graph_);
  std::vector<CameraEstimate> result;
  for (std::size_t i = 0; i < positions_.size(); ++i) {  // one by one, or memory fills
    const std::vector<std::vector<VariableId>> camera{{positions_[i], motions_[i]}};
    result.push_back(
        {timestamps_[i],
         camera_from_blocks(graph_.value(positions_[i]).data(), graph_.value(motions_[i]).data()),
         equations.covariances(camera).front()});
  }
  landmarks_.emplace();
  for (const BatchLandmark& l : all_) landmarks_->push_back(estimate(l, equations));
  return result;
}

LandmarkEstimate Batch::estimate(const BatchLandmark& l, const NormalEquations& equations) const {
  LandmarkMarginal made = landmark_marginal(graph_, l);
  const std::vector<StateProjection> forms{std::move(made.projection)};
  made.belief.covariance = equations.covariances(forms).front();
  LandmarkEstimate estimate = landmark_estimate(functions_, l.history.record, made.belief);
  if (l.w) estimate.state_frame = l.history.record.last_frame;  // where its chain ends
  return estimate;
}

std::unique_ptr<Estimator> make_batch(const Setup& setup, const ModelOptions& models,
                                      const WindowOptions& front) {
  return std::make_unique<Batch>(setup, models, front);
}

}  // namespace slammot
