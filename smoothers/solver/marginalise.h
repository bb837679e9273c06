// Marginalisation in square-root form: the factors of variables that leave become part of the
// prior.
#pragma once

#include <set>

#include "smoothers/graph/graph.h"

namespace slammot {

// The state x = (y, w) of a free landmark is replaced by its next one, x1 = f(x) + G noise, so that
// dx = F^-1 (dx1 - G dnoise). The variables y and w are x1 from then on. Q = G G' is never inverted
// (this is the time update of a square-root information filter, Bierman 1977): it may be singular.
struct Advance {
  VariableId y = 0, w = 0, noise = 0;
  SmallMatrix F_inverse;  // F = df/dx
  SmallMatrix G;
  SmallVector next;  // x1 at the current estimate; y is its first three numbers
};

// Marginalises `leaving`, and moves `deactivated` to the conditional map.
//
// The prior and all factors that touch one of them or an advancing state are stacked as A dx + b at
// the current estimate. The substitutions are made in their order, (A b) is brought to triangular
// form with the leaving columns first, and the rows below those are the new prior. The Hessian is
// never formed. The stacked factors and the leaving variables are removed from the graph.
//
// Every noise of `advances` must leave; factors of an advancing state go into the prior, so any
// that are to be kept must be taken out before and added again. `absorbed` factors become part of
// the prior too, though nothing they touch leaves. No other factor may touch `deactivated`
// variables.
void marginalise(Graph& graph, const std::set<VariableId>& leaving,
                 const std::vector<Advance>& advances = {}, const std::set<FactorId>& absorbed = {},
                 const std::set<VariableId>& deactivated = {});

}  // namespace slammot
