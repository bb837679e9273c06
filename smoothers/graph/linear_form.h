// What a covariance is asked for.
#pragma once

#include "smoothers/graph/graph.h"

namespace slammot {

// Linear combinations of variables: J dx, with the columns of J in the order of the variables. At
// most one landmark's private states may be among them.
struct LinearForm {
  std::vector<VariableId> variables;
  Eigen::MatrixXd J;
};

// A form over far variables too, as one over the graph's own: returns what the far map adds to the
// covariance, J_far Sigma J_far'.
Eigen::MatrixXd replace_far(const Graph& graph, LinearForm& form);

}  // namespace slammot
