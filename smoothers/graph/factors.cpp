#include "smoothers/graph/factors.h"

#include <ceres/sized_cost_function.h>

#include "models/observation.h"
#include "smoothers/graph/camera_manifold.h"
#include "smoothers/graph/cost_tools.h"

namespace slammot {
namespace {

Eigen::Vector3d vector3(const double* p) { return Eigen::Map<const Eigen::Vector3d>(p); }

class InitialCameraCost final : public ceres::SizedCostFunction<12, 3, kMotionSize> {
 public:
  explicit InitialCameraCost(const InitialCamera& initial)
      : mean_(initial.state), weight_(initial.sigmas().cwiseInverse()) {}

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const Vector12d d = boxminus(camera_from_blocks(x[0], x[1]), mean_);
    Eigen::Map<Vector12d>(residuals, 12) = weight_.cwiseProduct(d);
    Matrix12d J = Matrix12d::Identity();
    J.block<3, 3>(kRotation, kRotation) = inverse_right_jacobian_so3(d.segment<3>(kRotation));
    J = weight_.asDiagonal() * J;
    write<12, 3>(jacobians, 0, J.leftCols<3>());
    write_motion<12>(jacobians, 1, x[1], J.rightCols<kMotionDim>());
    return true;
  }

 private:
  CameraState mean_;
  Vector12d weight_;
};

class CameraMotionCost final : public ceres::SizedCostFunction<12, 3, kMotionSize, 3, kMotionSize> {
 public:
  CameraMotionCost(const Matrix12d& weight, double dt) : weight_(weight), dt_(dt) {}

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const CameraState from = camera_from_blocks(x[0], x[1]);
    const CameraState to = camera_from_blocks(x[2], x[3]);
    const Vector12d e = boxminus(to, predict(from, dt_));
    Eigen::Map<Vector12d>(residuals, 12) = weight_ * e;
    if (!jacobians) return true;
    // Log(Exp(-d) E Exp(d')) = e + J_r^-1 d' - J_r^-1 E' d, with E = Exp(e).
    const Eigen::Vector3d e_rotation = e.segment<3>(kRotation);
    const Eigen::Matrix3d J_inverse = inverse_right_jacobian_so3(e_rotation);
    Matrix12d J_to = Matrix12d::Identity(), J_from = -Matrix12d::Identity();
    J_to.block<3, 3>(kRotation, kRotation) = J_inverse;
    J_from.block<3, 3>(kRotation, kRotation) =
        -J_inverse * exp_so3(e_rotation).conjugate().toRotationMatrix();
    J_to = weight_ * J_to;
    J_from = weight_ * J_from * predict_jacobian(from, dt_);
    write<12, 3>(jacobians, 0, J_from.leftCols<3>());
    write_motion<12>(jacobians, 1, x[1], J_from.rightCols<kMotionDim>());
    write<12, 3>(jacobians, 2, J_to.leftCols<3>());
    write_motion<12>(jacobians, 3, x[3], J_to.rightCols<kMotionDim>());
    return true;
  }

 private:
  Matrix12d weight_;
  double dt_;
};

struct Pixel {
  Camera camera;
  Eigen::Vector2d pixel;
  double sigma;
};

class PixelCost final : public ceres::SizedCostFunction<2, 3, kMotionSize, 3, 3> {
 public:
  explicit PixelCost(const Pixel& z) : z_(z) {}

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const CameraState c = camera_from_blocks(x[0], x[1]);
    const auto h = observe(z_.camera, c.position, c.orientation, vector3(x[2]), vector3(x[3]));
    if (!h) return false;
    Eigen::Map<Eigen::Vector2d>(residuals, 2) = (h->pixel - z_.pixel) / z_.sigma;
    Eigen::Matrix<double, 2, kMotionDim> J_motion = Eigen::Matrix<double, 2, kMotionDim>::Zero();
    J_motion.leftCols<3>() = h->J_pose.rightCols<3>() / z_.sigma;
    write<2, 3>(jacobians, 0, h->J_pose.leftCols<3>() / z_.sigma);
    write_motion<2>(jacobians, 1, x[1], J_motion);
    write<2, 3>(jacobians, 2, h->J_anchor / z_.sigma);
    write<2, 3>(jacobians, 3, h->J_y / z_.sigma);
    return true;
  }

 private:
  Pixel z_;
};

class FirstPixelCost final : public ceres::SizedCostFunction<2, kMotionSize, 3> {
 public:
  explicit FirstPixelCost(const Pixel& z) : z_(z) {}

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const Eigen::Vector3d here = Eigen::Vector3d::Zero();
    const CameraState c = camera_from_blocks(here.data(), x[0]);
    const auto h = observe(z_.camera, here, c.orientation, here, vector3(x[1]));
    if (!h) return false;
    Eigen::Map<Eigen::Vector2d>(residuals, 2) = (h->pixel - z_.pixel) / z_.sigma;
    Eigen::Matrix<double, 2, kMotionDim> J_motion = Eigen::Matrix<double, 2, kMotionDim>::Zero();
    J_motion.leftCols<3>() = h->J_pose.rightCols<3>() / z_.sigma;
    write_motion<2>(jacobians, 0, x[0], J_motion);
    write<2, 3>(jacobians, 1, h->J_y / z_.sigma);
    return true;
  }

 private:
  Pixel z_;
};

