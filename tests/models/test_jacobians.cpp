// Every analytic Jacobian of models/ against Ceres' automatic differentiation, on random states and
// on nearly degenerate ones: rho near 0, rays at the image border, phi near +-pi/2, no rotation.
// Those of points are in test_points.cpp.
#include <gtest/gtest.h>

#include "models/camera.h"
#include "models/camera_motion.h"
#include "models/points/initialisation.h"
#include "models/points/observation.h"
#include "tests/models/fixture.h"

namespace slammot {
namespace {

using namespace test;  // NOLINT(google-build-using-namespace)

TEST(Jacobians, RotationVectorThereAndBack) {
  Random random;
  for (int k = 0; k < kStates; ++k) {
    Eigen::Vector3d theta = random.rotation();
    if (k % 5 == 0) theta *= (M_PI - 1e-7) / std::max(theta.norm(), 1e-300);
    if (theta.norm() > M_PI) theta *= 3.0 / theta.norm();
    EXPECT_LT((log_so3(exp_so3(theta)) - theta).norm(), 1e-9) << theta.transpose();
    const Eigen::Matrix3d J = right_jacobian_so3(theta);
    expect_same((J * inverse_right_jacobian_so3(theta)).eval(), Eigen::Matrix3d::Identity().eval(),
                "J_r J_r^-1");
    // Exp(theta + d) = Exp(theta) Exp(J_r d)
    Vector3<Jet<3>> d;
    for (int i = 0; i < 3; ++i) d(i) = Jet<3>(theta(i), i);
    const Vector3<Jet<3>> moved =
        log_so3(Eigen::Quaternion<Jet<3>>(exp_so3(theta).conjugate().cast<Jet<3>>() * exp_so3(d)));
    expect_same(J, derivatives<3, 3>(moved), "right Jacobian");
  }
}

CameraStateT<Jet<12>> as_jets(const CameraState& x) {
  return {x.position.cast<Jet<12>>(), x.orientation.cast<Jet<12>>(), x.velocity.cast<Jet<12>>(),
          x.angular_velocity.cast<Jet<12>>()};
}

TEST(Jacobians, CameraMotion) {
  Random random;
  Eigen::Matrix<Jet<12>, 12, 1> d;
  for (int i = 0; i < 12; ++i) d(i) = Jet<12>(0.0, i);
  for (int k = 0; k < kStates; ++k) {
    const CameraState x = random_camera(random);
    const double dt = random.uniform(0.01, 0.2);
    const auto y = predict(boxplus(as_jets(x), d), dt);
    const Matrix12d F = derivatives<12, 12>(boxminus(y, as_jets(predict(x, dt))));
    expect_same(predict_jacobian(x, dt), F, "camera motion");
  }
}

Camera camera_with(std::string_view lens, std::vector<double> distortion) {
  return {752, 480, 420.5, 420.6, 355.2, 250.3, make_lens(lens, distortion)};
}

// Beside camera 0, a little turned.
MountedCamera mounted(const Camera& camera) {
  return {camera, exp_so3<double>({0.05, -0.1, 0.2}), {0.3, -0.1, 0.05}};
}

class ObservationJacobians : public testing::TestWithParam<Camera> {};

template <PointParametrisation P>
void expect_jacobians_of_the_pixel(const MountedCamera& mounted) {
  const Camera& camera = mounted.lens;
  constexpr int N = 12;  // position 3, rotation 3, anchor 3, y 3
  constexpr PointFunctions kPoint = point_row<P>();
  Random random;
  int tested = 0;
  while (tested < kStates / 2) {
    const CameraState x = random_camera(random);
    Eigen::Vector3d anchor = random.vector(2.0), y = random_point<P>(random);
    if (tested % 3 == 0) anchor = x.position;  // as in the frame of its birth
    const Eigen::Vector3d ray = mounted.ray(
        ray_camera(x.position, x.orientation, anchor, P::direction(y), P::inverse_depth(y)),
        P::inverse_depth(y));
    if (ray.z() < 0.3 * ray.norm()) continue;  // 72 degrees: beyond the border of any image here
    const auto z = observe(mounted, kPoint, x.position, x.orientation, anchor, y);
    ASSERT_TRUE(z);
    Vector3<Jet<N>> r, a, y_jet, d;
    for (int i = 0; i < 3; ++i) {
      r(i) = Jet<N>(x.position(i), i);
      d(i) = Jet<N>(0.0, 3 + i);
      a(i) = Jet<N>(anchor(i), 6 + i);
      y_jet(i) = Jet<N>(y(i), 9 + i);
    }
    const Eigen::Quaternion<Jet<N>> R(x.orientation.cast<Jet<N>>() * exp_so3(d));
    // The same from the camera's own pose, r + R t and R R_c.
    const Eigen::Quaternion<Jet<N>> R_c = R * mounted.R.cast<Jet<N>>();
    const Vector3<Jet<N>> r_c = r + R * Vector3<Jet<N>>(mounted.t.cast<Jet<N>>());
    const Vector3<Jet<N>> ray_jet =
        ray_camera(r_c, R_c, a, P::direction(y_jet), P::inverse_depth(y_jet));
    const Vector2<Jet<N>> plane(ray_jet.x() / ray_jet.z(), ray_jet.y() / ray_jet.z());
    const Vector2<Jet<N>> distorted =
        std::visit([&](const auto& lens) { return lens.distort(plane); }, camera.lens);
    const Vector2<Jet<N>> pixel(Jet<N>(camera.fx) * distorted.x(),
                                Jet<N>(camera.fy) * distorted.y());
    Eigen::Matrix<double, 2, N> J;
    J << z->J_pose, z->J_anchor, z->J_y;
    expect_same(J, derivatives<2, N>(pixel), "observation");
    EXPECT_NEAR(pixel.x().a + camera.cx, z->pixel.x(), 1e-9);
    ++tested;
  }
}

template <typename... P>
void expect_jacobians_of_every_pixel(const MountedCamera& camera, const std::tuple<P...>*) {
  (expect_jacobians_of_the_pixel<P>(camera), ...);
}

TEST_P(ObservationJacobians, PixelOfALandmark) {
  for (const MountedCamera& camera : {MountedCamera(GetParam()), mounted(GetParam())}) {
    expect_jacobians_of_every_pixel(camera, static_cast<const PointParametrisations*>(nullptr));
  }
}

// The camera's plane is a pole of h, where Jacobians grow beyond what can be eliminated. A fisheye
// has such pixels in its corners.
TEST(Observation, NothingCountsOrBeginsNearThePlaneOfTheCamera) {
  constexpr PointFunctions kPoint = point_row<InverseDepth>();
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  const Eigen::Quaterniond I = Eigen::Quaterniond::Identity();
  const Camera camera;
  Camera fisheye;
  fisheye.lens = make_lens("equidistant", {});
  fisheye.fx = fisheye.fy = 190.0;
  for (const auto& [degrees, counts] : {std::pair{86.0, true}, {88.0, false}}) {
    const double angle = degrees * M_PI / 180.0;
    const Eigen::Vector3d direction(std::sin(angle), 0.0, std::cos(angle));
    const auto seen = observe(camera, kPoint, zero, I, zero, kPoint.of(direction, 0.1, zero));
    ASSERT_EQ(seen.has_value(), counts);
    if (counts) {
      EXPECT_LT(seen->J_y.cwiseAbs().maxCoeff(), 1e3 * camera.fx);
    }
    const Eigen::Vector2d pixel(fisheye.cx + fisheye.fx * angle, fisheye.cy);
    EXPECT_EQ(initialise(fisheye, kPoint, I, pixel, 0.3).has_value(), counts);
  }
}

TEST_P(ObservationJacobians, InitialisationInvertsObservation) {
  Random random;
  const Camera& camera = GetParam();
  for (int k = 0; k < kStates; ++k) {
    const Eigen::Quaterniond R = exp_so3(random.rotation());
    Eigen::Vector2d pixel(random.uniform(0, camera.width - 1),
                          random.uniform(0, camera.height - 1));
    if (k % 5 == 0) pixel = {k % 2 ? -0.5 : camera.width - 0.6, k % 3 ? -0.5 : camera.height - 0.6};
    const PointFunctions& point = point_table()[static_cast<std::size_t>(k) % point_table().size()];
    const auto born = initialise(camera, point, R, pixel, 0.3);
    ASSERT_TRUE(born);
    const Eigen::Vector3d here(1.0, 2.0, 3.0);
    const auto z = observe(camera, point, here, R, here, born->y);
    ASSERT_TRUE(z);
    EXPECT_LT((z->pixel - pixel).norm(), 1e-7);
    // Implicit function theorem, where theta is defined.
    if (std::abs(point.ray(born->y).direction.y()) > 0.9999) continue;
    EXPECT_LT((z->J_y * born->J_pixel - Eigen::Matrix2d::Identity()).norm(), 1e-7);
    const Matrix23d J_rotation = z->J_pose.rightCols<3>();
    EXPECT_LT((z->J_y * born->J_rotation + J_rotation).norm(), 1e-7 * J_rotation.norm());
    EXPECT_LT((z->J_y * born->J_inverse_depth).norm(), 1e-7 * z->J_y.norm());
    const Eigen::RowVector3d J_rho = point.inverse_depth_jacobian(born->y);
    EXPECT_NEAR(point.inverse_depth(born->y), 0.3, 1e-12);
    EXPECT_NEAR(J_rho * born->J_inverse_depth, 1.0, 1e-9);
    EXPECT_LT((J_rho * born->J_pixel).norm(), 1e-9);
  }
}

}  // namespace

void PrintTo(const Camera& camera, std::ostream* out) { *out << lens_name(camera.lens); }

namespace {

INSTANTIATE_TEST_SUITE_P(
    Lenses, ObservationJacobians,
    testing::Values(camera_with("pinhole", {}),
                    camera_with("radtan", {-0.2967, 0.0809, 1e-3, -2e-3}),
                    camera_with("radtan", {-0.2967, 0.0809, 1e-3, -2e-3, 0.01}),
                    camera_with("rational", {0.52, -0.61, 3e-4, -2e-4, 0.49, 0.40, -0.43, 0.42}),
                    camera_with("double_sphere", {-0.2, 0.6}),
                    camera_with("equidistant", {-0.02, 0.003, -0.004, 0.001})),
    [](const auto& tested) {
      return std::string(lens_name(tested.param.lens)) + std::to_string(tested.index);
    });

TEST(CameraNoise, BothDiscretisationsGiveTheVelocityTheSameVariance) {
  CameraState x;
  x.angular_velocity = {0.1, -0.3, 0.2};
  MotionNoise noise{2.0, 0.5, NoiseDiscretisation::kWhiteNoise};
  const double dt = 1.0 / 15.0;
  const Matrix12d white = camera_noise(noise, x, dt);
  noise.discretisation = NoiseDiscretisation::kImpulse;
  const Matrix12d impulse = camera_noise(noise, x, dt);
  EXPECT_LT((white.bottomRightCorner<6, 6>() - impulse.bottomRightCorner<6, 6>()).norm(), 1e-15);
  EXPECT_NEAR(white(kVelocity, kVelocity), std::pow(2.0 * dt, 2), 1e-15);
  EXPECT_EQ(Eigen::FullPivLU<Matrix12d>(white).rank(), 12);
  Eigen::FullPivLU<Matrix12d> lu(impulse);
  lu.setThreshold(1e-9);
  EXPECT_EQ(lu.rank(), 6);
}

}  // namespace
}  // namespace slammot
