// What a covariance is asked of: a linear combination of variables.
#pragma once

#include "smoothers/graph/graph.h"

namespace slammot {

// J dx, with the columns of J in the order of the variables, in their tangent spaces at the current
// estimate. At most one landmark's private states may be among them.
struct StateProjection {
  std::vector<VariableId> variables;
  Eigen::MatrixXd J;
};

// Replaces inactive variables x by the prior's, on which they depend: J_x dx becomes J_x K db. What
// K does not say of them, J_x Sigma J_x', is returned (zero when there are none) and adds to the
// covariance of the projection.
Eigen::MatrixXd substitute_inactive(const Graph& graph, StateProjection& projection);

}  // namespace slammot
