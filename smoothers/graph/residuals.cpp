#include "smoothers/graph/residuals.h"

#include <algorithm>

#include <Eigen/Cholesky>
#include <stdexcept>

namespace slammot {

Vector12d initial_camera_residual(const InitialCamera& initial, const CameraState& x,
                                  Matrix12d* J) {
  const Vector12d weight = initial.sigmas().cwiseInverse();
  const Vector12d d = boxminus(x, initial.state);
  if (J) {
    J->setIdentity();
    J->block<3, 3>(kRotation, kRotation) = inverse_right_jacobian_so3(d.segment<3>(kRotation));
    *J = (weight.asDiagonal() * *J).eval();
  }
  return weight.cwiseProduct(d);
}

Matrix12d square_root_information(const Matrix12d& Q) {
  const Eigen::LLT<Matrix12d> llt(Q);
  if (llt.info() != Eigen::Success) {
    throw std::invalid_argument(
        "the motion noise Q is singular: a smoother needs motion.discretisation=white_noise and "
        "sigmas above zero");
  }
  return llt.matrixL().solve(Matrix12d::Identity());
}

Vector12d camera_motion_residual(const Matrix12d& weight, double dt, const CameraState& from,
                                 const CameraState& to, Matrix12d* J_from, Matrix12d* J_to) {
  const Vector12d e = boxminus(to, predict(from, dt));
  if (J_from && J_to) {
    // Log(Exp(-d) E Exp(d')) = e + J_r^-1 d' - J_r^-1 E' d, with E = Exp(e).
    const Eigen::Vector3d turn = e.segment<3>(kRotation);
    const Eigen::Matrix3d J_inverse = inverse_right_jacobian_so3(turn);
    Matrix12d to_error = Matrix12d::Identity(), from_error = -Matrix12d::Identity();
    to_error.block<3, 3>(kRotation, kRotation) = J_inverse;
    from_error.block<3, 3>(kRotation, kRotation) =
        -J_inverse * exp_so3(turn).conjugate().toRotationMatrix();
    *J_to = weight * to_error;
    *J_from = weight * from_error * predict_jacobian(from, dt);
  }
  return weight * e;
}

std::optional<PixelResidual> pixel_residual(const GraphModels& models, const MeasuredPixel& z,
                                            const Eigen::Vector3d& position,
                                            const Eigen::Quaterniond& orientation,
                                            const Eigen::Vector3d& anchor,
                                            const Eigen::Vector3d& y) {
  const auto h = observe(models.rig[z.camera], models.point(), position, orientation,
                         z.here ? position : anchor, y);
  if (!h) return std::nullopt;
  const double sigma = models.pixel_sigma * z.relative_sigma;
  PixelResidual result{(h->pixel - z.pixel) / sigma, h->J_pose / sigma, h->J_anchor / sigma,
                       h->J_y / sigma};
  if (z.here) {
    result.J_pose.leftCols<3>().setZero();
    result.J_anchor.setZero();
  }
  return result;
}

DepthResidual depth_residual(const DepthSpread& spread, double rho, double mean) {
  constexpr double kLeast = 0.01;
  const bool follows = spread.about > 0.0, is_least = mean < kLeast * spread.about;
  const double share = !follows ? 1.0 : is_least ? kLeast : mean / spread.about;
  const double sigma = spread.sigma * share, r = (rho - mean) / sigma;
  return {r, 1.0 / sigma, follows && !is_least ? -1.0 / sigma - r / mean : -1.0 / sigma};
}

LimitedStep limited_step(const PointFunctions& point, const Eigen::Vector3d& y,
                         const Eigen::Vector3d& step, double farthest) {
  constexpr double kLargestRatio = 2.718281828459045;
  const Eigen::Vector3d to = y + step;
  const double from = point.inverse_depth(y), asked = point.inverse_depth(to) / from;
  const double by_factor = std::clamp(asked, 1.0 / kLargestRatio, kLargestRatio);
  const double ratio = std::max(by_factor, std::min(farthest / from, 1.0));
  if (ratio == asked) return {step};
  return {point.of(point.ray(to).direction, ratio * from, to) - y, ratio == by_factor};
}

std::optional<KnownResidual> known_residual(const PointFunctions& point, const KnownLandmark& known,
                                            const Eigen::Vector3d& anchor,
                                            const Eigen::Vector3d& y) {
  if (point.inverse_depth(y) == 0.0) return std::nullopt;
  return KnownResidual{(position_world(point, anchor, y) - known.position) / known.sigma,
                       Eigen::Matrix3d::Identity() / known.sigma,
                       position_jacobian(point, y) / known.sigma};
}

}  // namespace slammot
