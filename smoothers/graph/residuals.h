// The residuals of the graph, each a function of models/ with its weight, and their Jacobians in
// the error states of their variables. The window's own solver and the cost functions for Ceres
// (cost_functions.h) both call them.
#pragma once

#include <optional>

#include "models/camera_motion.h"
#include "models/landmarks/landmark_models.h"
#include "models/points/observation.h"

namespace slammot {

// What all factors share.
struct GraphModels {
  Rig rig;
  double pixel_sigma = 1.0;
  LandmarkPrior prior;  // of the acceleration noise
  const LandmarkFunctions* landmark = nullptr;
  bool noise_tells_scale = true;                     // see noise_scale.h
  bool keeps_scale = false;                          // see scale_chart.h; not with fixed points
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // the world grows about it (W) [m]

  const PointFunctions& point() const { return landmark->point; }
};

// (x [-] x0) / sigma. `J` may be null.
Vector12d initial_camera_residual(const InitialCamera& initial, const CameraState& x, Matrix12d* J);

// L^-1 of L L' = Q. Throws std::invalid_argument when Q is singular (discretisation impulse).
Matrix12d square_root_information(const Matrix12d& Q);

// L^-1 (x1 [-] f(x0)), where `weight` is that L^-1. Both Jacobians may be null.
Vector12d camera_motion_residual(const Matrix12d& weight, double dt, const CameraState& from,
                                 const CameraState& to, Matrix12d* J_from, Matrix12d* J_to);

// (h - z) / sigma with its Jacobians; nothing when the landmark is behind the camera. `here`: seen
// from its anchor, which is the camera's own position, so that h depends on neither.
struct PixelResidual {
  Eigen::Vector2d r;
  Eigen::Matrix<double, 2, 6> J_pose;
  Matrix23d J_anchor, J_y;
};
struct MeasuredPixel {
  Eigen::Vector2d pixel;
  bool here = false;
  double relative_sigma = 1.0;  // as in Observation
  int camera = 0;               // likewise
};
std::optional<PixelResidual> pixel_residual(const GraphModels& models, const MeasuredPixel& z,
                                            const Eigen::Vector3d& position,
                                            const Eigen::Quaterniond& orientation,
                                            const Eigen::Vector3d& anchor,
                                            const Eigen::Vector3d& y);

// (rho - m) / sigma of an inverse depth whose prior has the mean m [1/m]. sigma is `spread.sigma`,
// or with `spread.about` > 0 in proportion to m, and so at m = about: a scene that is twice as
// large has half the spread too, and r is the same in both. Without it a wide prior is an argument
// for a large scene, where all inverse depths are near their mean. m near zero or below has a
// hundredth of the spread.
struct DepthSpread {
  double sigma = 1.0;  // [1/m]
  double about = 0.0;  // [1/m]
};
struct DepthResidual {
  double r = 0.0, J_rho = 0.0, J_mean = 0.0;
};
DepthResidual depth_residual(const DepthSpread& spread, double rho, double mean);

// Whether a parametrisation has no y at infinity. Far away, a step of such a point hardly changes
// its pixels or the cost of its birth, and nothing would determine it there.
inline bool lacks_infinity(const PointFunctions& point) {
  return !point.exists(Eigen::Vector3d::UnitZ(), 0.0);
}

// The step from y of such a point, shortened: rho changes by a factor of e at most, and does not
// fall below `farthest` [1/m] (0: no limit). The direction of the point is that of y + step.
struct LimitedStep {
  Eigen::Vector3d step;
  bool is_short = false;  // by the factor
};
LimitedStep limited_step(const PointFunctions& point, const Eigen::Vector3d& y,
                         const Eigen::Vector3d& step, double farthest);

// (a + G/rho - X) / sigma of a landmark known beforehand; nothing at rho = 0.
struct KnownResidual {
  Eigen::Vector3d r;
  Eigen::Matrix3d J_anchor, J_y;
};
std::optional<KnownResidual> known_residual(const PointFunctions& point, const KnownLandmark& known,
                                            const Eigen::Vector3d& anchor,
                                            const Eigen::Vector3d& y);

}  // namespace slammot