class InverseDepthPriorCost final : public ceres::SizedCostFunction<1, 3> {
 public:
  explicit InverseDepthPriorCost(const LandmarkPrior& prior) : prior_(prior) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const double sigma = prior_.inverse_depth_sigma;
    residuals[0] = (x[0][2] - prior_.inverse_depth) / sigma;
    write<1, 3>(jacobians, 0, Eigen::RowVector3d(0.0, 0.0, 1.0 / sigma));
    return true;
  }

 private:
  LandmarkPrior prior_;
};

class SharedInverseDepthCost final : public ceres::SizedCostFunction<1, 3, 1> {
 public:
  explicit SharedInverseDepthCost(double sigma) : sigma_(sigma) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    residuals[0] = (x[0][2] - x[1][0]) / sigma_;
    write<1, 3>(jacobians, 0, Eigen::RowVector3d(0.0, 0.0, 1.0 / sigma_));
    write<1, 1>(jacobians, 1, Eigen::Matrix<double, 1, 1>(-1.0 / sigma_));
    return true;
  }

 private:
  double sigma_;
};

class ScenePriorCost final : public ceres::SizedCostFunction<1, 1> {
 public:
  explicit ScenePriorCost(const LandmarkPrior& prior) : prior_(prior) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    residuals[0] = (x[0][0] - prior_.inverse_depth) / prior_.mean_sigma;
    write<1, 1>(jacobians, 0, Eigen::Matrix<double, 1, 1>(1.0 / prior_.mean_sigma));
    return true;
  }

 private:
  LandmarkPrior prior_;
};

// x / sigma, number by number.
class ZeroMeanCost final : public ceres::CostFunction {
 public:
  explicit ZeroMeanCost(const Eigen::VectorXd& sigmas) : sigmas_(sigmas) {
    const auto dim = static_cast<int>(sigmas.size());
    set_num_residuals(dim);
    *mutable_parameter_block_sizes() = {dim};
  }
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const Eigen::Index dim = sigmas_.size();
    Eigen::Map<Eigen::VectorXd>(residuals, dim) =
        Eigen::Map<const Eigen::VectorXd>(x[0], dim).cwiseQuotient(sigmas_);
    if (!jacobians || !jacobians[0]) return true;
    Eigen::Map<Eigen::MatrixXd> J(jacobians[0], dim, dim);
    J.setZero();
    J.diagonal() = sigmas_.cwiseInverse();
    return true;
  }

 private:
  Eigen::VectorXd sigmas_;
};

class KnownLandmarkCost final : public ceres::SizedCostFunction<3, 3, 3> {
 public:
  explicit KnownLandmarkCost(const KnownLandmark& known) : known_(known) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    if (x[1][2] == 0.0) return false;
    const Eigen::Vector3d e = position_world(vector3(x[0]), vector3(x[1])) - known_.position;
    Eigen::Map<Eigen::Vector3d>(residuals, 3) = e / known_.sigma;
    write<3, 3>(jacobians, 0, Eigen::Matrix3d::Identity() / known_.sigma);
    write<3, 3>(jacobians, 1, position_jacobian(vector3(x[1])) / known_.sigma);
    return true;
  }

 private:
  KnownLandmark known_;
};

}  // namespace

Cost initial_camera_cost(const InitialCamera& initial) {
  return std::make_unique<InitialCameraCost>(initial);
}

Cost camera_motion_cost(const Matrix12d& Q, double dt) {
  return std::make_unique<CameraMotionCost>(square_root_information<12>(Q), dt);
}

Cost pixel_cost(const Camera& camera, const Eigen::Vector2d& pixel, double sigma) {
  return std::make_unique<PixelCost>(Pixel{camera, pixel, sigma});
}

Cost first_pixel_cost(const Camera& camera, const Eigen::Vector2d& pixel, double sigma) {
  return std::make_unique<FirstPixelCost>(Pixel{camera, pixel, sigma});
}

Cost inverse_depth_prior_cost(const LandmarkPrior& prior) {
  return std::make_unique<InverseDepthPriorCost>(prior);
}

Cost shared_inverse_depth_cost(const LandmarkPrior& prior) {
  return std::make_unique<SharedInverseDepthCost>(prior.inverse_depth_sigma);
}

Cost scene_prior_cost(const LandmarkPrior& prior) {
  return std::make_unique<ScenePriorCost>(prior);
}

Cost motion_prior_cost(const MotionVector& sigmas) {
  return std::make_unique<ZeroMeanCost>(sigmas);
}

Cost noise_prior_cost(int dim) {
  return std::make_unique<ZeroMeanCost>(Eigen::VectorXd::Ones(dim));
}

Cost known_landmark_cost(const KnownLandmark& known) {
  return std::make_unique<KnownLandmarkCost>(known);
}

}  // namespace slammot
