// Gauss-Newton with Marquardt's damping where the cost asks for it.
#pragma once

#include "smoothers/solver/normal_equations.h"

namespace slammot {

class Optimiser {
 public:
  // Minimises the graph's cost from the current estimate, with at most `iterations` linearisations
  // (>= 1). It ends with the step whose predicted decrease is below `cost_tolerance`, in units of
  // chi-square: 1e-2 is a tenth of a standard deviation.
  //
  // A step of Gauss-Newton that raises the cost is not taken but tried again with more damping
  // (Marquardt 1963). Two steps are taken whatever the cost says: a single iteration, as in an EKF,
  // and one whose Jacobians are not those of the cost (fixed points), because then the equations
  // are solved, not the cost minimised. Throws Diverged as NormalEquations does.
  void operator()(Graph& graph, const GraphCamera& camera, int iterations, double cost_tolerance);

  // One step from the stored linearisation.
  void take_step(Graph& graph, const GraphCamera& camera);

  // Of the last linearisation, without damping; its marginals are in the tangent spaces that the
  // last step led to.
  NormalEquations& equations() { return equations_; }

 private:
  bool find_step(Graph& graph, const GraphCamera& camera, double cost, bool is_last,
                 double& damping);

  NormalEquations equations_, damped_;
};

}  // namespace slammot
