// Marginalisation in square-root form: everything the leaving variables are tied to becomes a
// prior.
#pragma once

#include <set>

#include "smoothers/graph/graph.h"

namespace slammot {

// The state x = (y, w) of a free landmark is replaced by its next one, x1 = f(x) + G noise:
// dx = F^-1 (dx1 - G dnoise). The variables y and w go on as x1. Q = G G' is never inverted (this
// is the time update of a square-root information filter, Bierman 1977), so it may be singular.
struct Advance {
  VariableId y = 0, w = 0, noise = 0;
  Eigen::Matrix<double, 6, 6> F_inverse;
  Eigen::Matrix<double, 6, 6> G;
  Eigen::Matrix<double, 6, 1> next;  // x1 at the current estimate
};

// Stacks the prior and all factors that touch `leaving` or an advancing state as A dx + b at the
// current estimate, makes the substitutions in their order, brings (A b) to triangular form with
// the leaving columns first, and keeps the rows below them: the prior of the rest. The Hessian is
// never formed. Those factors and the leaving variables are removed from the graph. What advances
// must have its noise among the leaving, and no factor that touches it may be wanted any longer.
// `absorbed` factors become part of the prior too, though nothing they touch leaves. `resting`
// variables, which no other factor touches, go to the far map.
void marginalise(Graph& graph, const std::set<VariableId>& leaving,
                 const std::vector<Advance>& advances = {}, const std::set<FactorId>& absorbed = {},
                 const std::set<VariableId>& resting = {});

}  // namespace slammot
