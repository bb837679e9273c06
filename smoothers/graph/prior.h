// The prior of all variables, as p(b) p(x | b): of the active ones b in square-root form, of the
// inactive ones x given them. Both are kept at the same b0, with the same columns.
#pragma once

#include "smoothers/graph/conditional_map.h"
#include "smoothers/graph/marginal_prior.h"

namespace slammot {

struct Prior {
  MarginalPrior active;
  ConditionalMap inactive;

  // Expresses the prior at the current estimate, to first order.
  void relinearise() {
    inactive.relinearise(active.chart());
    active.relinearise();
  }

  // Conditions on b_i = 0 exactly; nothing to do when the prior does not touch that variable.
  void condition_on_zero(VariableId id) {
    const MarginalPrior::Block* block = active.find(id);
    if (!block) return;
    if (active.keeps_scale() && !block->x0.isZero(0.0)) relinearise();
    inactive.condition_on_zero(*block);
    active.condition_on_zero(id);
  }
};

}  // namespace slammot
