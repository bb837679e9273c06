// The graph's residuals and Jacobians at the current estimate.
#include "smoothers/graph/chain_step.h"
#include "smoothers/graph/graph.h"
#include "smoothers/scale/noise_scale.h"

namespace slammot {

double Graph::linearise() {
  double sum = prior_.active.square();
  if (initial) {
    linearise(*initial);
    sum += initial->r.squaredNorm();
  }
  for (CameraMotionFactor& factor : motions) {
    linearise(factor);
    sum += factor.r.squaredNorm();
  }
  if (scene) {
    scene->r = (variables[scene->scene].value(0) - scene->inverse_depth) / scene->sigma;
    sum += scene->r * scene->r;
  }
  for (GraphLandmark& landmark : landmarks) {
    if (landmark.is_alive && !landmark.is_considered) sum += linearise(landmark);
  }
  return 0.5 * sum;
}

void Graph::linearise(InitialCameraFactor& f) {
  f.r = initial_camera_residual(f.initial, linearisation_point(f.camera), &f.J);
  if (fixed_points_) f.r = initial_camera_residual(f.initial, camera(f.camera), nullptr);
}

void Graph::linearise(CameraMotionFactor& f) {
  const CameraState to = linearisation_point(f.to);
  f.r = camera_motion_residual(f.weight, f.dt, linearisation_point(f.from), to, &f.J_from, &f.J_to);
  if (!models_.noise_tells_scale)
    leave_out_scale(to.velocity, unknown_speed(f.weight), f.r, f.J_to);
  if (!fixed_points_) return;
  f.r = camera_motion_residual(f.weight, f.dt, camera(f.from), camera(f.to), nullptr, nullptr);
}

// The chain's states at the estimate, and its F at the linearisation points.
void Graph::linearise_chain(GraphLandmark& l) {
  LandmarkVector x = landmark_state(variables[l.y].value, variables[l.w].value);
  LandmarkVector point = fixed_points_
                             ? landmark_state(variables[l.y].point(), variables[l.w].point())
                             : LandmarkVector{};
  for (ChainStep& step : l.chain) {
    take_unit(models_, x, step);
    step.F = chain_jacobian(models_, step, fixed_points_ ? point : x, step.noise);
    x = advance(models_, step, x, step.noise);
    step.x = x;
    if (!fixed_points_) continue;
    point = advance(models_, step, point, step.noise);
    step.point = point;
  }
}

double Graph::linearise(GraphLandmark& l) {
  double sum = linearise_birth(l);
  if (l.is_free()) {
    linearise_chain(l);
    linearise_motion_prior(models_, variables[l.y].value, variables[l.w].value, l.w_prior);
    sum += l.w_prior.r.squaredNorm();
  }
  for (const ChainStep& step : l.chain) sum += step.noise.squaredNorm();
  for (GraphPixel& pixel : l.pixels) {
    const ChainStep* step =
        pixel.depth > 0 ? &l.chain[static_cast<std::size_t>(pixel.depth - 1)] : nullptr;
    const Eigen::Vector3d y = step ? step->x.head<3>() : Eigen::Vector3d(variables[l.y].value);
    if (!fixed_points_) {
      sum += linearise_pixel(pixel, l, y, y);
    } else {
      sum += linearise_pixel(
          pixel, l, y, step ? step->point.head<3>() : Eigen::Vector3d(variables[l.y].point()));
    }
  }
  return sum;
}

double Graph::linearise_pixel(GraphPixel& pixel, const GraphLandmark& l, const Eigen::Vector3d& y,
                              const Eigen::Vector3d& y_point) {
  const Variable& position = variables[pixel.position];
  const Variable& orientation = variables[pixel.orientation];
  const Variable& anchor = variables[l.anchor];
  auto at = pixel_residual(models_, pixel.z, position.point(), quaternion(orientation.point()),
                           anchor.point(), y_point);
  if (at && fixed_points_) {
    const auto here = pixel_residual(models_, pixel.z, position.value,
                                     quaternion(orientation.value), anchor.value, y);
    if (here) {
      at->r = here->r;
    } else {
      at.reset();
    }
  }
  pixel.valid = at.has_value();
  if (!pixel.valid) {
    pixel.at = {Eigen::Vector2d::Zero(), Eigen::Matrix<double, 2, 6>::Zero(), Matrix23d::Zero(),
                Matrix23d::Zero()};
    if (l.constrained) pixel.J_w.setZero(2, models_.landmark->motion);
    return 0.0;
  }
  pixel.at = *at;
  linearise_motion(pixel, l, y_point);
  return at->r.squaredNorm();
}

// Had the landmark moved with w since it came to rest, it would be seen at y + F_yw w.
void Graph::linearise_motion(GraphPixel& pixel, const GraphLandmark& l,
                             const Eigen::Vector3d& y_point) const {
  if (!l.constrained) return;
  const double since_rest = std::max(0.0, pixel.time - l.constrained->rest_time);
  pixel.J_w = pixel.at.J_y.lazyProduct(moved_from_rest(*models_.landmark, y_point, since_rest));
}

bool Graph::is_at_pole(const GraphPixel& pixel) const {
  constexpr double kNear = 0.05;  // [m]
  const double sigma = models_.pixel_sigma * pixel.z.relative_sigma;
  const double steepest = models_.rig[pixel.z.camera].lens.fx / (kNear * sigma);  // d residual / dr
  if (pixel.z.here) return false;
  return !pixel.valid || pixel.at.J_pose.leftCols<3>().norm() > steepest;
}

double Graph::linearise_birth(GraphLandmark& l) {
  BirthPrior& birth = l.birth;
  if (birth.kind == BirthPrior::Kind::kNone) return 0.0;
  birth.r.setZero();
  birth.J_anchor.setZero();
  birth.J_y.setZero();
  birth.J_scene.setZero();
  if (birth.kind == BirthPrior::Kind::kKnown) {
    const auto at = known_residual(models_.point(), birth.known, variables[l.anchor].point(),
                                   variables[l.y].point());
    const auto here = known_residual(models_.point(), birth.known, variables[l.anchor].value,
                                     variables[l.y].value);
    if (!at || !here) return 0.0;
    birth.r = here->r;
    birth.J_anchor = at->J_anchor;
    birth.J_y = at->J_y;
    return birth.r.squaredNorm();
  }
  const bool shared = birth.kind == BirthPrior::Kind::kSharedDepth;
  const SmallVector& y = variables[l.y].value;
  const auto y_point = variables[l.y].point();
  const PointFunctions& point = models_.point();
  const DepthResidual at =
      depth_residual(birth.spread, point.inverse_depth(y_point),
                     shared ? variables[birth.scene].point()(0) : birth.inverse_depth);
  birth.J_y.row(0) = at.J_rho * point.inverse_depth_jacobian(y_point);
  if (shared) birth.J_scene(0) = at.J_mean;
  birth.r(0) = depth_residual(birth.spread, point.inverse_depth(y),
                              shared ? variables[birth.scene].value(0) : birth.inverse_depth)
                   .r;
  return birth.r.squaredNorm();
}

}  // namespace slammot
