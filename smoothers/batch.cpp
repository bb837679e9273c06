#include "smoothers/batch.h"

#include "estimation/loop/frame_loop.h"
#include "smoothers/ceres/ceres_solve.h"
#include "smoothers/graph/chain_step.h"
#include "smoothers/graph/least_noise.h"
#include "smoothers/scale/noise_scale.h"
#include "smoothers/window/window.h"

namespace slammot {

namespace {

// Of all solutions of a batch together; after that it has diverged.
constexpr int kMaxIterations = 1000;

}  // namespace

// A landmark in the batch's graph.
struct BatchLandmark {
  LandmarkId id = 0;
  TrackHistory history;
};

class Batch final : public Estimator {
 public:
  Batch(const Setup& setup, const ModelOptions& models, const WindowOptions& front)
      : setup_(setup),
        functions_(find_landmark(models.landmark, models.point)),
        graph_({setup.rig(), setup.pixel_sigma, setup.prior, &functions_, noise_tells_scale(setup)},
               false) {
    if (setup.prior.mean_sigma > 0.0) graph_.add_scene(setup.prior);
    auto window = std::make_unique<Window>(setup, models, front, &histories_);
    window_ = window.get();
    front_ = std::make_unique<FrameLoop>(setup, models, std::move(window));
  }

  void keep_predictions() override { front_->keep_predictions(); }
  FrameReport process(const Frame& frame, StageListener& stages) override {
    FrameReport report = front_->process(frame, stages);
    timestamps_.push_back(frame.timestamp);
    return report;
  }
  CameraEstimate camera() const override { return front_->camera(); }
  std::optional<PoseEstimate> pose_before(int frames) const override {
    return front_->pose_before(frames);
  }
  InForce in_force() const override { return front_->in_force(); }
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
  void add_chain(const TrackHistory& history, GraphLandmark& landmark);
  void leave_out_poles();
  double refresh_noises();  // of all landmarks
  void solve();
  LandmarkEstimate estimate(const BatchLandmark& landmark, const NormalEquations& equations) const;

