// A graph without prior, solved by Ceres' trust region: for the batch, and as the judge of our own
// Gauss-Newton in tests.
#pragma once

#include "slammot/smoothers/graph.h"

namespace slammot {

// Moves the graph's variables to a minimum of its cost. Throws Diverged when Ceres finds no usable
// solution. One thread, so that the result is always the same.
void solve_with_ceres(Graph& graph);

}  // namespace slammot
