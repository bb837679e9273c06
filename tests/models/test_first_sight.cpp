// What a landmark's first frame says of it (first_sight.h): a minimum and its curvature, against
// the sum of squares written down here from the poses of the rig.
#include <gtest/gtest.h>

#include "models/points/first_sight.h"
#include "tests/models/fixture.h"

namespace slammot {
namespace {

using test::Random;

constexpr double kPixelSigma = 0.7, kThreshold = 1e9;
const InverseDepthPrior kPrior{0.3, 0.2};

Camera lens() {
  const double distortion[] = {-0.1, 0.02};
  return {640, 480, 400.0, 401.0, 320.0, 240.0, make_lens("radtan", distortion)};
}

Rig three_cameras() {
  return {lens(),
          {{lens(), exp_so3<double>({0.02, -0.05, 0.1}), {0.4, 0.0, 0.05}},
           {lens(), exp_so3<double>({-0.03, 0.02, 0.0}), {0.0, 0.3, 0.0}}}};
}

// Residuals in sigmas at u = (pixel, rho): the point where camera c has it, by the rig's poses.
Eigen::VectorXd residuals(const Rig& rig, const Observation& z, std::span<const Observation> others,
                          const Eigen::Vector3d& u) {
  const Eigen::Vector3d g = rig.first().unproject(u.head<2>())->ray.normalized();
  Eigen::VectorXd r(3 + 2 * std::ssize(others));
  r << (u.head<2>() - z.pixel) / (kPixelSigma * z.relative_sigma),
      (u.z() - kPrior.inverse_depth) / kPrior.sigma, Eigen::VectorXd::Zero(2 * std::ssize(others));
  for (std::size_t i = 0; i < others.size(); ++i) {
    const MountedCamera& camera = rig[others[i].camera];
    const Eigen::Vector3d ray = camera.R.inverse() * (g - u.z() * camera.t);
    r.segment<2>(static_cast<Eigen::Index>(3 + 2 * i)) =
        (camera.lens.project(ray)->pixel - others[i].pixel) /
        (kPixelSigma * others[i].relative_sigma);
  }
  return r;
}

struct Seen {
  Observation z;
  std::vector<Observation> others;
};

// A point at `rho` as the rig sees it, with errors of a pixel.
Seen seen_at(const Rig& rig, double rho, Random& random) {
  Seen seen;
  seen.z = {7, {random.uniform(200, 440), random.uniform(150, 330)}, 1.3};
  const Eigen::Vector3d g = rig.first().unproject(seen.z.pixel)->ray.normalized();
  for (int c = 1; c < rig.size(); ++c) {
    const Eigen::Vector2d pixel = rig[c].lens.project(rig[c].ray(g, rho))->pixel;
    seen.others.push_back({7, pixel + random.vector(1.0).head<2>(), 0.8, c});
  }
  return seen;
}

TEST(FirstSight, IsTheMostProbableAndHasItsCurvature) {
  const Rig rig = three_cameras();
  Random random;
  for (const double rho : {1.0, 0.3, 0.05, 0.0, -0.01}) {
    const Seen seen = seen_at(rig, rho, random);
    const FirstSight first = first_sight(rig, kPixelSigma, seen.z, seen.others, kPrior, kThreshold);
    ASSERT_EQ(first.others.size(), 2u);
    EXPECT_TRUE(first.has_own_depth);
    Eigen::Vector3d u;
    u << first.pixel, first.inverse_depth;
    const Eigen::VectorXd r = residuals(rig, seen.z, seen.others, u);
    Eigen::MatrixXd J(r.size(), 3);
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d step = (i < 2 ? 1e-4 : 1e-6) * Eigen::Vector3d::Unit(i);
      J.col(i) = (residuals(rig, seen.z, seen.others, u + step) -
                  residuals(rig, seen.z, seen.others, u - step)) /
                 (2.0 * step.norm());
    }
    const Eigen::Matrix3d H = J.transpose() * J;
    const Eigen::Vector3d sigma = first.covariance.diagonal().cwiseSqrt();
    EXPECT_LT(Eigen::Vector3d(J.transpose() * r).cwiseProduct(sigma).norm(), 1e-5) << rho;
    EXPECT_LT((first.covariance * H - Eigen::Matrix3d::Identity()).norm(), 1e-5) << rho;
    EXPECT_NEAR(first.inverse_depth, rho, 5.0 * sigma.z()) << rho;
  }
}

TEST(FirstSight, LeavesOutAFalseMatchAndKeepsTheOthers) {
  const Rig rig = three_cameras();
  Random random;
  Seen seen = seen_at(rig, 0.3, random);
  const double threshold = 13.8;  // 99.9% of two degrees of freedom
  const FirstSight right = first_sight(rig, kPixelSigma, seen.z, seen.others, kPrior, threshold);
  EXPECT_EQ(right.others.size(), 2u);
  seen.others[0].pixel.y() += 40.0;  // off the epipolar line
  const FirstSight one = first_sight(rig, kPixelSigma, seen.z, seen.others, kPrior, threshold);
  ASSERT_EQ(one.others.size(), 1u);
  EXPECT_EQ(one.others[0].camera, 2);
  seen.others[1].pixel.x() += 40.0;
  const FirstSight none = first_sight(rig, kPixelSigma, seen.z, seen.others, kPrior, threshold);
  EXPECT_TRUE(none.is_of_one_camera());
  EXPECT_FALSE(none.has_own_depth);
  EXPECT_EQ(none.pixel, seen.z.pixel);
}

// Along the optical axis, not along the ray.
TEST(FirstSight, ADepthIsAPriorOfTheInverseDepth) {
  const Camera camera = lens();
  Observation z{3, {600.0, 50.0}};
  z.depth = 4.0;
  z.depth_sigma = 0.02;
  const InverseDepthPrior prior = prior_of_depth(camera, z).value();
  const Eigen::Vector3d ray = camera.unproject(z.pixel)->ray;
  EXPECT_NEAR((ray.normalized() / prior.inverse_depth).z(), 4.0, 1e-12);
  const auto inverse = [&](double depth) { return 1.0 / (ray.norm() * depth); };
  EXPECT_NEAR(prior.sigma, 0.5 * (inverse(3.98) - inverse(4.02)), 1e-4 * prior.sigma);
  EXPECT_TRUE(first_sight(camera, kPixelSigma, z, {}, prior, kThreshold).has_own_depth);
}

}  // namespace
}  // namespace slammot
