#include "smoothers/ceres/cost_functions.h"

#include <ceres/sized_cost_function.h>

#include "smoothers/ceres/manifolds.h"
#include "smoothers/graph/chain_step.h"
#include "smoothers/scale/noise_scale.h"

namespace slammot {
namespace {

using Block3 = Eigen::Map<const Eigen::Vector3d>;
template <int Rows, int Cols>
using RowMajor = Eigen::Matrix<double, Rows, Cols, Cols == 1 ? Eigen::ColMajor : Eigen::RowMajor>;

Eigen::Quaterniond orientation(const double* q) {
  return Eigen::Quaterniond(Eigen::Map<const Eigen::Vector4d>(q));
}

// Writes a Jacobian with respect to a Euclidean block, if Ceres wants it.
template <typename Derived>
void write(double** jacobians, int block, const Eigen::MatrixBase<Derived>& J) {
  if (!jacobians || !jacobians[block]) return;
  constexpr int kRows = Derived::RowsAtCompileTime, kCols = Derived::ColsAtCompileTime;
  Eigen::Map<RowMajor<kRows, kCols>> out{jacobians[block], J.rows(), J.cols()};
  out = J;
}

// The same for an orientation.
template <typename Derived>
void write_orientation(double** jacobians, int block, const double* q,
                       const Eigen::MatrixBase<Derived>& J) {
  const RowMajor<3, 4> to_tangent = 2.0 * tangent_basis(q).transpose();
  write(jacobians, block, (J * to_tangent).eval());
}

CameraState camera_of(double const* const* x) {
  CameraState c;
  c.position = Block3(x[0]);
  c.orientation = orientation(x[1]);
  c.velocity = Block3(x[2]);
  c.angular_velocity = Block3(x[2] + 3);
  return c;
}

void write_camera(double** jacobians, int block, double const* const* x, const Matrix12d& J) {
  write(jacobians, block, J.leftCols<3>().eval());
  write_orientation(jacobians, block + 1, x[block + 1], J.middleCols<3>(kRotation).eval());
  write(jacobians, block + 2, J.rightCols<6>().eval());
}

class InitialCameraCost final : public ceres::SizedCostFunction<12, 3, 4, 6> {
 public:
  explicit InitialCameraCost(const InitialCamera& initial) : initial_(initial) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    Matrix12d J;
    Eigen::Map<Vector12d>(residuals, 12) = initial_camera_residual(initial_, camera_of(x), &J);
    write_camera(jacobians, 0, x, J);
    return true;
  }

 private:
  InitialCamera initial_;
};

class CameraMotionCost final : public ceres::SizedCostFunction<12, 3, 4, 6, 3, 4, 6> {
 public:
  CameraMotionCost(const Matrix12d& weight, double dt, double speed)
      : weight_(weight), dt_(dt), speed_(speed) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const CameraState to = camera_of(x + 3);
    Matrix12d J_from, J_to;
    Eigen::Map<Vector12d> r(residuals, 12);
    r = camera_motion_residual(weight_, dt_, camera_of(x), to, jacobians ? &J_from : nullptr,
                               &J_to);
    const double e = unknown_speed(weight_);
    const double factor = speed_ > 0.0 ? ratio_of_units(speed_, to.velocity, e) : 1.0;
    scale_linear_part(factor, r);
    if (!jacobians) return true;
    scale_linear_part(factor, J_from);
    scale_linear_part(factor, J_to);
    const bool is_limited = factor == kLeastOfUnits || factor == kMostOfUnits;
    if (speed_ > 0.0 && !is_limited) leave_out_scale(to.velocity, e, r, J_to);
    write_camera(jacobians, 0, x, J_from);
    write_camera(jacobians, 3, x, J_to);
    return true;
  }

 private:
  Matrix12d weight_;
  double dt_, speed_;
};

