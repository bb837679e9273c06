#include "smoothers/solver/optimise.h"

#include <algorithm>

namespace slammot {

namespace {

constexpr double kFirstDamping = 1e-3;
constexpr double kDampingFactor = 10.0;
constexpr int kTries = 8;

Step no_step(const Graph& graph) {
  Step step;
  for (const auto& [id, v] : graph.variables()) step[id] = SmallVector::Zero(v.dim());
  return step;
}

}  // namespace

OptimiseResult optimise(Graph& graph, int iterations, double cost_tolerance) {
  double damping = 0.0;
  for (int i = 1;; ++i) {
    const double before = graph.linearise();
    OptimiseResult result{NormalEquations(graph), {}};
    result.last_step = result.equations.step();
    const bool last =
        i >= iterations || result.equations.predicted_decrease(result.last_step) < cost_tolerance;
    if (iterations == 1 || graph.prior().first_estimates()) {
      graph.retract(result.last_step);
      if (last) return result;
      continue;
    }
    Step step = damping == 0.0 ? result.last_step : NormalEquations(graph, damping).step();
    bool lower = graph.cost(step) <= before;
    for (int k = 0; !lower && !last && k < kTries; ++k) {
      damping = std::max(kFirstDamping, kDampingFactor * damping);
      step = NormalEquations(graph, damping).step();
      lower = graph.cost(step) <= before;
    }
    if (!lower) step = no_step(graph);
    graph.retract(step);
    result.last_step = std::move(step);
    if (last || !lower) return result;
    damping = damping > kFirstDamping ? damping / kDampingFactor : 0.0;
  }
}

}  // namespace slammot
