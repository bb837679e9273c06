#include "smoothers/solver/optimise.h"

#include <algorithm>

namespace slammot {

namespace {

constexpr double kFirstDamping = 1e-3;
constexpr double kDampingFactor = 10.0;
constexpr int kTries = 8;
constexpr int kHalvings = 2;
constexpr double kRounding = 1e-9;  // a cost that is higher by less is not higher

void halve_step(Graph& graph) {
  graph.variables.for_each([](Variable& v) { v.step *= 0.5; });
  for (GraphLandmark& landmark : graph.landmarks) {
    for (ChainStep& step : landmark.chain) step.step *= 0.5;
  }
}

}  // namespace

// A step of Gauss-Newton that does not raise the cost, or half or a quarter of it, or one that is
// damped; none when there is none. Halving needs no factorisation.
//
// With fixed points the solution of the equations is not quite the minimum of the cost: on the way
// there it may rise by what would not be worth a step. Nor need a part of the step lower it.
std::optional<Optimiser::Step> Optimiser::find_step(Graph& graph, const GraphCamera& camera,
                                                    double before, double tolerance,
                                                    bool is_last_try, double& damping) {
  const int halvings = graph.fixed_points() ? 0 : kHalvings;
  const auto raises_cost = [&](const StepOutcome& outcome) {
    const double rise = graph.fixed_points() ? outcome.cost_of(tolerance) : kRounding;
    return outcome.cost() > before + rise;
  };
  for (int i = 0; i <= kTries; ++i) {
    NormalEquations& equations = damping > 0.0 ? damped_ : equations_;
    equations.factorise(graph, camera, damping);
    equations.solve(graph);
    const bool is_limited = graph.limit_step();
    Step step{graph.try_step(), is_limited || damping > 0.0};
    if (!raises_cost(step.outcome)) return step;
    if (is_last_try) break;
    for (int k = 0; k < halvings; ++k) {
      halve_step(graph);
      step = {graph.try_step(), true};
      if (!raises_cost(step.outcome)) return step;
    }
    damping = std::max(kFirstDamping, kDampingFactor * damping);
  }
  graph.clear_steps();
  return std::nullopt;
}

// Whole steps end the iteration when they are as predicted. What is left after a shortened one is
// not known, unless there was little to gain: where a landmark may go no further, behind a camera.
bool Optimiser::is_last(const Graph& graph, const Step& step, double before, double damping,
                        double tolerance) {
  if (!step.is_short) return step.outcome.linearisation_error() < tolerance;
  const double gain = before - step.outcome.cost();
  return !graph.fixed_points() && damping <= kFirstDamping &&
         gain < step.outcome.cost_of(tolerance);
}

int Optimiser::operator()(Graph& graph, const GraphCamera& camera, int iterations,
                          double tolerance) {
  double damping = 0.0;
  for (int i = 1;; ++i) {
    const double before = graph.linearise();
    bool last = i >= iterations;
    if (iterations == 1 || rule_ == StepRule::kEvery) {
      equations_.factorise(graph, camera);
      equations_.solve(graph);
      last = last || graph.try_step().linearisation_error() < tolerance;
    } else {
      const bool is_undamped = damping == 0.0;
      const auto step = find_step(graph, camera, before, tolerance, last, damping);
      last = last || !step || is_last(graph, *step, before, damping, tolerance);
      if (last && !is_undamped) equations_.factorise(graph, camera);  // for the marginals
      damping = damping > kFirstDamping ? damping / kDampingFactor : 0.0;
    }
    graph.retract();
    equations_.follow_step(graph);
    if (!last) continue;
    solve_considered(graph, iterations, tolerance);
    return i;
  }
}

void Optimiser::take_step(Graph& graph, const GraphCamera& camera) {
  graph.clear_steps();
  const double before = graph.try_step().cost();
  equations_.factorise(graph, camera);
  equations_.solve(graph);
  if (rule_ == StepRule::kDescent) graph.limit_step();
  const bool takes_any = rule_ == StepRule::kEvery || graph.fixed_points();
  for (int i = 0; !takes_any && graph.try_step().cost() > before + kRounding; ++i) {
    if (i == kTries) {
      graph.clear_steps();
      break;
    }
    halve_step(graph);
  }
  graph.retract();
  equations_.follow_step(graph);
  solve_considered(graph, 1, 0.0);
}

void Optimiser::factorise(Graph& graph, const GraphCamera& camera) {
  equations_.factorise(graph, camera);
  for (std::size_t id = 0; id < graph.landmarks.size(); ++id) {
    if (graph.landmarks[id].is_considered) equations_.add(graph, static_cast<LandmarkId>(id));
  }
}

void Optimiser::solve_considered(Graph& graph, int iterations, double tolerance) {
  bool has_begun = false;
  for (std::size_t i = 0; i < graph.landmarks.size(); ++i) {
    if (!graph.landmarks[i].is_considered) continue;
    if (!has_begun) graph.clear_steps();
    has_begun = true;
    const auto id = static_cast<LandmarkId>(i);
    solve_considered(graph, id, iterations, tolerance);
    equations_.add(graph, id);
  }
}

void Optimiser::solve_considered(Graph& graph, LandmarkId id, int iterations, double tolerance) {
  double damping = 0.0;
  for (int i = 0; i < iterations; ++i) {
    const double before = 0.5 * graph.linearise(graph[id]) + graph.cost_of_prior(id);
    const auto step = find_own_step(graph, id, before, tolerance, damping);
    if (!step) return;
    const bool is_enough = is_last(graph, *step, before, damping, tolerance);
    graph.take_own_step(id);
    if (is_enough) return;
    damping = damping > kFirstDamping ? damping / kDampingFactor : 0.0;
  }
}

// As find_step().
std::optional<Optimiser::Step> Optimiser::find_own_step(Graph& graph, LandmarkId id, double before,
                                                        double tolerance, double& damping) {
  for (int i = 0; i <= kTries; ++i) {
    equations_.solve_considered(graph, id, damping);
    const bool is_limited = graph.limit_step();
    Step step{graph.try_own_step(id), is_limited || damping > 0.0};
    const double rise = graph.fixed_points() ? step.outcome.cost_of(tolerance) : kRounding;
    if (rule_ == StepRule::kEvery || step.outcome.cost() <= before + rise) return step;
    damping = std::max(kFirstDamping, kDampingFactor * damping);
  }
  graph.clear_steps();
  return std::nullopt;
}

}  // namespace slammot