class PixelCost final : public ceres::SizedCostFunction<2, 3, 4, 3, 3> {
 public:
  PixelCost(const GraphModels& models, const MeasuredPixel& z) : models_(models), z_(z) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const auto at =
        pixel_residual(models_, z_, Block3(x[0]), orientation(x[1]), Block3(x[2]), Block3(x[3]));
    if (!at) return false;
    Eigen::Map<Eigen::Vector2d>(residuals, 2) = at->r;
    write(jacobians, 0, at->J_pose.leftCols<3>().eval());
    write_orientation(jacobians, 1, x[1], at->J_pose.rightCols<3>().eval());
    write(jacobians, 2, at->J_anchor);
    write(jacobians, 3, at->J_y);
    return true;
  }

 private:
  const GraphModels& models_;
  MeasuredPixel z_;
};

class FirstPixelCost final : public ceres::SizedCostFunction<2, 4, 3> {
 public:
  FirstPixelCost(const GraphModels& models, const MeasuredPixel& z) : models_(models), z_(z) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const Eigen::Vector3d here = Eigen::Vector3d::Zero();
    const auto at = pixel_residual(models_, z_, here, orientation(x[0]), here, Block3(x[1]));
    if (!at) return false;
    Eigen::Map<Eigen::Vector2d>(residuals, 2) = at->r;
    write_orientation(jacobians, 0, x[0], at->J_pose.rightCols<3>().eval());
    write(jacobians, 1, at->J_y);
    return true;
  }

 private:
  const GraphModels& models_;
  MeasuredPixel z_;
};

// The Jacobians are carried back along the chain, from the pixel to the base: two rows through each
// step, where carrying the state's Jacobian forward would take six for each noise before.
class ChainPixelCost final : public ceres::CostFunction {
 public:
  ChainPixelCost(const GraphModels& models, const MeasuredPixel& z,
                 const std::vector<ChainStep>& chain, int depth)
      : models_(models), z_(z), chain_(chain), depth_(static_cast<std::size_t>(depth)) {
    set_num_residuals(2);
    *mutable_parameter_block_sizes() = {3, 4, 3, 3, models.landmark->motion};
    for (int i = 0; i < depth; ++i) {
      mutable_parameter_block_sizes()->push_back(models.landmark->dim());
    }
  }

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const int dim = models_.landmark->dim();
    std::vector<LandmarkVector> states(depth_ + 1);
    states[0] = landmark_state(Block3(x[3]), Eigen::Map<const Eigen::VectorXd>(x[4], dim - 3));
    for (std::size_t i = 0; i < depth_; ++i) {
      states[i + 1] = advance(models_, chain_[i], states[i], noise(x, i));
    }
    const auto at = pixel_residual(models_, z_, Block3(x[0]), orientation(x[1]), Block3(x[2]),
                                   states.back().head<3>());
    if (!at) return false;
    Eigen::Map<Eigen::Vector2d>(residuals, 2) = at->r;
    if (!jacobians) return true;
    write(jacobians, 0, at->J_pose.leftCols<3>().eval());
    write_orientation(jacobians, 1, x[1], at->J_pose.rightCols<3>().eval());
    write(jacobians, 2, at->J_anchor);
    Eigen::Matrix<double, 2, Eigen::Dynamic> J =
        Eigen::Matrix<double, 2, Eigen::Dynamic>::Zero(2, dim);
    J.leftCols<3>() = at->J_y;
    for (std::size_t i = depth_; i-- > 0;) {
      const LandmarkMatrix of_noise = noise_jacobian(models_, chain_[i], states[i]);
      write(jacobians, static_cast<int>(5 + i), (J * of_noise).eval());
      J = (J * chain_jacobian(models_, chain_[i], states[i], noise(x, i))).eval();
    }
    write(jacobians, 3, J.leftCols<3>().eval());
    write(jacobians, 4, J.rightCols(dim - 3).eval());
    return true;
  }

 private:
  LandmarkVector noise(double const* const* x, std::size_t i) const {
    return Eigen::Map<const Eigen::VectorXd>(x[5 + i], models_.landmark->dim());
  }

  const GraphModels& models_;
  MeasuredPixel z_;
  const std::vector<ChainStep>& chain_;
  std::size_t depth_;
};

