#include "smoothers/window/slide_along_scale.h"

#include <algorithm>
#include <cmath>

namespace slammot {

namespace {

SmallVector along(const Graph& graph, VariableId id) {
  const Variable& v = graph.variables[id];
  return v.is_orientation ? SmallVector(SmallVector::Zero(3)) : v.orbit.direction(v.value);
}

Vector12d along(const Graph& graph, const GraphCamera& c) {
  Vector12d n;
  n << along(graph, c.position), along(graph, c.orientation), along(graph, c.rates);
  return n;
}

template <typename Vector>
void add(const Vector& Jn, const Vector& r, Eigen::Vector2d& sum) {
  sum += Eigen::Vector2d(Jn.squaredNorm(), Jn.dot(r));
}

void add_cameras(const Graph& graph, Eigen::Vector2d& sum) {
  if (graph.initial) {
    const GraphCamera& c = graph.initial->camera;
    Matrix12d J;
    const Vector12d r = initial_camera_residual(graph.initial->initial, graph.camera(c), &J);
    add<Vector12d>(J * along(graph, c), r, sum);
  }
  for (const CameraMotionFactor& f : graph.motions) {
    if (!graph.models().noise_tells_scale) break;
    Matrix12d J_from, J_to;
    const Vector12d r = camera_motion_residual(f.weight, f.dt, graph.camera(f.from),
                                               graph.camera(f.to), &J_from, &J_to);
    add<Vector12d>(J_from * along(graph, f.from) + J_to * along(graph, f.to), r, sum);
  }
}

// A relative spread of depths says nothing of the scale: then J n = 0.
void add_birth(const Graph& graph, const GraphLandmark& l, Eigen::Vector2d& sum) {
  const SmallVector& y = graph.variables[l.y].value;
  const PointFunctions& point = graph.models().point();
  if (l.birth.kind == BirthPrior::Kind::kNone) return;
  if (l.birth.kind == BirthPrior::Kind::kKnown) {
    const auto at = known_residual(point, l.birth.known, graph.variables[l.anchor].value, y);
    if (!at) return;
    const Eigen::Vector3d of_anchor = along(graph, l.anchor), of_y = along(graph, l.y);
    add<Eigen::Vector3d>(at->J_anchor * of_anchor + at->J_y * of_y, at->r, sum);
    return;
  }
  const bool shared = l.birth.kind == BirthPrior::Kind::kSharedDepth;
  const double rho = point.inverse_depth(y);
  const double mean = shared ? graph.variables[l.birth.scene].value(0) : l.birth.inverse_depth;
  const DepthResidual at = depth_residual(l.birth.spread, rho, mean);
  const double Jn = -at.J_rho * rho - (shared ? at.J_mean * mean : 0.0);
  sum += Eigen::Vector2d(Jn * Jn, Jn * at.r);
}

}  // namespace

Eigen::Vector2d information_of_scale(const Graph& graph) {
  Eigen::Vector2d sum = graph.prior().active.along_scale();
  add_cameras(graph, sum);
  if (graph.scene) {
    const double m = graph.variables[graph.scene->scene].value(0), sigma = graph.scene->sigma;
    sum += Eigen::Vector2d(m * m, -m * (m - graph.scene->inverse_depth)) / (sigma * sigma);
  }
  for (const GraphLandmark& l : graph.landmarks) {
    if (!graph.is_solved_jointly(l)) continue;
    add_birth(graph, l, sum);
    if (!l.is_free() || l.w_prior.rows() == 0 || l.w_prior.unit > 0.0) continue;
    const SmallVector w = graph.variables[l.w].value.cwiseQuotient(l.w_prior.sigmas);
    add<SmallVector>(along(graph, l.w).cwiseQuotient(l.w_prior.sigmas), w, sum);
  }
  return sum;
}

double slide_along_scale(Graph& graph) {
  constexpr double kLongest = 0.2, kNegligible = 1e-4;
  double total = 0.0;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector2d of = information_of_scale(graph);
    if (!(of(0) > 0.0)) break;
    const double t = std::clamp(-of(1) / of(0), -kLongest, kLongest);
    graph.variables.for_each([&](Variable& v) {
      if (!v.is_constrained && !v.is_orientation) v.value = v.orbit.at(v.value, t);
    });
    total += t;
    if (std::abs(t) < kNegligible) break;
  }
  return total;
}

}  // namespace slammot
