// Where a step leads: the cost there, what the linearised problem says of it, and the step taken.
#include <cmath>

#include "smoothers/graph/chain_step.h"
#include "smoothers/graph/graph.h"

namespace slammot {

namespace {

// What a measurement behind the camera costs: a candidate step that puts it there is refused.
constexpr double kImpossible = 1e6;

using Vector1d = Eigen::Matrix<double, 1, 1>;

// (position, orientation, rates) of a camera's step.
Vector12d camera_step(const Variables& variables, const GraphCamera& c) {
  Vector12d d;
  d << variables[c.position].step, variables[c.orientation].step, variables[c.rates].step;
  return d;
}

Vector12d motion_change(const Variables& variables, const CameraMotionFactor& f) {
  return f.J_from * camera_step(variables, f.from) + f.J_to * camera_step(variables, f.to);
}

Eigen::Vector3d birth_change(const Variables& variables, const GraphLandmark& l) {
  Eigen::Vector3d d = l.birth.J_anchor * variables[l.anchor].step.head<3>() +
                      l.birth.J_y * variables[l.y].step.head<3>();
  if (l.birth.scene >= 0) d += l.birth.J_scene * variables[l.birth.scene].step(0);
  return d;
}

MotionVector motion_change(const Variables& variables, const GraphLandmark& l) {
  if (l.w_prior.rows() == 0) return {};
  return l.w_prior.J_y * variables[l.y].step.head<3>() +
         l.w_prior.J_w.cwiseProduct(variables[l.w].step);
}

// J dx of a pixel, where dx is the step of the state that it measures.
Eigen::Vector2d pixel_change(const Variables& variables, const GraphLandmark& l,
                             const GraphPixel& pixel, const LandmarkVector& dx) {
  Eigen::Matrix<double, 6, 1> pose;
  pose << variables[pixel.position].step, variables[pixel.orientation].step;
  return pixel.at.J_pose * pose + pixel.at.J_anchor * variables[l.anchor].step.head<3>() +
         pixel.at.J_y * dx.head<3>();
}

// The step of the base, and of the state after one that steps by dx.
LandmarkVector base_step(const Variables& variables, const GraphLandmark& l) {
  if (!l.is_free()) return variables[l.y].step;
  return landmark_state(variables[l.y].step, variables[l.w].step);
}

LandmarkVector next_step(const ChainStep& step, const LandmarkVector& dx) {
  return step.F.lazyProduct(dx) + step.G.lazyProduct(step.step);
}

}  // namespace

bool Graph::limit_step() {
  if (!lacks_infinity(models_.point())) return false;
  bool is_short = false;
  for (const GraphLandmark& l : landmarks) {
    Variable& v = variables[l.y];
    if (!l.is_alive || !v.is_active) continue;
    const LimitedStep limited = limited_step(models_.point(), v.value, v.step, farthest(l));
    v.step = limited.step;
    is_short |= limited.is_short;
  }
  return is_short;
}

double Graph::farthest(const GraphLandmark& l) const {
  constexpr double kFarthest = 0.01;  // over the birth's mean
  if (l.birth.kind == BirthPrior::Kind::kDepth) return kFarthest * l.birth.inverse_depth;
  if (l.birth.kind != BirthPrior::Kind::kSharedDepth) return 0.0;
  return kFarthest * variables[l.birth.scene].value(0);
}

double StepOutcome::linearisation_error() const {
  return residuals > 0 ? std::sqrt(error_square / residuals) : 0.0;
}

StepOutcome Graph::try_step() {
  variables.for_each([](Variable& v) { v.candidate = plus(v.is_orientation, v.value, v.step); });
  const auto candidate = [&](const GraphCamera& c) {
    CameraState x;
    x.position = variables[c.position].candidate;
    x.orientation = quaternion(variables[c.orientation].candidate);
    x.velocity = variables[c.rates].candidate.head<3>();
    x.angular_velocity = variables[c.rates].candidate.tail<3>();
    return x;
  };
  StepOutcome outcome;
  outcome.square = prior_.active.square(&Variable::candidate);
  if (initial) {
    outcome.square += initial_camera_residual(initial->initial, candidate(initial->camera), nullptr)
                          .squaredNorm();
  }
  // In metres, whatever the Jacobians are in: a step that is far too long must not make its own
  // noise cheap (noise_scale.h).
  for (const CameraMotionFactor& f : motions) {
    const Vector12d r = camera_motion_residual(f.weight, f.dt, candidate(f.from), candidate(f.to),
                                               nullptr, nullptr);
    outcome.add(r, f.r + motion_change(variables, f));
    outcome.square += r.squaredNorm();
  }
  if (scene) {
    const double r = (variables[scene->scene].candidate(0) - scene->inverse_depth) / scene->sigma;
    outcome.square += r * r;
  }
  for (const GraphLandmark& l : landmarks) {
    if (is_solved_jointly(l)) try_step(l, outcome);
  }
  return outcome;
}

void Graph::clear_steps() {
  variables.for_each([](Variable& v) {
    v.step.setZero(v.dim());
    v.candidate = v.value;
  });
  for (GraphLandmark& landmark : landmarks) {
    for (ChainStep& step : landmark.chain) step.step.setZero(step.noise.size());
  }
}

double Graph::cost_of_prior(LandmarkId id, MarginalPrior::Field field) {
  const GraphLandmark& l = (*this)[id];
  return 0.5 * prior_.active.own_square(prior_.active.own_rows(l.y, l.w), field);
}

StepOutcome Graph::try_own_step(LandmarkId id) {
  const GraphLandmark& l = (*this)[id];
  for (const VariableId own : {l.y, l.w}) {
    variables[own].candidate = variables[own].value + variables[own].step;
  }
  StepOutcome outcome;
  outcome.square = 2.0 * cost_of_prior(id, &Variable::candidate);
  try_step(l, outcome);
  return outcome;
}

void Graph::take_own_step(LandmarkId id) {
  GraphLandmark& l = (*this)[id];
  retract(l);
  for (const VariableId own : {l.y, l.w}) {
    Variable& v = variables[own];
    v.value += v.step;
    v.candidate = v.value;
    v.step.setZero();
  }
}

void Graph::try_step(const GraphLandmark& l, StepOutcome& outcome) const {
  const Eigen::Vector3d y = variables[l.y].candidate, anchor = variables[l.anchor].candidate;
  if (l.birth.kind == BirthPrior::Kind::kKnown) {
    const auto at = known_residual(models_.point(), l.birth.known, anchor, y);
    outcome.square += at ? at->r.squaredNorm() : kImpossible;
    if (at) outcome.add(at->r, l.birth.r + birth_change(variables, l));
  } else if (l.birth.kind != BirthPrior::Kind::kNone) {
    const bool shared = l.birth.kind == BirthPrior::Kind::kSharedDepth;
    const double mean = shared ? variables[l.birth.scene].candidate(0) : l.birth.inverse_depth;
    const double r = depth_residual(l.birth.spread, models_.point().inverse_depth(y), mean).r;
    outcome.square += r * r;
    if (!models_.point().linear_depth || l.birth.spread.about > 0.0) {
      outcome.add(Vector1d(r), Vector1d((l.birth.r + birth_change(variables, l)).head<1>()));
    }
  }
  LandmarkVector x = y;
  if (l.is_free()) {
    x = landmark_state(y, variables[l.w].candidate);
    const MotionVector r = motion_residual(models_, l.w_prior, y, variables[l.w].candidate);
    outcome.square += r.squaredNorm();
    if (l.w_prior.unit > 0.0) outcome.add(r, l.w_prior.r + motion_change(variables, l));
  }
  LandmarkVector dx = base_step(variables, l);
  auto pixel = l.pixels.begin();
  for (int depth = 0; depth <= l.steps(); ++depth) {
    if (depth > 0) {
      const ChainStep& step = l.chain[static_cast<std::size_t>(depth - 1)];
      const LandmarkVector noise = step.noise + step.step;
      outcome.square += noise.squaredNorm();
      x = advance(models_, step, x, noise);
      dx = next_step(step, dx);
    }
    for (; pixel != l.pixels.end() && pixel->depth == depth; ++pixel) {
      if (pixel->valid) try_step(*pixel, l, x.head<3>(), dx, outcome);
    }
  }
}

void Graph::try_step(const GraphPixel& pixel, const GraphLandmark& l, const Eigen::Vector3d& y,
                     const LandmarkVector& dx, StepOutcome& outcome) const {
  const auto h = pixel_residual(models_, pixel.z, variables[pixel.position].candidate,
                                quaternion(variables[pixel.orientation].candidate),
                                variables[l.anchor].candidate, y);
  if (!h) {
    outcome.square += kImpossible;
    return;
  }
  outcome.square += h->r.squaredNorm();
  outcome.add(h->r, pixel.at.r + pixel_change(variables, l, pixel, dx));
}

void Graph::retract() {
  if (initial) initial->r += initial->J * camera_step(variables, initial->camera);
  for (CameraMotionFactor& f : motions) f.r += motion_change(variables, f);
  if (scene) scene->r += variables[scene->scene].step(0) / scene->sigma;
  for (GraphLandmark& l : landmarks) {
    if (l.is_alive && variables[l.y].is_active) retract(l);
  }
  variables.for_each([&](Variable& v) {
    const SmallVector before = v.value;
    v.value = plus(v.is_orientation, v.value, v.step);
    if (v.is_orientation && !fixed_points_) v.turn = transport(v.value, before);
  });
  if (!fixed_points_) turn_jacobians();
}

// Jacobians are then of the tangent space at the new orientations.
void Graph::turn_jacobians() {
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
  if (l.birth.kind != BirthPrior::Kind::kNone) l.birth.r += birth_change(variables, l);
  if (l.is_free()) l.w_prior.r += motion_change(variables, l);
  LandmarkVector dx = base_step(variables, l);
  auto pixel = l.pixels.begin();
  for (int depth = 0; depth <= l.steps(); ++depth) {
    if (depth > 0) {
      dx = next_step(l.chain[static_cast<std::size_t>(depth - 1)], dx);
    }
    for (; pixel != l.pixels.end() && pixel->depth == depth; ++pixel) {
      pixel->at.r += pixel_change(variables, l, *pixel, dx);
    }
  }
  if (!l.is_free()) return;
  LandmarkVector x = landmark_state(variables[l.y].value + variables[l.y].step,
                                    variables[l.w].value + variables[l.w].step);
  for (ChainStep& step : l.chain) {
    step.noise += step.step;
    x = advance(models_, step, x, step.noise);
    step.x = x;
  }
}

}  // namespace slammot
