// What else a file of poses or covariances may hold: each alternative is named where it is the
// truth, and none of a run that is read rightly, nor of one that is lost.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <numbers>
#include <random>

#include "eval/metrics/true_rotations.h"
#include "eval/run/alternatives.h"
#include "models/so3.h"

namespace slammot {
namespace {

using testing::HasSubstr;

constexpr double kPositionSigma = 0.02, kRotationSigma = 0.002;  // [m], [rad]

// A camera that goes and turns, and an estimate with errors of these sigmas in [dr, dtheta].
std::vector<PosePair> good_run(int poses = 100) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const auto noise = [&](double sigma) {
    return Eigen::Vector3d(Eigen::Vector3d::NullaryExpr([&] { return sigma * normal(random); }));
  };
  std::vector<PosePair> pairs;
  for (int i = 0; i < poses; ++i) {
    const double t = 0.1 * i;
    PosePair pair;
    pair.frame = i;
    pair.estimate.timestamp = t;
    pair.truth.position = {t, std::sin(t), 0.3 * std::cos(0.7 * t)};
    pair.truth.orientation = exp_so3(Eigen::Vector3d(0.3 * std::sin(t), 0.1 * t, 0.2 * t));
    pair.estimate.state = pair.truth;
    pair.estimate.state.position -= noise(kPositionSigma);
    pair.estimate.state.orientation =
        pair.truth.orientation * exp_so3<double>(noise(kRotationSigma)).conjugate();
    Eigen::Matrix<double, 6, 1> sigma;
    sigma << Eigen::Vector3d::Constant(kPositionSigma), Eigen::Vector3d::Constant(kRotationSigma);
    pair.estimate.covariance.setConstant(kUndefined);
    pair.estimate.covariance.topLeftCorner<6, 6>() = sigma.cwiseAbs2().asDiagonal();
    pairs.push_back(pair);
  }
  return pairs;
}

using ChangePose = std::function<void(CameraState&)>;
using ChangeCovariance = std::function<Matrix6d(const Matrix6d&)>;

std::string pose_hint(const ChangePose& change, bool exact = true) {
  std::vector<PosePair> pairs = good_run();
  for (PosePair& pair : pairs) change(pair.estimate.state);
  return other_poses(pairs, exact).value_or("none");
}

std::string covariance_hint(const ChangeCovariance& change) {
  std::vector<PosePair> pairs = good_run();
  for (PosePair& pair : pairs) {
    auto P = pair.estimate.covariance.topLeftCorner<6, 6>();
    P = change(P);
  }
  return other_covariances(pairs, {}).value_or("none");
}

void reorder(CameraState& x, const std::array<int, 4>& of_xyzw) {
  const Eigen::Vector4d q = x.orientation.coeffs();
  x.orientation = Eigen::Quaterniond(q(of_xyzw[3]), q(of_xyzw[0]), q(of_xyzw[1]), q(of_xyzw[2]));
}

void invert(CameraState& x) {
  x.orientation = x.orientation.conjugate();
  x.position = -(x.orientation * x.position);
}

const Eigen::Quaterniond kBody(0.5, 0.5, -0.5, 0.5);

TEST(OtherPoses, NothingIsSaidOfAGoodRunNorOfALostOne) {
  EXPECT_EQ(pose_hint([](CameraState&) {}), "none");
  EXPECT_EQ(pose_hint([](CameraState&) {}, false), "none");
  std::vector<PosePair> lost = good_run();
  for (PosePair& pair : lost) {
    pair.estimate.state.position *= 1.0 + 0.01 * pair.frame;
    pair.estimate.state.orientation =
        pair.estimate.state.orientation * exp_so3(Eigen::Vector3d(0.0, 0.02 * pair.frame, 0.0));
  }
  EXPECT_FALSE(other_poses(lost, true));
}

TEST(OtherPoses, OrdersAndInversesAreNamedOnExactAndOnMeasuredTruth) {
  for (const bool exact : {true, false}) {
    // x, y, z, w as read of a file that has w, x, y, z.
    EXPECT_THAT(pose_hint(
                    [](CameraState& x) {
                      reorder(x, {3, 0, 1, 2});
                    },
                    exact),
                HasSubstr("with w first in the quaternions"));
    EXPECT_THAT(pose_hint(
                    [](CameraState& x) {
                      reorder(x, {1, 2, 3, 0});
                    },
                    exact),
                HasSubstr("with w last in the quaternions"));
    EXPECT_THAT(pose_hint(invert, exact), HasSubstr("inverted (T_CW"));
    EXPECT_THAT(pose_hint(
                    [](CameraState& x) {
                      invert(x);
                      reorder(x, {3, 0, 1, 2});
                    },
                    exact),
                HasSubstr("with w first in the quaternions and inverted"));
    EXPECT_THAT(pose_hint([](CameraState& x) { x.orientation = x.orientation.conjugate(); }, exact),
                HasSubstr("with the rotations inverted"));
  }
}

TEST(OtherPoses, AnotherBodyAndAnotherWorldAreConstant) {
  const auto body = [](CameraState& x) { x.orientation = x.orientation * kBody; };
  const auto world = [](CameraState& x) {
    x.orientation = kBody * x.orientation;
    x.position = kBody * x.position + Eigen::Vector3d(1.0, 2.0, 3.0);
  };
  EXPECT_THAT(pose_hint(body), HasSubstr("a constant rotation of 120.0 deg"));
  EXPECT_THAT(pose_hint(world), HasSubstr("another world"));
  EXPECT_THAT(pose_hint(world), testing::Not(HasSubstr("constant rotation")));
  const std::string both = pose_hint([&](CameraState& x) {
    body(x);
    world(x);
  });
  EXPECT_THAT(both, HasSubstr("another world"));
  EXPECT_THAT(both, HasSubstr("constant rotation of 120.1 deg"));  // as the alignment has it
  EXPECT_EQ(pose_hint(world, false), "none");                      // nobody's world
}

TEST(OtherCovariances, NothingIsSaidOfAGoodRunNorOfOneThatIsTwoTimesOff) {
  EXPECT_EQ(covariance_hint([](const Matrix6d& P) { return P; }), "none");
  EXPECT_EQ(covariance_hint([](const Matrix6d& P) -> Matrix6d { return 0.25 * P; }), "none");
  EXPECT_EQ(covariance_hint([](const Matrix6d& P) -> Matrix6d { return 4.0 * P; }), "none");
  EXPECT_EQ(covariance_hint([](const Matrix6d& P) -> Matrix6d { return 1e-3 * P; }), "none");
}

// Of which the upper triangle is written by rows, and read as one.
Matrix6d as_upper_triangle(const std::array<double, 21>& numbers) {
  Matrix6d P;
  std::size_t next = 0;
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) P(i, j) = P(j, i) = numbers[next++];
  }
  return P;
}

