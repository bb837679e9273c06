// The window as its frame loop drives it, on short sequences.
#include "smoothers/window/window.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "datasets/simulation/scenario.h"
#include "estimation/loop/frame_loop.h"
#include "eval/configuration/setup.h"
#include "eval/run/run.h"

namespace slammot {
namespace {

struct LoopedWindow {
  LoopedWindow(const Sequence& sequence, const Configuration& configuration) {
    const slammot::Setup setup = make_setup(sequence, configuration);
    auto owned = std::make_unique<Window>(setup, configuration.model, configuration.window);
    window = owned.get();
    loop = std::make_unique<FrameLoop>(setup, configuration.model, std::move(owned));
  }
  FrameReport process(const Frame& frame) {
    NoStages stages;
    return loop->process(frame, stages);
  }

  Window* window = nullptr;
  std::unique_ptr<FrameLoop> loop;
};

TEST(KnownLandmark, WhoseFirstPixelIsRefusedIsAsItWasStated) {
  Sequence sequence = simulate("circle", {{"frames", "1"}}, 3);
  ASSERT_FALSE(sequence.known.empty());
  const KnownLandmark& known = sequence.known.front();
  Frame& frame = sequence.frames.front();
  for (Observation& z : frame.observations) {
    if (z.track == known.track) z.pixel += Eigen::Vector2d(150.0, 90.0);
  }
  LoopedWindow run(sequence, {});
  EXPECT_EQ(run.process(frame).rejected, 1);
  int found = 0;
  for (const LandmarkEstimate& l : run.loop->landmarks_measured(0)) {
    if (l.track != known.track) continue;
    ++found;
    const Eigen::Matrix3d stated = known.sigma * known.sigma * Eigen::Matrix3d::Identity();
    EXPECT_LT((l.position - known.position).norm(), known.sigma);
    EXPECT_LT((l.position_covariance - stated).norm(), 0.01 * stated.norm());
  }
  EXPECT_EQ(found, 1);
}

// The motions of landmarks at rest that were there by frame `since`, constrained to zero
// (constrained_motion.cpp), after the whole sequence in a window of so many frames. The label of a
// mover may come in another frame in another window, and then the others are known otherwise.
std::map<int, MotionBelief> constrained_motions(const Sequence& sequence, int frames, int since) {
  Configuration configuration;
  configuration.window.frames = frames;
  configuration.model.labels.births = Births::kStaticFirst;  // the same labels in every window
  LoopedWindow run(sequence, configuration);
  for (const Frame& frame : sequence.frames) run.process(frame);
  std::vector<int> tracks;
  for (const auto& [track, record] : run.loop->records()) {
    if (rests(record) && record.first_frame <= since) tracks.push_back(track);
  }
  RememberedMotions motions;
  run.window->constrained_motions(tracks, motions);
  std::map<int, MotionBelief> result;
  const auto& functions = find_landmark(configuration.model.landmark, configuration.model.point);
  for (std::size_t i = 0; i < motions.size(); ++i) {
    if (const auto motion = motions.motion(i, functions)) result[motion->track] = *motion;
  }
  return result;
}

TEST(ConstrainedMotion, IsKnownAsWellAsIfNothingHadLeftTheWindow) {
  constexpr int kEnd = 40, kShort = 8, kSince = kEnd - 2 * kShort;
  const Sequence sequence =
      simulate("circle", {{"frames", std::to_string(kEnd)}, {"moving", "0"}}, 3);
  const auto expected = constrained_motions(sequence, kEnd, kSince);
  int compared = 0;
  for (const auto& [track, motion] : constrained_motions(sequence, kShort, kSince)) {
    if (!expected.contains(track)) continue;
    const MotionBelief& all = expected.at(track);
    const Eigen::LLT<Eigen::MatrixXd> P(all.covariance);
    const Eigen::VectorXd difference = P.matrixL().solve(Eigen::VectorXd(motion.w - all.w));
    EXPECT_LT(difference.norm(), 0.5) << track;  // [sigma]
    const double ratio = std::cbrt(motion.covariance.determinant() / all.covariance.determinant());
    EXPECT_NEAR(ratio, 1.0, 0.1) << track;
    ++compared;
  }
  EXPECT_GE(compared, 5);
}

// Tracks of four frames, as of images, in a small map: all have been pruned before their first
// frame leaves, so that each leaves whole and the prior never holds one.
TEST(PrunedLandmarks, LeaveTheWindowWhole) {
  constexpr int kLife = 4, kWindow = 12;
  Sequence sequence = simulate("circle", {{"frames", "60"}, {"moving", "0"}, {"known", "0"}}, 3);
  for (Frame& frame : sequence.frames) {
    for (Observation& z : frame.observations) {
      z.track += 1000 * ((frame.index + z.track) / kLife);
    }
    std::ranges::sort(frame.observations, {}, &Observation::track);
  }
  Configuration configuration;
  configuration.window.frames = kWindow;
  configuration.model.policy.max_landmarks = 40;
  LoopedWindow run(sequence, configuration);
  int in_prior = 0, measured = 0;
  for (const Frame& frame : sequence.frames) {
    const int accepted = run.process(frame).accepted;
    if (frame.index < 2 * kWindow) continue;
    measured += accepted;
    in_prior += static_cast<int>(std::ranges::count_if(
        run.window->graph().prior().active.blocks(),
        [](const auto& block) { return block.variable->orbit.kind == ScaleOrbit::Kind::kPoint; }));
  }
  EXPECT_GT(measured, 300);
  EXPECT_EQ(in_prior, 0);
}

// Frames in which the camera turns on as it was predicted to, though it is measured: the camera's
// noise changes its rates by 4 degrees/s from one frame to the next. At the camera's pole
// (observation.h) every step of the solution would put a mover's pixel behind the camera.
TEST(Pole, AMoverThatIsDrawnToItDoesNotStopTheWindow) {
  Configuration configuration;
  assign(configuration, {"prior.acceleration", "1"});
  const Sequence sequence = simulate("circle", {{"frames", "150"}, {"moving", "1200"}}, 1);
  const RunResult run = run_estimator(sequence, configuration, "window");
  EXPECT_FALSE(run.diverged);
  for (std::size_t i = 2; i < run.filtered.size(); ++i) {
    const Eigen::Vector3d change =
        run.filtered[i].state.angular_velocity - run.filtered[i - 1].state.angular_velocity;
    EXPECT_GE(change.norm(), 0.002) << i;  // [rad/s]
  }
}

// Where nothing is known beforehand but the first camera, the first steps are long. Undamped, they
// sent landmarks behind the camera, and runs ended before frame 30: with the sequence's prior, and
// with one of 5 m to infinity. Scale is known from the first velocity only, so that positions say
// little.
TEST(WindowLinearisation, FirstEstimatesDampTheirStepsToo) {
  const Sequence sequence =
      simulate("circle", {{"frames", "30"}, {"known", "0"}, {"noise", "0.2"}}, 1);
  for (const bool is_wide : {false, true}) {
    Configuration configuration;
    assign(configuration, {"window.linearisation", "fej"});
    assign(configuration, {"window.frames", "10"});
    for (const char* key :
         {"prior.inverse_depth", "prior.inverse_depth_sigma", "prior.mean_sigma"}) {
      if (is_wide) assign(configuration, {key, "0.1"});
    }
    const RunResult run = run_estimator(sequence, configuration, "window");
    EXPECT_FALSE(run.diverged) << is_wide;
    ASSERT_EQ(run.filtered.size(), sequence.frames.size()) << is_wide;
    const Eigen::Quaterniond& last = run.filtered.back().state.orientation;
    EXPECT_LT(last.angularDistance(sequence.truth.back()->orientation), 0.01) << is_wide;
  }
}

}  // namespace
}  // namespace slammot
