// Our camera as a variable of GTSAM, and the factors of our static world: the same residuals and
// priors as the window's, but a landmark is a point in W, as is usual with GTSAM.
#pragma once

#include <gtsam/nonlinear/NonlinearFactor.h>

#include "models/camera.h"
#include "smoothers/graph/residuals.h"

template <>
struct gtsam::traits<slammot::CameraState> {
  using structure_category = gtsam::manifold_tag;
  using ManifoldType = slammot::CameraState;
  using TangentVector = slammot::Vector12d;
  enum { dimension = slammot::kCameraDim };
  static int GetDimension(const ManifoldType&) { return dimension; }
  static ManifoldType Retract(const ManifoldType& x, const TangentVector& d) {
    return slammot::boxplus(x, d);
  }
  static TangentVector Local(const ManifoldType& x, const ManifoldType& y) {
    return slammot::boxminus(y, x);
  }
  static void Print(const ManifoldType&, const std::string& /*name*/) {}
  static bool Equals(const ManifoldType& x, const ManifoldType& y, double tolerance) {
    return Local(x, y).norm() < tolerance;
  }
};

namespace slammot::bench {

using gtsam::Key;
using gtsam::OptionalMatrixType;
using gtsam::Vector;

class InitialFactor : public gtsam::NoiseModelFactorN<CameraState> {
 public:
  InitialFactor(Key camera, const InitialCamera& initial)
      : NoiseModelFactorN(gtsam::noiseModel::Unit::Create(kCameraDim), camera), initial_(initial) {}

  Vector evaluateError(const CameraState& x, OptionalMatrixType H) const override {
    Matrix12d J;
    const Vector12d r = initial_camera_residual(initial_, x, H ? &J : nullptr);
    if (H) *H = J;
    return r;
  }

 private:
  InitialCamera initial_;
};

class MotionFactor : public gtsam::NoiseModelFactorN<CameraState, CameraState> {
 public:
  MotionFactor(Key from, Key to, const Matrix12d& weight, double dt)
      : NoiseModelFactorN(gtsam::noiseModel::Unit::Create(kCameraDim), from, to),
        weight_(weight),
        dt_(dt) {}

  Vector evaluateError(const CameraState& from, const CameraState& to, OptionalMatrixType H_from,
                       OptionalMatrixType H_to) const override {
    Matrix12d J_from, J_to;
    const Vector12d r = camera_motion_residual(weight_, dt_, from, to, H_from ? &J_from : nullptr,
                                               H_to ? &J_to : nullptr);
    if (H_from) *H_from = J_from;
    if (H_to) *H_to = J_to;
    return r;
  }

 private:
  Matrix12d weight_;
  double dt_;
};

// Behind the camera it says nothing.
class PixelFactor : public gtsam::NoiseModelFactorN<CameraState, Eigen::Vector3d> {
 public:
  PixelFactor(Key camera, Key point, const gtsam::SharedNoiseModel& noise, const Camera& lens,
              const Eigen::Vector2d& pixel)
      : NoiseModelFactorN(noise, camera, point), lens_(lens), pixel_(pixel) {}

  Vector evaluateError(const CameraState& x, const Eigen::Vector3d& point,
                       OptionalMatrixType H_camera, OptionalMatrixType H_point) const override {
    const Eigen::Matrix3d R_transposed = x.orientation.conjugate().toRotationMatrix();
    const Eigen::Vector3d ray = R_transposed * (point - x.position);
    const auto h = lens_.project(ray);
    const Matrix23d J = h ? h->J_pixel_ray : Matrix23d::Zero();
    const Matrix23d J_point = J * R_transposed;
    if (H_camera) {
      H_camera->setZero(2, kCameraDim);
      H_camera->middleCols<3>(kPosition) = -J_point;
      H_camera->middleCols<3>(kRotation) = J * hat(ray);
    }
    if (H_point) *H_point = J_point;
    return h ? Vector(h->pixel - pixel_) : Vector(Eigen::Vector2d::Zero());
  }

 private:
  const Camera& lens_;
  Eigen::Vector2d pixel_;
};

// The prior of the inverse distance from the camera that saw the point first.
class DepthFactor : public gtsam::NoiseModelFactorN<CameraState, Eigen::Vector3d> {
 public:
  DepthFactor(Key camera, Key point, const LandmarkPrior& prior)
      : NoiseModelFactorN(gtsam::noiseModel::Isotropic::Sigma(1, prior.inverse_depth_sigma), camera,
                          point),
        inverse_depth_(prior.inverse_depth) {}

  Vector evaluateError(const CameraState& x, const Eigen::Vector3d& point,
                       OptionalMatrixType H_camera, OptionalMatrixType H_point) const override {
    const Eigen::Vector3d d = point - x.position;
    const double rho = 1.0 / d.norm();
    const Eigen::RowVector3d J_point = -rho * rho * rho * d.transpose();
    if (H_camera) {
      H_camera->setZero(1, kCameraDim);
      H_camera->middleCols<3>(kPosition) = -J_point;
    }
    if (H_point) *H_point = J_point;
    return gtsam::Vector1(rho - inverse_depth_);
  }

 private:
  double inverse_depth_;
};

}  // namespace slammot::bench
