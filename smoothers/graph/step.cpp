// Where a step leads: the cost there, what the linearised problem says of it, and the step taken.
#include "smoothers/graph/robust.h"

namespace slammot {

namespace {

// What a measurement behind the camera costs: a candidate step that puts it there is refused.
constexpr double kImpossible = 1e6;

}  // namespace

double Graph::cost_after_step() {
  variables.for_each([](Variable& v) { v.candidate = plus(v.is_orientation, v.value, v.step); });
  const auto candidate = [&](const GraphCamera& c) {
    CameraState x;
    x.position = variables[c.position].candidate;
    x.orientation = quaternion(variables[c.orientation].candidate);
    x.velocity = variables[c.rates].candidate.head<3>();
    x.angular_velocity = variables[c.rates].candidate.tail<3>();
    return x;
  };
  double sum = prior_.active.square(&Variable::candidate);
  if (initial) {
    sum += initial_camera_residual(initial->initial, candidate(initial->camera), nullptr)
               .squaredNorm();
  }
  for (const CameraMotionFactor& f : motions) {
    sum +=
        camera_motion_residual(f.weight, f.dt, candidate(f.from), candidate(f.to), nullptr, nullptr)
            .squaredNorm();
  }
  if (scene) {
    const double r = (variables[scene->scene].candidate(0) - scene->inverse_depth) / scene->sigma;
    sum += r * r;
  }
  for (const GraphLandmark& l : landmarks) {
    if (l.is_alive && variables[l.y].is_active) sum += landmark_cost_after_step(l);
  }
  return 0.5 * sum;
}

double Graph::landmark_cost_after_step(const GraphLandmark& l) const {
  double sum = 0.0;
  const Eigen::Vector3d y = variables[l.y].candidate, anchor = variables[l.anchor].candidate;
  if (l.birth.kind == BirthPrior::Kind::kKnown) {
    const auto at = known_residual(l.birth.known, anchor, y);
    sum += at ? at->r.squaredNorm() : kImpossible;
  } else if (l.birth.kind != BirthPrior::Kind::kNone) {
    const bool shared = l.birth.kind == BirthPrior::Kind::kSharedDepth;
    const double r =
        depth_residual(l.birth, y.z(), shared ? variables[l.birth.scene].candidate(0) : 0.0);
    sum += r * r;
  }
  LandmarkVector x = y;
  if (l.is_free()) {
    x = landmark_state(y, variables[l.w].candidate);
    if (l.w_sigmas.size() > 0) {
      sum += variables[l.w].candidate.cwiseQuotient(l.w_sigmas).squaredNorm();
    }
  }
  auto pixel = l.pixels.begin();
  for (int depth = 0; depth <= l.steps(); ++depth) {
    if (depth > 0) {
      const ChainStep& step = l.chain[static_cast<std::size_t>(depth - 1)];
      const LandmarkVector noise = step.noise + step.step;
      sum += noise.squaredNorm();
      x = models_.landmark->predict(x, step.dt) + step.G * noise;
    }
    for (; pixel != l.pixels.end() && pixel->depth == depth; ++pixel) {
      if (!pixel->valid) continue;
      const auto h = pixel_residual(
          models_.camera, models_.pixel_sigma, pixel->z, variables[pixel->position].candidate,
          quaternion(variables[pixel->orientation].candidate), anchor, x.head<3>());
      sum += h ? robust(models_.loss, h->r.squaredNorm(), nullptr) : kImpossible;
    }
  }
  return sum;
}

namespace {

// (position, orientation, rates) of a camera's step.
Vector12d camera_step(const Variables& variables, const GraphCamera& c) {
  Vector12d d;
  d << variables[c.position].step, variables[c.orientation].step, variables[c.rates].step;
  return d;
}

// J dx of a landmark's residuals, told one by one: f(residual, change) for each; both are segments
// of any size.
template <typename Landmark, typename Function>
void for_each_change(const Variables& variables, Landmark& l, Function&& f) {
  const Eigen::Vector3d anchor = variables[l.anchor].step, y = variables[l.y].step;
  if (l.birth.kind != BirthPrior::Kind::kNone) {
    Eigen::Vector3d d = l.birth.J_anchor * anchor + l.birth.J_y * y;
    if (l.birth.scene >= 0) d += l.birth.J_scene * variables[l.birth.scene].step(0);
    f(l.birth.r, d);
  }
  LandmarkVector x = y;
  if (l.is_free()) x = landmark_state(y, variables[l.w].step);
  auto pixel = l.pixels.begin();
  for (int depth = 0; depth <= l.steps(); ++depth) {
    if (depth > 0) {
      const auto& step = l.chain[static_cast<std::size_t>(depth - 1)];
      x = step.F * x + step.G * step.step;
    }
    for (; pixel != l.pixels.end() && pixel->depth == depth; ++pixel) {
      Eigen::Matrix<double, 6, 1> pose;
      pose << variables[pixel->position].step, variables[pixel->orientation].step;
      f(pixel->at.r, Eigen::Vector2d(pixel->at.J_pose * pose + pixel->at.J_anchor * anchor +
                                     pixel->at.J_y * x.template head<3>()));
    }
  }
}

}  // namespace

double Graph::predicted_decrease() const {
  double sum = prior_.active.slope();
  if (initial) sum += initial->r.dot(initial->J * camera_step(variables, initial->camera));
  for (const CameraMotionFactor& f : motions) {
    sum +=
        f.r.dot(f.J_from * camera_step(variables, f.from) + f.J_to * camera_step(variables, f.to));
  }
  if (scene) sum += scene->r * variables[scene->scene].step(0) / scene->sigma;
  for (const GraphLandmark& l : landmarks) {
    if (!l.is_alive || !variables[l.y].is_active) continue;
    for_each_change(variables, l, [&](const auto& r, const auto& d) { sum += r.dot(d); });
    for (const ChainStep& step : l.chain) sum += step.noise.dot(step.step);
    if (l.w_sigmas.size() > 0) {
      sum += variables[l.w]
                 .value.cwiseQuotient(l.w_sigmas)
                 .dot(variables[l.w].step.cwiseQuotient(l.w_sigmas));
    }
  }
  return -sum;
}

void Graph::retract() {
  if (initial) initial->r += initial->J * camera_step(variables, initial->camera);
  for (CameraMotionFactor& f : motions) {
    f.r += f.J_from * camera_step(variables, f.from) + f.J_to * camera_step(variables, f.to);
  }
  if (scene) scene->r += variables[scene->scene].step(0) / scene->sigma;
  for (GraphLandmark& l : landmarks) {
    if (l.is_alive && variables[l.y].is_active) retract(l);
  }
  variables.for_each([&](Variable& v) {
    const SmallVector before = v.value;
    v.value = plus(v.is_orientation, v.value, v.step);
    if (v.is_orientation && !fixed_points_) v.turn = transport(v.value, before);
  });
  if (fixed_points_) return;
  const auto turn = [&](auto&& J, const GraphCamera& c) {
    auto rotation = J.template middleCols<3>(kRotation);
    rotation = (rotation * variables[c.orientation].turn).eval();
  };
  if (initial) turn(initial->J, initial->camera);
  for (CameraMotionFactor& f : motions) {
    turn(f.J_from, f.from);
    turn(f.J_to, f.to);
  }
  for (GraphLandmark& l : landmarks) {
    if (!l.is_alive) continue;
    for (GraphPixel& pixel : l.pixels) {
      auto rotation = pixel.at.J_pose.rightCols<3>();
      rotation = (rotation * variables[pixel.orientation].turn).eval();
    }
  }
}

void Graph::retract(GraphLandmark& l) {
  for_each_change(variables, l, [](auto& r, const auto& d) { r += d; });
  const LandmarkFunctions& model = *models_.landmark;
  if (!l.is_free()) return;
  LandmarkVector x = landmark_state(variables[l.y].value + variables[l.y].step,
                                    variables[l.w].value + variables[l.w].step);
  for (ChainStep& step : l.chain) {
    step.noise += step.step;
    x = model.predict(x, step.dt) + step.G * step.noise;
    step.x = x;
  }
}

}  // namespace slammot