  Setup setup_;
  const LandmarkFunctions& functions_;
  TrackHistories histories_;
  const Window* window_ = nullptr;  // in the front
  std::unique_ptr<FrameLoop> front_;
  std::vector<double> timestamps_;
  Graph graph_;
  std::vector<GraphCamera> cameras_;  // by frame
  std::vector<BatchLandmark> all_;
  std::optional<std::vector<LandmarkEstimate>> landmarks_;
};

void Batch::add_cameras() {
  const std::vector<CameraState> states = window_->all_cameras();
  for (std::size_t i = 0; i < states.size(); ++i) {
    cameras_.push_back(graph_.add_camera(states[i]));
    if (i == 0) {
      graph_.add_initial(cameras_[0], setup_.initial);
      continue;
    }
    const double dt = timestamps_[i] - timestamps_[i - 1];
    const Matrix12d Q = camera_noise(window_->camera_noises()[i - 1], states[i - 1], dt);
    graph_.add_motion(cameras_[i - 1], cameras_[i], Q, dt);
  }
}

void Batch::add_landmark(const TrackHistory& history) {
  if (history.pixels.empty()) return;
  const VariableId anchor = cameras_[static_cast<std::size_t>(history.first)].position;
  const LandmarkId id = graph_.add_landmark(anchor, history.born_at);
  all_.push_back({id, history});
  GraphLandmark& l = graph_[id];
  l.birth = history.birth;  // the window's, which may have been learnt: the same information
  if (l.birth.kind == BirthPrior::Kind::kSharedDepth) l.birth.scene = graph_.scene->scene;
  if (history.is_free()) {
    graph_.free_landmark(id, functions_.prior_sigmas(history.record.prior));  // stated at birth
    graph_.variables[l.w].value = history.states.front().tail(functions_.motion);
    add_chain(history, l);
  }
  graph_.variables[l.y].value = history.states.front().head<3>();
  for (const auto& [frame, z] : history.pixels) {
    graph_.add_pixel(id, cameras_[static_cast<std::size_t>(frame)], z,
                     l.is_free() ? frame - history.first : 0);
  }
}

// From the last pixel on a chain says nothing.
void Batch::add_chain(const TrackHistory& history, GraphLandmark& l) {
  const auto steps = static_cast<std::size_t>(history.pixels.back().first - history.first);
  LandmarkVector x = history.states.front();
  for (std::size_t i = 0; i < steps; ++i) {
    const auto k = static_cast<std::size_t>(history.first) + i;
    ChainStep& step = l.chain.emplace_back();
    step.dt = timestamps_[k + 1] - timestamps_[k];
    step.is_moving = history.record.label == Label::kMoving;
    x = functions_.predict(x, step.dt);
    step.G = functions_.noise_root(x, setup_.prior.noise(step.is_moving), step.dt);
    step.unit = unit_of_motion(graph_.models(), x.head<3>());
    step.noise = least_noise(step.G, history.states[i + 1] - x);
    x += step.G * step.noise;
  }
}

void Batch::leave_out_poles() {
  graph_.linearise();
  for (GraphLandmark& l : graph_.landmarks) {
    std::erase_if(l.pixels, [&](const GraphPixel& pixel) { return graph_.is_at_pole(pixel); });
  }
}

double Batch::refresh_noises() {
  double change = 0.0;
  for (GraphLandmark& l : graph_.landmarks) change = std::max(change, graph_.refresh_noises(l));
  return change;
}

// Until neither the noises nor their units change, nor the measurements that can be evaluated.
void Batch::solve() {
  int left = kMaxIterations, waited = -1;
  for (;;) {
    const auto [waiting, iterations, has_converged] = solve_with_ceres(graph_, left);
    const bool has_settled = refresh_noises() <= kNegligibleNoise && has_converged;
    if (has_settled && (waiting == 0 || waiting == waited)) return;
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
  NormalEquations equations;
  equations.factorise(graph_, cameras_.back());
  std::vector<CameraEstimate> result;
  for (std::size_t i = 0; i < cameras_.size(); ++i) {  // one by one, or memory fills
    result.push_back({timestamps_[i], graph_.camera(cameras_[i]),
                      equations.camera_covariance(graph_, cameras_[i])});
  }
  landmarks_.emplace();
  for (const BatchLandmark& l : all_) {
    const LandmarkId one[] = {l.id};
    equations.prepare(graph_, one);
    landmarks_->push_back(estimate(l, equations));
    equations.forget_columns();  // or memory fills
  }
  return result;
}

LandmarkEstimate Batch::estimate(const BatchLandmark& landmark,
                                 const NormalEquations& equations) const {
  const GraphLandmark& l = graph_[landmark.id];
  const LandmarkVector x = graph_.newest_state(l);
  LandmarkBelief belief;
  belief.anchor = graph_.value(l.anchor);
  belief.y = x.head<3>();
  // One that moved once has a chain, but a static one has no velocity to tell.
  const bool is_static = rests(landmark.history.record);
  const Eigen::Index motion = is_static ? 0 : x.size() - 3;
  belief.w = x.tail(x.size() - 3).head(motion);
  const JointMatrix& P = equations.joint(landmark.id);
  belief.covariance = P.block(kCameraDim, kCameraDim, 6 + motion, 6 + motion);
  LandmarkEstimate estimate = landmark_estimate(functions_, landmark.history.record, belief);
  if (l.is_free())
    estimate.state_frame = landmark.history.record.last_frame;  // where its chain ends
  return estimate;
}

std::unique_ptr<Estimator> make_batch(const Setup& setup, const ModelOptions& models,
                                      const WindowOptions& front) {
  return std::make_unique<Batch>(setup, models, front);
}

}  // namespace slammot
