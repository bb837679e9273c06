// The joint gate: what all measurements of a frame share must not hide an outlier.
#include <gtest/gtest.h>

#include "tests/estimation/gate_fixture.h"

namespace slammot {
namespace {

using test::judged;
using test::World;

int accepted(const FrameGate& gate, std::size_t n) {
  int count = 0;
  for (std::size_t i = 0; i < n; ++i) count += gate.accepts(i) ? 1 : 0;
  return count;
}

TEST(FrameGate, NisGivenOthersIsThatOfTheConditionalGaussian) {
  World world(5, 13.0, 0.5, 1);
  const FrameGate gate = judged(world.frame, {1.0, 1.0});
  const Eigen::MatrixXd& S = world.S();
  for (Eigen::Index i = 0; i < 5; ++i) {
    std::vector<int> own{static_cast<int>(2 * i), static_cast<int>(2 * i + 1)}, others;
    for (int k = 0; k < 10; ++k) {
      if (k / 2 != i) others.push_back(k);
    }
    const Eigen::MatrixXd gain = S(own, others) * S(others, others).inverse();
    const Eigen::Vector2d nu = world.nu()(own) - gain * world.nu()(others);
    const Eigen::Matrix2d covariance = S(own, own) - gain * S(others, own);
    EXPECT_NEAR(gate.nis_given_others(static_cast<std::size_t>(i)),
                nu.dot(covariance.inverse() * nu), 1e-9);
  }
  EXPECT_NEAR(gate.joint_nis(), world.nu().dot(S.inverse() * world.nu()), 1e-9);
}

// Three sigma of the camera, which one frame in a hundred has, put all beyond a quantile of 95%.
TEST(FrameGate, BelievesMostOfAFrameAgainstItsPrediction) {
  constexpr std::size_t kAll = 30, kOutliers = 8;
  World world(kAll, 13.0, 0.5, 5);
  for (std::size_t i = 0; i < kAll; ++i) {
    world.frame.nu[i] += Eigen::Vector2d(39.0, 39.0);
    if (i < kOutliers) world.frame.nu[i] += Eigen::Vector2d(0.0, 20.0);
  }
  const FrameGate gate = judged(world.frame, {0.95, 0.999});
  for (std::size_t i = 0; i < kAll; ++i) EXPECT_EQ(gate.accepts(i), i >= kOutliers) << i;
  for (std::size_t i = kOutliers; i < kAll; ++i) EXPECT_TRUE(gate.accepts_alone(i)) << i;
}

// One always agrees with itself, and the points of one mover agree with each other.
TEST(FrameGate, AMajorityOfFewDoesNotDecide) {
  for (std::size_t n = 1; n <= 5; ++n) {
    World world(n, 13.0, 0.5, 7);
    for (Eigen::Vector2d& nu : world.frame.nu) nu = {39.0, 39.0};
    const FrameGate gate = judged(world.frame, {0.95, 0.999});
    EXPECT_EQ(accepted(gate, n), n < 5 ? 0 : 5) << n;
  }
}

// Without a majority each is judged on its own, as before.
TEST(FrameGate, DoesNotBelieveAMinority) {
  constexpr std::size_t kAll = 30;
  World world(kAll, 13.0, 0.5, 6);
  for (std::size_t i = 0; i < kAll; ++i) {
    const double turn = static_cast<double>(i % 3) * 2.1;
    world.frame.nu[i] = Eigen::Vector2d(60.0 * std::cos(turn), 60.0 * std::sin(turn));
  }
  const FrameGate gate = judged(world.frame, {0.95, 0.999});
  EXPECT_EQ(accepted(gate, kAll), 0);
}

// Ten pixels of 60 off by 20 sigma of their own, which the camera's 13 px hide from a gate that
// looks at each on its own.
TEST(FrameGate, FindsOutliersThatTheCamerasErrorHides) {
  constexpr std::size_t kAll = 60, kOutliers = 18;
  World world(kAll, 13.0, 0.5, 2);
  for (std::size_t i = 0; i < kOutliers; ++i) {
    world.frame.nu[i] += Eigen::Vector2d((i % 2 == 0 ? 1.0 : -1.0) * 12.0, 9.0);
  }
  const FrameGate alone = judged(world.frame, {0.95, 1.0}),
                  joint = judged(world.frame, {0.95, 0.99});
  int passed_alone = 0, passed = 0;
  for (std::size_t i = 0; i < kOutliers; ++i) {
    passed_alone += alone.accepts(i) ? 1 : 0;
    passed += joint.accepts(i) ? 1 : 0;
  }
  EXPECT_GE(passed_alone, 10);
  EXPECT_EQ(passed, 0);
  EXPECT_GE(accepted(joint, kAll), static_cast<int>(kAll - kOutliers) - 4);
}

// With outliers dropped, the rest is judged as if they had never been there.
TEST(FrameGate, WhatIsLetGoLeavesNoTrace) {
  World world(20, 13.0, 0.5, 3);
  world.frame.nu[4] += Eigen::Vector2d(15.0, 0.0);
  world.frame.nu[11] += Eigen::Vector2d(0.0, -30.0);
  const FrameGate gate = judged(world.frame, {1.0, 0.999});
  EXPECT_FALSE(gate.accepts(4));
  EXPECT_FALSE(gate.accepts(11));
  std::vector<int> kept;
  for (int i = 0; i < 20; ++i) {
    if (!gate.accepts(static_cast<std::size_t>(i))) continue;
    kept.push_back(2 * i);
    kept.push_back(2 * i + 1);
  }
  const Eigen::VectorXd nu = world.nu()(kept);
  const Eigen::MatrixXd S = world.S()(kept, kept);
  EXPECT_NEAR(gate.joint_nis(), nu.dot(S.inverse() * nu), 1e-9);
}

TEST(FrameGate, LetsTheStatedShareOfCorrectMeasurementsPass) {
  World world(30, 13.0, 2.0, 4);
  FrameGate gate({1.0, 0.99}, 1.0);
  int passed = 0;
  constexpr int kFrames = 2000;
  for (int k = 0; k < kFrames; ++k) {
    world.draw();
    gate.judge(world.frame);
    passed += accepted(gate, 30);
  }
  const double share = passed / (30.0 * kFrames);
  EXPECT_NEAR(share, 0.99, 0.002);
}

// All measurements of a frame may be far off together: the camera has jerked. They agree, and pass.
TEST(FrameGate, WhatAllShareIsNoOutlier) {
  World world(30, 13.0, 0.5, 5);
  for (Eigen::Vector2d& nu : world.frame.nu) nu += Eigen::Vector2d(60.0, 0.0);
  const FrameGate gate = judged(world.frame, {1.0, 0.99});
  EXPECT_GE(accepted(gate, 30), 28);
  EXPECT_GT(gate.joint_nis(), 60.0 + 10.0);  // but the frame says that something is wrong
}

TEST(FrameGate, AnEmptyFrameIsNone) {
  FrameInnovation none;
  const FrameGate gate = judged(none, {0.95, 0.99});
  EXPECT_EQ(gate.joint_nis(), 0.0);
}

}  // namespace
}  // namespace slammot