class DepthCost final : public ceres::SizedCostFunction<1, 3> {
 public:
  DepthCost(const PointFunctions& point, const BirthPrior& birth) : point_(point), birth_(birth) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const Eigen::Vector3d y = Block3(x[0]);
    const DepthResidual at =
        depth_residual(birth_.spread, point_.inverse_depth(y), birth_.inverse_depth);
    residuals[0] = at.r;
    write(jacobians, 0, (at.J_rho * point_.inverse_depth_jacobian(y)).eval());
    return true;
  }

 private:
  const PointFunctions& point_;
  BirthPrior birth_;
};

class SharedDepthCost final : public ceres::SizedCostFunction<1, 3, 1> {
 public:
  SharedDepthCost(const PointFunctions& point, const DepthSpread& spread)
      : point_(point), spread_(spread) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const Eigen::Vector3d y = Block3(x[0]);
    const DepthResidual at = depth_residual(spread_, point_.inverse_depth(y), x[1][0]);
    residuals[0] = at.r;
    write(jacobians, 0, (at.J_rho * point_.inverse_depth_jacobian(y)).eval());
    write(jacobians, 1, Eigen::Matrix<double, 1, 1>(at.J_mean));
    return true;
  }

 private:
  const PointFunctions& point_;
  DepthSpread spread_;
};

class KnownLandmarkCost final : public ceres::SizedCostFunction<3, 3, 3> {
 public:
  KnownLandmarkCost(const PointFunctions& point, const KnownLandmark& known)
      : point_(point), known_(known) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const auto at = known_residual(point_, known_, Block3(x[0]), Block3(x[1]));
    if (!at) return false;
    Eigen::Map<Eigen::Vector3d>(residuals, 3) = at->r;
    write(jacobians, 0, at->J_anchor);
    write(jacobians, 1, at->J_y);
    return true;
  }

 private:
  const PointFunctions& point_;
  KnownLandmark known_;
};

class MotionPriorCost final : public ceres::CostFunction {
 public:
  MotionPriorCost(const GraphModels& models, const MotionPrior& prior)
      : models_(models), prior_(prior) {
    const auto dim = static_cast<int>(prior.rows());
    set_num_residuals(dim);
    *mutable_parameter_block_sizes() = {3, dim};
  }
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    MotionPrior at = prior_;
    linearise_motion_prior(models_, Block3(x[0]),
                           Eigen::Map<const Eigen::VectorXd>(x[1], prior_.rows()), at);
    Eigen::Map<Eigen::VectorXd>(residuals, prior_.rows()) = at.r;
    write(jacobians, 0, at.J_y);
    write(jacobians, 1, Eigen::MatrixXd(at.J_w.asDiagonal()));
    return true;
  }

 private:
  const GraphModels& models_;
  MotionPrior prior_;
};

class GaussianCost final : public ceres::CostFunction {
 public:
  GaussianCost(const Eigen::VectorXd& mean, const Eigen::VectorXd& sigmas)
      : mean_(mean), sigmas_(sigmas) {
    const auto dim = static_cast<int>(sigmas.size());
    set_num_residuals(dim);
    *mutable_parameter_block_sizes() = {dim};
  }
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const Eigen::Index dim = sigmas_.size();
    Eigen::Map<Eigen::VectorXd>(residuals, dim) =
        (Eigen::Map<const Eigen::VectorXd>(x[0], dim) - mean_).cwiseQuotient(sigmas_);
    write(jacobians, 0, Eigen::MatrixXd(sigmas_.cwiseInverse().asDiagonal()));
    return true;
  }

 private:
  Eigen::VectorXd mean_, sigmas_;
};

