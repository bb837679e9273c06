#include "smoothers/batch.h"

#include "smoothers/graph/factors.h"
#include "smoothers/solver/ceres_solve.h"
#include "smoothers/window/window_estimator.h"

namespace slammot {

namespace {

// Of all solutions of a batch together; after that it has diverged.
constexpr int kMaxIterations = 300;

// A landmark in the batch's graph.
struct BatchLandmark : LandmarkVariables {
  LandmarkLife life;
};

}  // namespace

class Batch final : public Estimator {
 public:
  Batch(const Setup& setup, const ModelOptions& models, const WindowOptions& front)
      : setup_(setup), models_(models), window_(setup, models, front), graph_(false) {
    window_.record_lives_ = true;
    scene_ = add_scene(graph_, setup.prior);
  }

  FrameReport process(const Frame& frame, StageListener& stages) override {
    FrameReport report = window_.process(frame, stages);
    timestamps_.push_back(frame.timestamp);
    return report;
  }
  CameraEstimate camera() const override { return window_.camera(); }
  std::vector<LandmarkEstimate> landmarks() const override {
    return landmarks_ ? *landmarks_ : window_.landmarks();
  }
  std::vector<LandmarkEstimate> landmarks_measured(int index) const override {
    return window_.landmarks_measured(index);
  }
  std::vector<CameraEstimate> smoothed(StageListener& stages) override;

 private:
  void add_cameras();
  void add_landmark(const LandmarkLife& life);
  void add_chain(BatchLandmark& landmark);
  void leave_out_poles();
  double refresh_noises();  // of all landmarks
  void solve();
  LandmarkEstimate estimate(const BatchLandmark& landmark, const NormalEquations& equations) const;

  Setup setup_;
  ModelOptions models_;
  Window window_;
  std::vector<double> timestamps_;
  Graph graph_;
  MotionManifold motion_manifold_;
  std::optional<VariableId> scene_;              // as Window's
  std::vector<VariableId> positions_, motions_;  // by frame
  std::vector<BatchLandmark> all_;
  std::optional<std::vector<LandmarkEstimate>> landmarks_;
};

void Batch::add_cameras() {
  std::vector<CameraState> states;
  for (const auto& [timestamp, x] : window_.left_) states.push_back(x);
  for (const WindowFrame& f : window_.frames_) states.push_back(window_.state(f));
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

void Batch::add_landmark(const LandmarkLife& life) {
  if (life.pixels.empty()) return;
  const int owner = static_cast<int>(all_.size());  // a track may have had several lives
  BatchLandmark& l = all_.emplace_back();
  l.life = life;
  l.anchor = positions_[static_cast<std::size_t>(life.birth)];
  l.y = graph_.add_variable(life.states.front().head<3>(), nullptr, owner);
  // What the window stated of it at its birth, which it may have learnt: the same information.
  if (life.known) {
    const auto known = window_.known_.at(life.record.track);
    graph_.add_factor({l.anchor, l.y}, known_landmark_cost(known));
  } else {
    if (scene_) {
      graph_.add_factor({l.y, *scene_}, shared_inverse_depth_cost(life.record.prior));
    } else {
      graph_.add_factor({l.y}, inverse_depth_prior_cost(life.record.prior));
    }
  }
  if (life.is_free()) {
    l.w = graph_.add_variable(life.states.front().tail<3>(), nullptr, owner);
    add_chain(l);
  }
  for (const auto& [frame, pixel] : life.pixels) {
    const auto k = static_cast<std::size_t>(frame);
    add_pixel(graph_, l, {positions_[k], motions_[k], pixel, l.w ? frame - life.birth : 0},
              setup_.camera, setup_.pixel_sigma, window_.loss_.get());
  }
}

void Batch::add_chain(BatchLandmark& l) {
  const double sigma = window_.functions_.prior_sigma(l.life.record.prior);
  graph_.add_factor({*l.w}, motion_prior_cost(sigma));
  l.chain = std::make_shared<Chain>(Chain{&window_.functions_, {}});
  const int steps = l.life.pixels.back().first - l.life.birth;
  for (int i = 0; i < steps; ++i) {
    const auto k = static_cast<std::size_t>(l.life.birth) + static_cast<std::size_t>(i);
    l.chain->steps.push_back({timestamps_[k + 1] - timestamps_[k], Matrix6d::Zero()});
  }
  const auto count = static_cast<std::ptrdiff_t>(steps) + 1;
  const std::vector<Vector6d> x(l.life.states.begin(), l.life.states.begin() + count);
  for (const Vector6d& n : lead_through(*l.chain, x, setup_.prior.acceleration)) {
    l.noises.push_back(graph_.add_variable(n, nullptr, graph_.variables().at(l.y).owner));
    graph_.add_factor({l.noises.back()}, noise_prior_cost());
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
    change = std::max(change, slammot::refresh_noises(graph_, l, setup_.prior.acceleration));
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
  for (const LandmarkLife& life : window_.ended_lives_) add_landmark(life);
  for (const auto& [track, landmark] : window_.landmarks_) {
    add_landmark(window_.life_so_far(landmark));
  }
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
  LandmarkEstimate estimate = landmark_estimate(window_.functions_, l.life.record, made.belief);
  if (l.w) estimate.state_frame = l.life.record.last_frame;  // where its chain ends
  return estimate;
}

std::unique_ptr<Estimator> make_batch(const Setup& setup, const ModelOptions& models,
                                      const WindowOptions& front) {
  return std::make_unique<Batch>(setup, models, front);
}

}  // namespace slammot
