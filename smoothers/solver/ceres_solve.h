// A graph without prior, solved by Ceres' trust region: for the batch, and as the judge of our own
// Gauss-Newton in tests.
#pragma once

#include "smoothers/graph/graph.h"

namespace slammot {

struct CeresSolution {
  int waiting = 0;  // factors that could not be evaluated where it began, and were left out
  int iterations = 0;
};

// Brings the active variables to a minimum of the cost of all factors; the prior is ignored. Throws
// Diverged when Ceres does not converge within `max_iterations`. One thread, so that the result is
// always the same.
CeresSolution solve_with_ceres(Graph& graph, int max_iterations);

}  // namespace slammot