TEST(OtherCovariances, OrdersUnitsAndLayoutsAreNamed) {
  const auto swapped = [](const Matrix6d& P) {
    Eigen::PermutationMatrix<6> order(Eigen::Matrix<int, 6, 1>{3, 4, 5, 0, 1, 2});
    return Matrix6d(order * P * order.transpose());
  };
  const auto degrees = [](const Matrix6d& P) {
    Matrix6d D = Matrix6d::Identity();
    D.bottomRightCorner<3, 3>() *= 180.0 / std::numbers::pi;
    return Matrix6d(D * P * D);
  };
  const auto lower = [](const Matrix6d& P) {
    std::array<double, 21> numbers{};
    std::size_t next = 0;
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j <= i; ++j) numbers[next++] = P(i, j);
    }
    return as_upper_triangle(numbers);
  };
  EXPECT_THAT(covariance_hint(swapped),
              HasSubstr("--error-convention rotation-first,right,global"));
  EXPECT_THAT(covariance_hint(degrees), HasSubstr("with rotations in degrees"));
  EXPECT_THAT(covariance_hint([&](const Matrix6d& P) { return swapped(degrees(P)); }),
              testing::AllOf(HasSubstr("degrees"), HasSubstr("rotation-first")));
  EXPECT_THAT(covariance_hint([](const Matrix6d& P) { return Matrix6d(P.cwiseSqrt()); }),
              HasSubstr("as standard deviations, squared"));
  EXPECT_THAT(covariance_hint(lower), HasSubstr("as a lower triangle by rows"));
  EXPECT_THAT(covariance_hint([](const Matrix6d& P) { return Matrix6d(P.inverse()); }),
              HasSubstr("as information, inverted"));
}

TEST(EqualRotations, OfTheTruthOrOfTheRunAreNoRotations) {
  EXPECT_FALSE(equal_rotations(good_run(), false, false));
  std::vector<PosePair> pairs = good_run();
  for (PosePair& pair : pairs) pair.truth.orientation.setIdentity();
  auto equal = equal_rotations(pairs, false, false);
  ASSERT_TRUE(equal);
  EXPECT_TRUE(equal->not_judged);
  EXPECT_FALSE(equal_rotations(pairs, false, true)->not_judged);
  EXPECT_THAT(equal->reason,
              HasSubstr("all true rotations are equal, while those of the run span"));
  for (PosePair& pair : pairs) pair.estimate.state.position.x() += pair.frame;  // it is lost
  EXPECT_FALSE(equal_rotations(pairs, false, false));
  pairs = good_run();
  for (PosePair& pair : pairs) pair.estimate.state.orientation.setIdentity();
  equal = equal_rotations(pairs, false, false);
  ASSERT_TRUE(equal);
  EXPECT_FALSE(equal->not_judged);
  for (PosePair& pair : pairs)
    pair.truth.orientation = exp_so3(Eigen::Vector3d(0, 0, 1e-4 * pair.frame));
  EXPECT_FALSE(equal_rotations(pairs, false, false));  // hardly turns
}

}  // namespace
}  // namespace slammot