// Of the core: considered landmarks have neither blocks nor rows.
class MarginalPriorCost final : public ceres::CostFunction {
 public:
  explicit MarginalPriorCost(const MarginalPrior& prior)
      : R_(prior.R()), r_(prior.r()), blocks_(prior.blocks()), chart_(prior.chart()) {
    set_num_residuals(static_cast<int>(R_.rows()));
    for (const MarginalPrior::Block& b : prior.blocks()) {
      if (b.variable->is_considered) {
        const MarginalPrior::ConsideredRows rows = prior.own_rows(b.variable->id, -1);
        R_.middleRows(rows.first, rows.count).setZero();
        r_.segment(rows.first, rows.count).setZero();
        continue;
      }
      mutable_parameter_block_sizes()->push_back(static_cast<int>(b.x0.size()));
    }
  }
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    std::vector<SmallVector> b;
    for (std::size_t i = 0, k = 0; i < blocks_.size(); ++i) {
      const Variable& v = *blocks_[i].variable;
      b.push_back(v.is_considered
                      ? v.value
                      : SmallVector(Eigen::Map<const Eigen::VectorXd>(x[k++], v.value.size())));
    }
    ScaleChart chart = chart_;
    chart.bend(blocks_, static_cast<int>(R_.cols()), [&](std::size_t i) { return b[i]; });
    Eigen::Map<Eigen::VectorXd>(residuals, R_.rows()) = R_ * chart.difference() + r_;
    if (!jacobians) return true;
    Eigen::MatrixXd J = R_;
    chart.apply(J);
    int k = 0;
    for (const PriorBlock& block : blocks_) {
      if (block.variable->is_considered) continue;
      const auto columns = J.middleCols(block.offset, block.dim());
      if (block.variable->is_orientation) {
        write_orientation(jacobians, k, x[k], columns.eval());
      } else {
        write(jacobians, k, columns);
      }
      ++k;
    }
    return true;
  }

 private:
  Eigen::MatrixXd R_;
  Eigen::VectorXd r_;
  std::vector<PriorBlock> blocks_;
  ScaleChart chart_;
};

}  // namespace

Cost initial_camera_cost(const InitialCamera& initial) {
  return std::make_unique<InitialCameraCost>(initial);
}

Cost camera_motion_cost(const Matrix12d& weight, double dt, double speed) {
  return std::make_unique<CameraMotionCost>(weight, dt, speed);
}

Cost pixel_cost(const GraphModels& models, const MeasuredPixel& z) {
  if (z.here) return std::make_unique<FirstPixelCost>(models, z);
  return std::make_unique<PixelCost>(models, z);
}

Cost chain_pixel_cost(const GraphModels& models, const MeasuredPixel& z,
                      const std::vector<ChainStep>& chain, int depth) {
  return std::make_unique<ChainPixelCost>(models, z, chain, depth);
}

Cost birth_cost(const PointFunctions& point, const BirthPrior& birth) {
  if (birth.kind == BirthPrior::Kind::kKnown) {
    return std::make_unique<KnownLandmarkCost>(point, birth.known);
  }
  if (birth.kind == BirthPrior::Kind::kSharedDepth) {
    return std::make_unique<SharedDepthCost>(point, birth.spread);
  }
  return std::make_unique<DepthCost>(point, birth);
}

Cost motion_prior_cost(const GraphModels& models, const MotionPrior& prior) {
  return std::make_unique<MotionPriorCost>(models, prior);
}

Cost gaussian_cost(const Eigen::VectorXd& mean, const Eigen::VectorXd& sigmas) {
  return std::make_unique<GaussianCost>(mean, sigmas);
}

Cost marginal_prior_cost(const MarginalPrior& prior) {
  return std::make_unique<MarginalPriorCost>(prior);
}

}  // namespace slammot
