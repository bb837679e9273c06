// The joint gate: what all measurements of a frame share must not hide an outlier.
#include "estimation/gate.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>

namespace slammot {
namespace {

// n pixels whose predictions share a camera's error of `common` [px] and have `own` each.
class World {
 public:
  World(std::size_t n, double common, double own, unsigned seed) : engine_(seed) {
    const auto size = static_cast<Eigen::Index>(2 * n);
    S_ = own * own * Eigen::MatrixXd::Identity(size, size);
    for (Eigen::Index i = 0; i < size; ++i) {
      for (Eigen::Index j = i % 2; j < size; j += 2) S_(i, j) += common * common;
    }
    frame.HPHt.resize(size, size);
    *frame.HPHt = S_;
    S_.diagonal().array() += 1.0;  // the pixels' noise
    L_ = S_.llt().matrixL();
    draw();
  }

  void draw() {
    std::normal_distribution<double> normal;
    Eigen::VectorXd unit(S_.rows());
    for (double& x : unit) x = normal(engine_);
    nu_ = L_ * unit;
    frame.z.clear();
    frame.nu.clear();
    for (Eigen::Index i = 0; i < S_.rows(); i += 2) {
      frame.z.push_back({static_cast<int>(i / 2), Eigen::Vector2d::Zero()});
      frame.nu.emplace_back(nu_.segment<2>(i));
    }
  }

  const Eigen::MatrixXd& S() const { return S_; }
  Eigen::VectorXd nu() const { return nu_; }

  FrameInnovation frame;

 private:
  std::mt19937 engine_;
  Eigen::MatrixXd S_, L_;
  Eigen::VectorXd nu_;
};

FrameGate judged(const FrameInnovation& frame, const GateOptions& options) {
  FrameGate gate(options, 1.0);
  gate.judge(frame);
  return gate;
}

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

// Two cameras of a rig, one beside the other: of each landmark's own error (3 of the same size for
// u, v and disparity) both pixels show a part. Landmark i is measured at 2 i and 2 i + 1.
class Pairs {
 public:
  Pairs(std::size_t n, double common, double own, unsigned seed) : engine_(seed) {
    const auto size = static_cast<Eigen::Index>(4 * n);
    frame.HPHt.resize(size, size);
    auto S = *frame.HPHt;
    S.setZero();
    for (Eigen::Index i = 0; i < size; ++i) {
      for (Eigen::Index j = i % 2; j < size; j += 2) S(i, j) = common * common;
    }
    Eigen::Matrix<double, 4, 3> J;
    J << 1, 0, 0, 0, 1, 0, 1, 0, 1, 0, 1, 0;
    for (Eigen::Index i = 0; i < size; i += 4) {
      S.block<4, 4>(i, i) += own * own * J * J.transpose();
    }
    const Eigen::MatrixXd all = S + Eigen::MatrixXd::Identity(size, size);
    L_ = all.llt().matrixL();
    draw();
  }

  void draw() {
    std::normal_distribution<double> normal;
    Eigen::VectorXd unit(L_.rows());
    for (double& x : unit) x = normal(engine_);
    const Eigen::VectorXd nu = L_ * unit;
    frame.z.clear();
    frame.nu.clear();
    for (Eigen::Index i = 0; i < nu.size(); i += 2) {
      const int view = static_cast<int>(i / 2);
      frame.z.push_back({view / 2, Eigen::Vector2d::Zero(), 1.0, view % 2});
      frame.nu.emplace_back(nu.segment<2>(i));
    }
  }

  FrameInnovation frame;

