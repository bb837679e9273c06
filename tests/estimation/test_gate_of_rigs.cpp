// The gate of several cameras: a landmark is judged with all its pixels, and a false match of one
// camera costs no other's.
#include <gtest/gtest.h>

#include "tests/estimation/gate_fixture.h"

namespace slammot {
namespace {

using test::judged;
using test::World;

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
TEST(GateOfRigs, LetsTheStatedShareOfPairsPass) {
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
TEST(GateOfRigs, AFalseMatchOfOneCameraCostsNoOthersPixel) {
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
TEST(GateOfRigs, AFalseMatchOfOneOfThreeCamerasCostsNoOthersPixel) {
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
TEST(GateOfRigs, NisOfAConsistentRigIsThatOfOneCamera) {
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

TEST(GateOfRigs, NisOfAPairIsOfFourDegreesOfFreedom) {
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

}  // namespace
}  // namespace slammot
