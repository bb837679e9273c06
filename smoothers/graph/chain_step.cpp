#include "smoothers/graph/chain_step.h"

#include <algorithm>

namespace slammot {

namespace {

constexpr double kFarthest = 0.01;  // over the stated mean

// y after the step without noise.
Eigen::Vector3d next_point(const GraphModels& models, const ChainStep& step,
                           const LandmarkVector& x) {
  return models.landmark->predict(x, step.dt).head<3>();
}

}  // namespace

double unit_of_motion(const GraphModels& models, const Eigen::Vector3d& y) {
  if (models.noise_tells_scale || !models.landmark->motion_in_metres) return 0.0;
  return std::max(models.point().inverse_depth(y), kFarthest * models.prior.inverse_depth);
}

MotionVector motion_residual(const GraphModels& models, const MotionPrior& prior,
                             const Eigen::Vector3d& y, const MotionVector& w) {
  if (prior.rows() == 0) return {};
  const double relative = prior.unit > 0.0 ? unit_of_motion(models, y) / prior.unit : 1.0;
  return relative * w.cwiseQuotient(prior.sigmas);
}

void linearise_motion_prior(const GraphModels& models, const Eigen::Vector3d& y,
                            const MotionVector& w, MotionPrior& prior) {
  if (prior.rows() == 0) return;
  prior.r = motion_residual(models, prior, y, w);
  prior.J_w = prior.sigmas.cwiseInverse();
  prior.J_y.setZero(prior.rows(), 3);
  if (prior.unit <= 0.0) return;
  const double unit = unit_of_motion(models, y);
  prior.J_w *= unit / prior.unit;
  if (models.point().inverse_depth(y) < unit) return;  // so far away the unit stays
  prior.J_y = w.cwiseQuotient(prior.sigmas) / prior.unit * models.point().inverse_depth_jacobian(y);
}

LandmarkVector advance(const GraphModels& models, const ChainStep& step, const LandmarkVector& x,
                       const LandmarkVector& noise) {
  const LandmarkVector next = models.landmark->predict(x, step.dt);
  LandmarkVector by_noise = step.G.lazyProduct(noise);
  if (step.unit > 0.0) {
    by_noise.tail(models.landmark->motion) *= step.unit / unit_of_motion(models, next.head<3>());
  }
  return next + by_noise;
}

LandmarkMatrix chain_jacobian(const GraphModels& models, const ChainStep& step,
                              const LandmarkVector& x, const LandmarkVector& noise) {
  LandmarkMatrix F = models.landmark->predict_jacobian(x, step.dt);
  if (step.unit <= 0.0) return F;
  const Eigen::Vector3d y = next_point(models, step, x);
  const double unit = unit_of_motion(models, y);
  if (models.point().inverse_depth(y) < unit) return F;  // so far away the unit stays
  const int motion = models.landmark->motion;
  const LandmarkVector by_noise = step.G.lazyProduct(noise);
  const LandmarkMatrix of_unit =
      models.point().inverse_depth_jacobian(y) * F.topRows<3>() / unit;  // d log rho / dx
  F.bottomRows(motion) -= step.unit / unit * by_noise.tail(motion) * of_unit;
  return F;
}

LandmarkMatrix noise_jacobian(const GraphModels& models, const ChainStep& step,
                              const LandmarkVector& x) {
  LandmarkMatrix UG = step.G;
  if (step.unit <= 0.0) return UG;
  const double unit = unit_of_motion(models, next_point(models, step, x));
  UG.bottomRows(models.landmark->motion) *= step.unit / unit;
  return UG;
}

void take_unit(const GraphModels& models, const LandmarkVector& x, ChainStep& step) {
  if (step.unit <= 0.0) return;
  step.G = noise_jacobian(models, step, x);
  step.unit = unit_of_motion(models, next_point(models, step, x));
}

}  // namespace slammot
