// The normal equations of a graph's stored linearisation, factorised once: the Gauss-Newton step
// and every marginal covariance are read from the same factorisation.
//
// The private states of each landmark are eliminated first (landmark_group.h), and the core that is
// left (cameras, anchors, everything in the prior) by one dense Cholesky factor:
//   S = U + sum information,   Sigma_core = S^-1.
#pragma once

#include <Eigen/Cholesky>

#include "smoothers/graph/linear_form.h"
#include "smoothers/solver/landmark_group.h"

namespace slammot {

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
  void place_variables(const Graph& graph);
  void add_prior(const Graph& graph);
  void add_factors(const Graph& graph);
  void add_to_core(const Factor& factor, Places places);
  void eliminate_groups(double damping);
  std::size_t index(VariableId id) const;  // in places_
  const Place& place(VariableId id) const { return places_[index(id)].second; }
  // A vector over all variables, from its parts.
  Eigen::VectorXd part(const Place& at, const Eigen::VectorXd& core,
                       const std::vector<LandmarkGroup::Part>& groups) const;

  std::vector<std::pair<VariableId, Place>> places_;  // by id
  std::vector<LandmarkGroup> groups_;
  int core_dim_ = 0;
  Eigen::MatrixXd U_;  // lower triangle; S after the groups are gone
  Eigen::VectorXd g_;  // J'r
  Eigen::VectorXd reduced_g_;
  Eigen::LLT<Eigen::MatrixXd> core_;
};

}  // namespace slammot
