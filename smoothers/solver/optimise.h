// Gauss-Newton with Marquardt's damping where the cost asks for it.
#pragma once

#include "smoothers/solver/normal_equations.h"

namespace slammot {

// Steps that raise the cost are refused | every step is taken, since the Jacobians are those of the
// truth: what is learnt must not depend on the measurements.
enum class StepRule { kDescent, kEvery };

class Optimiser {
 public:
  explicit Optimiser(StepRule rule = StepRule::kDescent) : rule_(rule) {}

  // Minimises the graph's cost from the current estimate, with at most `iterations` linearisations
  // (>= 1). It ends with the step whose predicted decrease is below `cost_tolerance`, in units of
  // chi-square: 1e-2 is a tenth of a standard deviation.
  //
  // A step of Gauss-Newton that raises the cost is not taken but tried again with more damping
  // (Marquardt 1963). A single iteration is taken whatever the cost says, as in an EKF, and so are
  // all steps with StepRule::kEvery. Throws Diverged as NormalEquations does.
  void operator()(Graph& graph, const GraphCamera& camera, int iterations, double cost_tolerance);

  // One step from the stored linearisation.
  void take_step(Graph& graph, const GraphCamera& camera);

  // Of the last linearisation, without damping; its marginals are in the tangent spaces that the
  // last step led to.
  NormalEquations& equations() { return equations_; }

 private:
  bool find_step(Graph& graph, const GraphCamera& camera, double most, bool is_last,
                 double& damping);

  StepRule rule_;
  NormalEquations equations_, damped_;
};

}  // namespace slammot
