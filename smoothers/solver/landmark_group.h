// The private states of one landmark in the normal equations: tied to cameras, anchors and each
// other only, they are eliminated before the core (cameras, anchors, everything in the prior).
//
// The noises n of its chain have a unit prior and many components (6 a step), but few rows measure
// them (2 a pixel). So they are eliminated in the space of those rows, r + N n + X x: with
// D = I (+ damping) and M = I + N D^-1 N' = L L' what is left of them is L^-1 (r - N D^-1 p) +
// L^-1 X x, p being the prior's residual; that is, the pixels with the covariance that the noise
// gives them. What remains, y and w until a prior touches them, goes by a Schur complement:
//   H = [V W; W' U],  S = U - W' V^-1 W.
#pragma once

#include <Eigen/Cholesky>
#include <algorithm>
#include <map>
#include <span>
#include <vector>

#include "smoothers/graph/graph.h"

namespace slammot {

// Where a variable stands in the normal equations.
struct Place {
  enum class Part { kCore, kStates, kNoises };
  Part part = Part::kCore;
  int group = -1;  // of the landmarks'; -1 in the core
  int offset = 0;  // in its part
  int dim = 0;
};
using Places = std::span<const Place* const>;  // of a factor's variables

class LandmarkGroup {
 public:
  // First the variables, then what every factor ties it to, then the factors.
  static bool has_noise(Places places);
  Place add_variable(int group, int dim, bool is_noise);
  void tie(Places places, Eigen::Index rows);
  void begin();
  void add(const Factor& factor, Places places);

  // Afterwards the core's lower triangle is to get information() at columns(), and its gradient
  // gradient(). Throws Diverged when the states are not determined.
  void eliminate(double damping);
  const std::vector<int>& columns() const { return columns_; }  // of the core, ascending
  const Eigen::MatrixXd& information() const { return information_; }
  const Eigen::VectorXd& gradient() const { return gradient_; }
  // The diagonal that rows with noise would have added to H in these columns.
  Eigen::VectorXd squares() const {
    return X_.rightCols(std::ssize(columns_)).colwise().squaredNorm();
  }

  // The steps of states and noises, given that of the core.
  struct Part {
    Eigen::VectorXd states, noises;
  };
  Part step(const Eigen::VectorXd& core) const;

  // J'r of states and noises.
  const Part& slope() const { return g_; }

  // With forms' columns E in this group, E' Sigma E = covariance + C' S^-1 C; `core` gets what C
  // has in the columns of the core.
  Eigen::MatrixXd covariance(const Eigen::MatrixXd& E_states, const Eigen::MatrixXd& E_noises,
                             Eigen::Ref<Eigen::MatrixXd> core) const;

  Eigen::Index states() const { return dim_; }
  Eigen::Index noises() const { return noise_dim_; }

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
  Eigen::VectorXd gradient_;
};

}  // namespace slammot
