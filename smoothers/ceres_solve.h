// A graph without prior, solved by Ceres' trust region: for the batch, and as the judge of our own
// Gauss-Newton in tests.
#pragma once

#include "slammot/smoothers/graph.h"

namespace slammot {

// Moves the graph's variables to a minimum of its cost, without the factors that cannot be
// evaluated where it begins; returns how many these are. Throws Diverged when Ceres does not
// converge. One thread, so that the result is always the same.
int solve_with_ceres(Graph& graph);

}  // namespace slammot
