// Gauss-Newton with Marquardt's damping where the cost asks for it.
#pragma once

#include "smoothers/solver/normal_equations.h"

namespace slammot {

struct OptimiseResult {
  NormalEquations equations;  // of the last linearisation, without damping
  Step last_step;             // taken from that linearisation; zero if none was
};

// At most `iterations` linearisations from the current estimate; it ends when a step promises to
// lower the cost by less than `negligible` (in units of chi-square: 1e-2 is a tenth of a
// standard deviation). Steps are those of Gauss-Newton; one that raises the cost is not taken but
// tried again with more damping. Taken as it is, whatever the cost says, is a single iteration, as
// an EKF does, and a step whose Jacobians are not those of the cost: it is its own equations that
// are solved then.
OptimiseResult optimise(Graph& graph, int iterations, double negligible);

}  // namespace slammot
