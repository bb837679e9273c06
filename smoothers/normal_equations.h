// The normal equations of a graph's stored linearisation, factorised once: the Gauss-Newton step
// and every marginal covariance are read from the same factorisation.
//
// The states of one landmark that no prior touches are tied to cameras, anchors and each other
// only: each such group is eliminated first by its own small Cholesky factor (Schur complement),
// and the core that is left (cameras, anchors, everything in the prior) by one dense one:
//   H = [V W; W' U],  S = U - sum W' V^-1 W,   Sigma_core = S^-1,
//   Sigma_group = V^-1 + V^-1 W S^-1 W' V^-1.
#pragma once

#include <Eigen/Cholesky>

#include "slammot/smoothers/graph.h"

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

class NormalEquations {
 public:
  // `damping` multiplies the diagonal of H by 1 + damping (Marquardt 1963); covariances want none.
  // Throws Diverged when H is not positive definite.
  explicit NormalEquations(const Graph& graph, double damping = 0.0);

  // dx = -H^-1 J'r.
  Step step() const;

  // J'r . dx: minus the squared Newton decrement.
  double slope(const Step& step) const;

  // J Sigma J' for each projection.
  std::vector<Eigen::MatrixXd> covariances(const std::vector<LinearForm>& forms) const;

  // Sigma of each set of variables, in the order given.
  std::vector<Eigen::MatrixXd> covariances(const std::vector<std::vector<VariableId>>& sets) const;

 private:
  struct Group {
    std::vector<VariableId> variables;
    int dim = 0;
    std::vector<int> core_columns;  // the columns of the core that W has, ascending
    Eigen::MatrixXd V, W;           // W: dim x core_columns
    Eigen::VectorXd g;
    Eigen::LLT<Eigen::MatrixXd> llt;
    Eigen::MatrixXd LW;  // L^-1 W
  };
  struct Place {
    int group = -1;  // -1: the core
    int offset = 0;
    int dim = 0;
  };

  void place_variables(const Graph& graph);
  void add_prior(const Graph& graph);
  void add_factors(const Graph& graph);
  // `ties`: of each group, the column of W for an offset in the core.
  void add_factor(const Factor& factor, const std::vector<const Place*>& places,
                  const std::vector<std::map<int, int>>& ties);
  void eliminate_groups(double damping);

  std::map<VariableId, Place> places_;
  std::vector<Group> groups_;
  int core_dim_ = 0;
  Eigen::MatrixXd U_;        // lower triangle; S after the groups are gone
  Eigen::MatrixXd J_group_;  // of the factor that is being added
  Eigen::VectorXd g_;
  Eigen::VectorXd reduced_g_;
  Eigen::LLT<Eigen::MatrixXd> core_;
};

}  // namespace slammot
