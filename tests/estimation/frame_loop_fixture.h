// A frame loop over a belief that is told what to say, and writes down what it is asked.
#pragma once

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <string>
#include <vector>

#include "estimation/loop/frame_loop.h"

namespace slammot::test {

// A landmark of the fake: free or not, and what is believed of it.
struct FakeLandmark {
  bool is_free = false;
  double error = 0.0;  // of its pixel, [sigma of the innovation]
  double speed = 0.0;  // believed [m/s]
  double speed_sigma = 1.0;
  double leave_one_out = 0.0;
  double held_sigma = 1.0;     // of a remembered motion [m/s]
  double inverse_depth = 0.5;  // [1/m], known to 0.001
  bool in_view = true;
};

// Remembers the motion of the landmarks in `remembered`; of all that collapse, when told so.
class FakeBelief final : public Belief {
 public:
  explicit FakeBelief(std::vector<std::string>& calls) : calls_(calls) {}

  void predict(const Frame& frame, double dt, const MotionNoise& noise,
               const TrackRecords& /*records*/) override {
    call("predict");
    camera_.timestamp = frame.timestamp;
    last_dt = dt;
    last_noise = noise;
  }
  void add_known(const KnownLandmark& known) override {
    call("add_known");
    state[known.track];
  }
  void innovations(std::span<const Observation> measured, FrameInnovation& result) override {
    call("innovations");
    result.z.clear();
    result.nu.clear();
    for (const Observation& z : measured) {
      if (!state.at(z.track).in_view) continue;
      result.z.push_back(z);
      result.nu.emplace_back(state.at(z.track).error, 0.0);
    }
    const Eigen::Index size = 2 * std::ssize(result.z);
    result.HPHt.resize(size, size);
    auto HPHt = *result.HPHt;
    HPHt.setZero();
    for (Eigen::Index i = 0; i < size; i += 2)
      HPHt.col(i)(Eigen::seqN(0, size / 2, 2)).setConstant(shared);
  }
  void widen(double factor) override {
    call("widen");
    shared *= factor;
  }
  void predict_pixels(std::span<const int> tracks, std::vector<Prediction>& result) override {
    call("predict_pixels");
    result.clear();
    for (const int track : tracks) {
      const FakeLandmark& l = state.at(track);
      result.push_back({track, {l.in_view ? 10.0 : -10.0, 10.0}, Eigen::Matrix2d::Identity()});
    }
  }
  void update(std::span<const Observation> accepted, std::span<const int> considered_only,
              StageListener&) override {
    call("update");
    camera_.state.velocity += last_dt * acceleration;
    used.clear();
    for (const Observation& z : accepted) used.push_back(z.track);
    considered.assign(considered_only.begin(), considered_only.end());
  }
  void leave_one_out(std::vector<LeaveOneOut>& result) override {
    call("leave_one_out");
    result.clear();
    for (const int track : used) result.push_back({track, state.at(track).leave_one_out});
  }
  void inverse_depths(std::span<const int> tracks, std::vector<SeenDepth>& result) override {
    call("inverse_depths");
    result.clear();
    for (const int track : tracks) result.push_back({state.at(track).inverse_depth, 0.001});
  }
  void motions(std::span<const int> tracks, std::vector<MotionBelief>& result) override {
    call("motions");
    asked.assign(tracks.begin(), tracks.end());
    result.clear();
    for (const int track : tracks) {
      MotionBelief motion;
      motion.track = track;
      motion.w = Eigen::Vector3d::UnitX() * state.at(track).speed;
      const double sigma = state.at(track).speed_sigma;
      motion.covariance = sigma * sigma * Eigen::Matrix3d::Identity();
      result.push_back(motion);
    }
  }
  void collapse(std::span<const int> tracks) override {
    call("collapse");
    for (const int track : tracks) {
      state.at(track).is_free = false;
      if (remembers_all) remembered.insert(track);
    }
  }
  bool remembers_motions() const override { return true; }
  void constrained_motions(std::span<const int> tracks, RememberedMotions& result) override {
    result.reset(std::ssize(tracks), 3);
    for (const int track : tracks) {
      if (!remembered.contains(track)) continue;
      const std::size_t i = result.size();
      const double sigma = state.at(track).held_sigma;
      result.add(track, Eigen::Vector3d::UnitZ());
      result.information(i, i) = Eigen::Matrix3d::Identity() / (sigma * sigma);
      result.vector(i) = 0.1 * track / sigma * Eigen::Vector3d::UnitX();
    }
  }
  void forget_motions(std::span<const int> tracks) override {
    for (const int track : tracks) {
      call("forget");
      remembered.erase(track);
    }
  }
  void release(std::span<const int> tracks, const TrackRecords&) override {
    for (const int track : tracks) {
      call("release");
      state.at(track).is_free = true;
      remembered.erase(track);
    }
  }
  void free(int track, const LandmarkPrior&) override {
    call("free");
    state.at(track).is_free = true;
  }
  void remove(std::span<const int> tracks, const TrackRecords& records) override {
    call("remove");
    for (const int track : tracks) {
      EXPECT_TRUE(records.contains(track));
      state.erase(track);
    }
  }
  bool add(const FirstSight& seen, const LandmarkPrior& prior, bool is_free) override {
    const Observation& z = seen.z;
    call("add");
    if (z.track == kNoRay) return false;
    newest_prior = prior;
    state[z.track].is_free = is_free;
    return true;
  }
  void finish() override { call("finish"); }
  int state_size() const override { return static_cast<int>(state.size()); }
  CameraEstimate camera() const override { return camera_; }
  void points(std::vector<LandmarkPoint>& result) override {
    result.clear();
    for (const auto& [track, l] : state) {
      result.push_back({track, Eigen::Vector3d::Zero(), {0.0, 0.0, l.in_view ? 0.5 : -0.5}});
    }
  }
  std::vector<LandmarkBelief> landmarks(std::span<const int> tracks) const override {
    LandmarkBelief belief;
    belief.anchor.setZero();
    belief.y = {0.0, 0.0, 0.5};
    belief.covariance = Eigen::MatrixXd::Identity(6, 6);
    return std::vector<LandmarkBelief>(tracks.size(), belief);
  }

