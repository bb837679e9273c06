// The graph as a ceres::Problem, solved by Ceres' trust region: for the batch, for
// `window.solver: ceres`, and as the judge of our own Gauss-Newton in tests.
#pragma once

#include <ceres/problem.h>

#include "smoothers/graph/graph.h"

namespace slammot {

struct CeresProblem {
  std::unique_ptr<ceres::Problem> problem;
  int waiting = 0;  // measurements that could not be evaluated where it began, and were left out
};

// Its parameter blocks are the values in the graph, which must outlive it.
CeresProblem ceres_problem(Graph& graph);

struct CeresSolution {
  int waiting = 0;
  int iterations = 0;
  bool has_converged = false;
};

// Lowers the cost until a step lowers it by less than `function_tolerance` of it or changes
// nothing, again with the noise in units of these speeds until they stay (noise_scale.h), or for
// `max_iterations`. Throws Diverged when Ceres fails. One thread, so that the
// result is always the same.
CeresSolution solve_with_ceres(Graph& graph, int max_iterations, double function_tolerance = 1e-14);

}  // namespace slammot