 private:
  std::mt19937 engine_;
  Eigen::MatrixXd L_;
};

// What is judged together is a landmark: the stated share of them keeps both pixels.
TEST(FrameGate, LetsTheStatedShareOfPairsPass) {
  for (const GateOptions options : {GateOptions{1.0, 0.97}, GateOptions{0.97, 1.0}}) {
    Pairs world(20, options.probability < 1.0 ? 0.0 : 13.0, 2.0, 4);
    FrameGate gate(options, 1.0);
    int passed = 0;
    constexpr int kFrames = 1000;
    for (int k = 0; k < kFrames; ++k) {
      world.draw();
      gate.judge(world.frame);
      for (std::size_t i = 0; i < 40; i += 2) {
        passed += gate.accepts(i) && gate.accepts(i + 1) ? 1 : 0;
      }
    }
    EXPECT_NEAR(passed / (20.0 * kFrames), 0.97, 0.005) << options.probability;
  }
}

// Off the epipolar line or along it, in either camera, whatever the camera's error: the other
// pixel of the landmark is used, and no other landmark is lost.
TEST(FrameGate, AFalseMatchOfOneCameraCostsNoOthersPixel) {
  for (const Eigen::Vector2d& off : {Eigen::Vector2d(0.0, 14.0), Eigen::Vector2d(-14.0, 0.0)}) {
    for (const std::size_t wrong : {std::size_t{6}, std::size_t{7}}) {
      Pairs world(20, 13.0, 0.5, 5);
      world.frame.nu[wrong] += off;
      const FrameGate gate = judged(world.frame, {0.9999, 0.9999});
      for (std::size_t i = 0; i < 40; ++i) EXPECT_EQ(gate.accepts(i), i != wrong) << i;
    }
  }
}

// Three cameras: of a landmark's 30, 31 and 32 the second is false.
TEST(FrameGate, AFalseMatchOfOneOfThreeCamerasCostsNoOthersPixel) {
  World world(60, 13.0, 0.5, 8);
  for (std::size_t i = 0; i < 60; ++i) {
    world.frame.z[i].track = static_cast<int>(i / 3);
    world.frame.z[i].camera = static_cast<int>(i % 3);
  }
  world.frame.nu[31] += Eigen::Vector2d(0.0, 20.0);
  const FrameGate gate = judged(world.frame, {0.9999, 0.9999});
  for (std::size_t i = 0; i < 60; ++i) EXPECT_EQ(gate.accepts(i), i != 31) << i;
}

// What a page calls expected (eval/metrics): the mean of what a gate at 95% lets pass.
TEST(FrameGate, NisOfAConsistentRigIsThatOfOneCamera) {
  Pairs world(20, 0.0, 2.0, 9);
  FrameGate gate({0.95, 1.0}, 1.0);
  double sum = 0.0;
  int passed = 0;
  for (int k = 0; k < 1000; ++k) {
    world.draw();
    gate.judge(world.frame);
    for (std::size_t i = 0; i < 40; ++i) {
      if (!gate.accepts(i)) continue;
      sum += gate.nis(i);
      ++passed;
    }
  }
  EXPECT_NEAR(sum / passed, 1.685, 0.03);
}

TEST(FrameGate, NisOfAPairIsOfFourDegreesOfFreedom) {
  Pairs world(10, 5.0, 1.0, 6);
  const FrameGate gate = judged(world.frame, {1.0, 1.0});
  const Eigen::MatrixXd S = Eigen::MatrixXd(*world.frame.HPHt) + Eigen::MatrixXd::Identity(40, 40);
  std::vector<int> own, others;
  Eigen::VectorXd nu(40);
  for (int k = 0; k < 40; ++k) {
    (k / 4 == 3 ? own : others).push_back(k);
    nu(k) = world.frame.nu[static_cast<std::size_t>(k / 2)](k % 2);
  }
  const Eigen::MatrixXd gain = S(own, others) * S(others, others).inverse();
  const Eigen::VectorXd mine = nu(own) - gain * nu(others);
  const double nis = mine.dot((S(own, own) - gain * S(others, own)).inverse() * mine);
  for (const std::size_t i : {6, 7}) {
    EXPECT_NEAR(gate.nis_given_others(i), as_of_one_pixel(nis, 2), 1e-9);
  }
  EXPECT_NEAR(std::exp(log_chi_square_tail(as_of_one_pixel(nis, 2), 1)),
              std::exp(log_chi_square_tail(nis, 2)), 1e-12);
}

TEST(FrameGate, AnEmptyFrameIsNone) {
  FrameInnovation none;
  const FrameGate gate = judged(none, {0.95, 0.99});
  EXPECT_EQ(gate.joint_nis(), 0.0);
}

}  // namespace
}  // namespace slammot