  static constexpr int kNoRay = 99;
  std::map<int, FakeLandmark> state;
  std::vector<int> used, considered, asked;
  std::set<int> remembered;  // landmarks whose held motion is
  bool remembers_all = false;
  LandmarkPrior newest_prior;
  double last_dt = -1.0;
  MotionNoise last_noise;
  double shared = 0.0;  // variance of what the camera's motion adds to every u [px^2]
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  // of the camera, in each update

 private:
  void call(const char* name) { calls_.emplace_back(name); }

  std::vector<std::string>& calls_;
  CameraEstimate camera_;
};

class FrameLoopOf : public testing::Test {
 protected:
  FrameLoopOf() {
    setup_.camera.fx = setup_.camera.fy = 400.0;
    setup_.camera.cx = 320.0;
    setup_.camera.cy = 240.0;
  }

  // Landmarks of the first frame are static by rule, later ones free.
  void start(ModelOptions models) {
    models.labels.births = Births::kStaticFirst;
    models.labels.sightings = 2;
    start_with(models);
  }
  void start_with(const ModelOptions& models) {
    auto belief = std::make_unique<FakeBelief>(calls_);
    belief->remembers_all = remembers_all_;
    belief_ = belief.get();
    loop_ = std::make_unique<FrameLoop>(setup_, models, std::move(belief));
  }

  FrameReport frame(std::vector<int> tracks) {
    Frame frame{index_, 0.1 * index_, {}, {}};
    ++index_;
    for (const int track : tracks) frame.observations.push_back({track, {320.0, 240.0}});
    calls_.clear();
    return loop_->process(frame, stages_);
  }

  Label label(int track) const { return loop_->records().at(track).label; }

  // How often the newest frame has asked for this, or all frames that it processed again.
  std::ptrdiff_t count(const char* call) const { return std::ranges::count(calls_, call); }

  slammot::Setup setup_;
  std::vector<std::string> calls_;
  FakeBelief* belief_ = nullptr;
  std::unique_ptr<FrameLoop> loop_;
  NoStages stages_;
  int index_ = 0;
  bool remembers_all_ = false;
};

}  // namespace slammot::test
