// Gauss-Newton with shorter steps where the cost asks for it.
#pragma once

#include <optional>

#include "smoothers/solver/normal_equations.h"

namespace slammot {

// Steps that raise the cost are refused | every step is taken, as in an EKF.
enum class StepRule { kDescent, kEvery };

class Optimiser {
 public:
  explicit Optimiser(StepRule rule = StepRule::kDescent) : rule_(rule) {}

  // Minimises the graph's cost from the current estimate, with at most `iterations` linearisations
  // (>= 1). It ends with a step of Gauss-Newton that the linearised problem describes well enough:
  // where it leads, residuals differ from their linear prediction by less than `tolerance` (root
  // mean square, in standard deviations). The next step would change them by about as much. The
  // rule does not depend on the number of measurements, as a decrease of chi-square would.
  //
  // A step of Gauss-Newton that raises the cost is not taken but halved, and then tried again with
  // more damping (Marquardt 1963). Steps to far points are limited (Graph::limit_step). A single
  // iteration is taken whatever the cost says, as in an EKF, and so are all steps with
  // StepRule::kEvery. Considered landmarks are solved for afterwards, one by one, given all the
  // rest. Throws Diverged as NormalEquations does. Returns the number of linearisations.
  int operator()(Graph& graph, const GraphCamera& camera, int iterations, double tolerance);

  // One step from the stored linearisation. One that raises the cost is halved until it does not,
  // or else not taken, unless points are fixed.
  void take_step(Graph& graph, const GraphCamera& camera);

  // Of the stored linearisation, which nothing has been solved for.
  void factorise(Graph& graph, const GraphCamera& camera);

  bool takes_every_step() const { return rule_ == StepRule::kEvery; }

  // Of the last linearisation, without damping; its marginals are in the tangent spaces that the
  // last step led to.
  NormalEquations& equations() { return equations_; }

 private:
  struct Step {
    StepOutcome outcome;
    bool is_short = false;  // halved, damped or limited
  };
  std::optional<Step> find_step(Graph& graph, const GraphCamera& camera, double before,
                                double tolerance, bool is_last_try, double& damping);
  void solve_considered(Graph& graph, int iterations, double tolerance);
  void solve_considered(Graph& graph, LandmarkId id, int iterations, double tolerance);
  std::optional<Step> find_own_step(Graph& graph, LandmarkId id, double before, double tolerance,
                                    double& damping);
  static bool is_last(const Graph& graph, const Step& step, double before, double damping,
                      double tolerance);

  StepRule rule_;
  NormalEquations equations_, damped_;
};

}  // namespace slammot
