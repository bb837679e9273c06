// The part of the map that nothing in the window touches: out of view, and known only through the
// prior's variables b. It is kept as a Gaussian conditional on them,
//
//   x = mean + K (b [-] b0) + e,   e ~ N(0, Sigma),
//
// where b0 and the order of K's columns are those of the prior (graph.h). So the window solves for
// what it sees, at a cost that does not grow with the map, and nothing is approximated: to rest is
// to condition, to return is to condition back (Gaussian identities; in a filter, Guivant and Nebot
// 2001 call the same idea a compressed update).
#pragma once

#include <Eigen/Core>
#include <map>
#include <set>
#include <vector>

namespace slammot {

using VariableId = int;

struct FarMap {
  static constexpr int kDim = 3;  // anchors and y alike

  std::map<VariableId, int> offsets;  // first row of each variable
  std::vector<int> vacant;            // first rows that no variable has: zero everywhere
  Eigen::VectorXd mean;
  Eigen::MatrixXd K;
  Eigen::MatrixXd Sigma;  // the lower triangle

  int dim() const { return kDim * static_cast<int>(offsets.size()); }
  Eigen::Index rows() const { return mean.size(); }  // vacant ones included
  bool empty() const { return offsets.empty(); }
  bool contains(VariableId id) const { return offsets.contains(id); }

  // Rows of `ids`, in their order.
  std::vector<int> rows(const std::vector<VariableId>& ids) const;

  // Sigma of these rows (and columns).
  Eigen::MatrixXd covariance(const std::vector<int>& rows, const std::vector<int>& columns) const;

  // A variable that is known given column `column` of K and the two after it.
  void add(VariableId id, const Eigen::Vector3d& value, Eigen::Index column);

  // Takes variables out without a trace: what remains is the marginal.
  void forget(const std::vector<VariableId>& ids);

  // Marginalises the first columns of K, whose variables are R_ff d_f + R_fr d_r + r_f ~ N(0, I);
  // R = (R_ff R_fr), columns of K in the same order. Some columns of K first stand for combinations
  // of variables: d_stands = T d. Few though these may be, their T may reach many variables that go
  // (a chain of noises): all products here are as thin as they are few.
  void eliminate(const std::vector<int>& stands, const Eigen::MatrixXd& T, const Eigen::MatrixXd& R,
                 const Eigen::VectorXd& r);
};

// What returns to the prior: U (x - mean - K d) ~ N(0, I), U upper triangular.
struct Returned {
  Eigen::VectorXd mean;
  Eigen::MatrixXd K;
  Eigen::MatrixXd U;
};

// Takes `ids` out of the map and conditions the rest on them: they become the first columns of K.
// Throws Diverged when their covariance is none.
Returned take_back(FarMap& far, const std::vector<VariableId>& ids);

}  // namespace slammot
