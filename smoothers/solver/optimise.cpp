#include "smoothers/solver/optimise.h"

#include <algorithm>

namespace slammot {

namespace {

constexpr double kFirstDamping = 1e-3;
constexpr double kDampingFactor = 10.0;
constexpr int kTries = 8;
constexpr double kRounding = 1e-9;  // a cost that is higher by less is not higher

// By how much a step may raise the cost. With fixed points the solution of the equations is not
// quite the minimum of the cost: on the way there it may rise by what would not be worth a step.
double allowed_rise(const Graph& graph, double cost_tolerance) {
  return graph.fixed_points() ? cost_tolerance : kRounding;
}

void clear_step(Graph& graph) {
  graph.variables.for_each([](Variable& v) { v.step.setZero(v.dim()); });
  for (GraphLandmark& landmark : graph.landmarks) {
    for (ChainStep& step : landmark.chain) step.step.setZero(step.noise.size());
  }
}

}  // namespace

// A step that costs `most` at most; none when there is none.
bool Optimiser::find_step(Graph& graph, const GraphCamera& camera, double most, bool is_last,
                          double& damping) {
  if (damping > 0.0) {
    damped_.factorise(graph, camera, damping);
    damped_.solve(graph);
  }
  if (graph.cost_after_step() <= most) return true;
  for (int k = 0; !is_last && k < kTries; ++k) {
    damping = std::max(kFirstDamping, kDampingFactor * damping);
    damped_.factorise(graph, camera, damping);
    damped_.solve(graph);
    if (graph.cost_after_step() <= most) return true;
  }
  clear_step(graph);
  return false;
}

void Optimiser::operator()(Graph& graph, const GraphCamera& camera, int iterations,
                           double cost_tolerance) {
  double damping = 0.0;
  for (int i = 1;; ++i) {
    const double before = graph.linearise();
    equations_.factorise(graph, camera);
    equations_.solve(graph);
    bool last = i >= iterations || graph.predicted_decrease() < cost_tolerance;
    if (iterations > 1 && rule_ == StepRule::kDescent) {
      const double most = before + allowed_rise(graph, cost_tolerance);
      last = !find_step(graph, camera, most, last, damping) || last;
      damping = damping > kFirstDamping ? damping / kDampingFactor : 0.0;
    }
    graph.retract();
    equations_.follow_step(graph);
    if (last) return;
  }
}

void Optimiser::take_step(Graph& graph, const GraphCamera& camera) {
  equations_.factorise(graph, camera);
  equations_.solve(graph);
  graph.retract();
  equations_.follow_step(graph);
}

}  // namespace slammot
