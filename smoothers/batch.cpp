#include "slammot/smoothers/batch.h"

#include "slammot/smoothers/ceres_solve.h"
#include "slammot/smoothers/factors.h"
#include "slammot/smoothers/window_estimator.h"

namespace slammot {

namespace {

// A landmark in the batch's graph.
struct BatchLandmark {
  LandmarkLife life;
  VariableId anchor = 0, y = 0;
  std::optional<VariableId> w;
  std::shared_ptr<Chain> chain;
  std::vector<VariableId> noises;
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
  double refresh_noises();  // as Window's
  void add_pixel(const BatchLandmark& landmark, int frame, const Eigen::Vector2d& pixel);
  Vector6d base(const BatchLandmark& landmark) const;
  std::vector<Vector6d> noises(const BatchLandmark& landmark) const;
  ChainState state(const BatchLandmark& landmark) const;
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
  if (life.known) {
    const auto known = window_.known_.at(life.record.track);
    graph_.add_factor({l.anchor, l.y}, known_landmark_cost(known));
  } else {
    if (scene_) {
      graph_.add_factor({l.y, *scene_}, shared_inverse_depth_cost(setup_.prior));
    } else {
      graph_.add_factor({l.y}, inverse_depth_prior_cost(setup_.prior));
    }
  }
  if (life.record.label != Label::kStatic) {
    l.w = graph_.add_variable(life.states.front().tail<3>(), nullptr, owner);
    add_chain(l);
  }
  for (const auto& [frame, pixel] : life.pixels) add_pixel(l, frame, pixel);
}

void Batch::add_chain(BatchLandmark& l) {
  const double sigma = window_.functions_.prior_sigma(setup_.prior);
  graph_.add_factor({*l.w}, motion_prior_cost(sigma));
  l.chain = std::make_shared<Chain>(Chain{&window_.functions_, {}});
  const int steps = l.life.pixels.back().first - l.life.birth;
  for (int i = 0; i < steps; ++i) {
    const auto k = static_cast<std::size_t>(l.life.birth + i);
    l.chain->steps.push_back({timestamps_[k + 1] - timestamps_[k], Matrix6d::Zero()});
  }
  const auto count = static_cast<std::ptrdiff_t>(steps) + 1;
  const std::vector<Vector6d> x(l.life.states.begin(), l.life.states.begin() + count);
  for (const Vector6d& n : lead_through(*l.chain, x, setup_.prior.acceleration)) {
    l.noises.push_back(graph_.add_variable(n, nullptr, graph_.variables().at(l.y).owner));
    graph_.add_factor({l.noises.back()}, noise_prior_cost());
  }
}

void Batch::add_pixel(const BatchLandmark& l, int frame, const Eigen::Vector2d& pixel) {
  const auto k = static_cast<std::size_t>(frame);
  const double sigma = setup_.pixel_sigma;
  if (frame == l.life.birth) {
    graph_.add_factor({motions_[k], l.y}, first_pixel_cost(setup_.camera, pixel, sigma),
                      window_.loss_.get());
    return;
  }
  std::vector<VariableId> variables{positions_[k], motions_[k], l.anchor, l.y};
  if (!l.w) {
    graph_.add_factor(variables, pixel_cost(setup_.camera, pixel, sigma), window_.loss_.get());
    return;
  }
  const int depth = frame - l.life.birth;
  variables.push_back(*l.w);
  variables.insert(variables.end(), l.noises.begin(), l.noises.begin() + depth);
  graph_.add_factor(variables,
                    std::make_unique<ChainPixelCost>(setup_.camera, pixel, sigma, l.chain, depth),
                    window_.loss_.get());
}

Vector6d Batch::base(const BatchLandmark& l) const {
  return (Vector6d() << graph_.value(l.y), graph_.value(*l.w)).finished();
}

std::vector<Vector6d> Batch::noises(const BatchLandmark& l) const {
  std::vector<Vector6d> values;
  for (const VariableId n : l.noises) values.emplace_back(graph_.value(n));
  return values;
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
    if (is_pixel && (!factor.valid || factor.J[0].norm() > steepest)) out.push_back(id);
  }
  for (const FactorId id : out) graph_.remove_factor(id);
}

double Batch::refresh_noises() {
  double change = 0.0;
  for (BatchLandmark& l : all_) {
    if (!l.w) continue;
    const std::vector<Vector6d> n =
        lead_through(*l.chain, states(*l.chain, base(l), noises(l)), setup_.prior.acceleration);
    for (std::size_t k = 0; k < n.size(); ++k) {
      change = std::max(change, (n[k] - graph_.value(l.noises[k])).cwiseAbs().maxCoeff());
      graph_.set_value(l.noises[k], n[k]);
    }
  }
  return change;
}

std::vector<CameraEstimate> Batch::smoothed(StageListener& stages) {
  stages.begin("batch");
  add_cameras();
  for (const LandmarkLife& life : window_.ended_lives_) add_landmark(life);
  for (const auto& [track, landmark] : window_.landmarks_) {
    add_landmark(window_.life_so_far(landmark));
  }
  solve_with_ceres(graph_);
  for (int i = 0; i < kMaxRefreshes && refresh_noises() > kNegligibleNoise; ++i) {
    leave_out_poles();
    solve_with_ceres(graph_);
  }
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

ChainState Batch::state(const BatchLandmark& l) const {
  return l.w ? propagate(*l.chain, base(l), noises(l)) : static_state(graph_.value(l.y));
}

LandmarkEstimate Batch::estimate(const BatchLandmark& l, const NormalEquations& equations) const {
  const ChainState landmark = state(l);
  const Eigen::Index dim = l.w ? 6 : 3;
  LinearForm form;
  form.variables = {l.anchor, l.y};
  if (l.w) form.variables.push_back(*l.w);
  form.variables.insert(form.variables.end(), l.noises.begin(), l.noises.end());
  form.J.setZero(3 + dim, 3 + landmark.J.cols());
  form.J.topLeftCorner<3, 3>().setIdentity();
  form.J.bottomRightCorner(dim, landmark.J.cols()) = landmark.J.topRows(dim);
  LandmarkBelief belief;
  belief.anchor = graph_.value(l.anchor);
  belief.y = landmark.x.head<3>();
  belief.w = landmark.x.tail<3>();
  const std::vector<LinearForm> forms{form};
  belief.covariance = equations.covariances(forms).front();
  LandmarkEstimate estimate = window_.functions_.estimate(l.life.record, belief);
  if (l.w) estimate.state_frame = l.life.record.last_frame;  // where its chain ends
  return estimate;
}

std::unique_ptr<Estimator> make_batch(const Setup& setup, const ModelOptions& models,
                                      const WindowOptions& front) {
  return std::make_unique<Batch>(setup, models, front);
}

}  // namespace slammot
