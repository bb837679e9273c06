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
  bool has_converged = false;  // and the speeds, in whose units the noise was, have stayed
};

// Lowers the cost until a step lowers it by less than `function_tolerance` of it or changes
// nothing, or for `max_iterations`, with the noise in units of the speeds where it began
// (noise_scale.h). Throws Diverged when Ceres fails. One thread, so that the result is always the
// same.
CeresSolution solve_with_ceres(Graph& graph, int max_iterations, double function_tolerance = 1e-14);

}  // namespace slammot
