// The private variables of one landmark in the normal equations: its state (y, w), until the prior
// touches it, and the noises of its chain. Factors tie them to cameras, anchors and each other
// only, so they are eliminated before the core (cameras, anchors, everything in the prior).
//
// The noises n have a unit prior and many components (6 a step), but few rows measure them (2 a
// pixel). They are eliminated in the space of those rows, r + N n + X x. Let D = I (+ damping),
// M = I + N D^-1 N' = L L', and p the residual of the unit priors. Then L^-1 (r - N D^-1 p) +
// L^-1 X x is left: the pixels, with the covariance that the noise gives them. The state follows by
// a Schur complement:
//   H = [V W; W' U],  S = U - W' V^-1 W.
#pragma once

#include <Eigen/Cholesky>
#include <map>
#include <span>
#include <vector>

#include "smoothers/graph/graph.h"

namespace slammot {

// Where a variable stands in the normal equations.
struct Place {
  enum class Part { kCore, kStates, kNoises };
  Part part = Part::kCore;
  int block = -1;  // which Schur block; -1 in the core
  int offset = 0;  // first row in its part
  int dim = 0;
};
using Places = std::span<const Place* const>;  // of a factor's variables

class SchurBlock {
 public:
  // To be called in this order: add_variable() for each variable, tie() for each factor that
  // touches one of them, begin(), add() for the same factors in the same order, eliminate().
  Place add_variable(int block, int dim, bool is_noise);
  void tie(Places places, Eigen::Index rows);
  void begin();
  void add(const Factor& factor, Places places);

  // Throws Diverged when the variables are not determined. `damping`: see NormalEquations.
  void eliminate(double damping);

  // What eliminate() leaves for the core, as the lower triangle and the gradient in its columns
  // core_columns(), ascending.
  const std::vector<int>& core_columns() const { return columns_; }
  const Eigen::MatrixXd& core_information() const { return information_; }
  const Eigen::VectorXd& core_gradient() const { return core_gradient_; }
  // The diagonal that rows with noise would have added to H there.
  Eigen::VectorXd core_squares() const {
    return X_.rightCols(std::ssize(columns_)).colwise().squaredNorm();
  }

  // Vectors over the private variables: their part of J'r, and their step given that of the core.
  struct Part {
    Eigen::VectorXd states, noises;
  };
  const Part& gradient() const { return g_; }
  Part step(const Eigen::VectorXd& core) const;

  // Of a projection with J' = (E_states, E_noises) here and `core` (core_columns() x rows) in the
  // core: returns what this block adds to its covariance, and brings `core` to C, so that the
  // covariance is that and C' S^-1 C.
  Eigen::MatrixXd covariance(const Eigen::MatrixXd& E_states, const Eigen::MatrixXd& E_noises,
                             Eigen::Ref<Eigen::MatrixXd> core) const;

  Eigen::Index states() const { return dim_; }
  Eigen::Index noises() const { return noise_dim_; }

  // Whether one of these variables is a noise.
  static bool has_noise(Places places);

 private:
  void add_prior_of_noise(const Factor& factor, const Place& place);
  void add_row_with_noise(const Factor& factor, Places places);
  void add_row_of_states(const Factor& factor, Places places);
  void eliminate_noises();

  Eigen::Index dim_ = 0, noise_dim_ = 0, rows_ = 0, row_ = 0;
  std::map<int, int> ties_;  // offset in the core: dim, and from begin() on the first column here
  std::vector<int> columns_;

  Eigen::MatrixXd N_, X_;      // the rows with noise; X = (X_states X_core)
  Eigen::VectorXd r_, p_, D_;  // their residual; of the unit priors: residual and information
  Eigen::LLT<Eigen::MatrixXd> M_;
  Eigen::MatrixXd JX_;     // L^-1 X
  Eigen::VectorXd Jr_;     // L^-1 (r - N D^-1 p)
  Eigen::MatrixXd V_, W_;  // the rows without, then all of them
  Eigen::VectorXd reduced_g_;
  Eigen::LLT<Eigen::MatrixXd> llt_;
  Part g_;
  Eigen::MatrixXd information_;
  Eigen::VectorXd core_gradient_;
};

}  // namespace slammot
