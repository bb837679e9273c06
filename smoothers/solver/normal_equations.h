// The normal equations of a graph's stored linearisation, factorised once: the Gauss-Newton step
// and every marginal covariance are read from the same factorisation.
//
// The private variables of each landmark are eliminated first (schur_block.h), and the core that is
// left (cameras, anchors, everything in the prior) by one dense Cholesky factor:
//   S = U + sum of the blocks' information,   Sigma_core = S^-1.
#pragma once

#include <Eigen/Cholesky>

#include "smoothers/graph/state_projection.h"
#include "smoothers/solver/schur_block.h"

namespace slammot {

class NormalEquations {
 public:
  // `damping` multiplies the diagonal of H by 1 + damping (Marquardt 1963); covariances want none.
  // Throws Diverged when H is not positive definite.
  explicit NormalEquations(const Graph& graph, double damping = 0.0);

  // dx = -H^-1 J'r of every variable. Throws Diverged when it is not finite.
  Step step() const;

  // -J'r . dx. For the undamped step() this is the squared Newton decrement: by how much it lowers
  // chi-square (twice Graph::cost) of the linearised problem, never negative.
  double predicted_decrease(const Step& step) const;

  // J Sigma J' of each projection, in the tangent spaces of the linearisation. Only active
  // variables may be projected (substitute_inactive), all known when these equations were built:
  // any other throws std::logic_error.
  std::vector<Eigen::MatrixXd> covariances(const std::vector<StateProjection>& projections) const;

  // Sigma of each set of variables, in the order given. At most one landmark's private states may
  // be in a set.
  std::vector<Eigen::MatrixXd> covariances(const std::vector<std::vector<VariableId>>& sets) const;

 private:
  void place_variables(const Graph& graph);
  void add_prior(const Graph& graph);
  void add_factors(const Graph& graph);
  void add_to_core(const Factor& factor, Places places);
  void eliminate_blocks(double damping);
  Eigen::MatrixXd eliminate_block(const StateProjection& projection,
                                  Eigen::Ref<Eigen::MatrixXd> C) const;
  std::size_t index(VariableId id) const;  // in places_
  const Place& place(VariableId id) const { return places_[index(id)].second; }
  // A vector over all variables, from its parts.
  Eigen::VectorXd part(const Place& at, const Eigen::VectorXd& core,
                       const std::vector<SchurBlock::Part>& blocks) const;

  std::vector<std::pair<VariableId, Place>> places_;  // by id
  std::vector<SchurBlock> blocks_;
  int core_dim_ = 0;
  Eigen::MatrixXd U_;          // lower triangle; S once the blocks are eliminated
  Eigen::VectorXd g_;          // J'r
  Eigen::VectorXd reduced_g_;  // the same, once the blocks are eliminated
  Eigen::LLT<Eigen::MatrixXd> core_;
};

}  // namespace slammot
