// The private variables of one landmark in the normal equations: its state (y, w), until the prior
// holds it, and the noises of its chain. They are eliminated before the core (cameras, anchors,
// everything in the prior), and what they leave there is J' P J: the Jacobians of its pixels, whose
// weight P is the information that a pixel has once the landmark is unknown.
//
// The noises n have a unit prior and many components (six a step), but few rows measure them (two a
// pixel). With N the rows' Jacobian and D the information of the noises (the identity, unless
// damped), M = I + N D^-1 N' is the covariance of the pixels that the noise gives them. Entries of
// N D^-1 N' are J_i C_i Phi_ji' J_j', where C_i is the covariance of the state after step i by
// noise alone, and Phi_ji leads from there to step j. The states follow with their columns Y:
//
//   P = M^-1 - Z V^-1 Z',   Z = M^-1 Y,   V = Y' M^-1 Y + damping.
//
// V may be all but singular: few pixels, many states. So it is not formed. With M = L L', W the
// rows L^-1 Y and those of damping, W = Q R and Q_1 its first rows, P = M^-1 - B B', where
// B = L^-T Q_1: P is off by rounding of M^-1 only, however singular V is.
//
// P is small (two rows a pixel), and J has six columns a camera, so that J' P J is added camera by
// camera.
//
// A considered landmark leaves nothing there: its rows serve to find it once the core is known.
// What the prior says of it (MarginalPrior::ConsideredRows) are rows of its own too, after all
// others.
#pragma once

#include <vector>

#include "models/growing_matrix.h"
#include "smoothers/graph/graph.h"

namespace slammot {

class LandmarkBlock {
 public:
  // From the landmark's stored linearisation. `damping` multiplies the diagonal of H by
  // 1 + damping. Throws Diverged when the variables are not determined.
  void eliminate(const Graph& graph, const GraphLandmark& landmark, double damping);

  // What is left for the core: the lower triangle of H, and the gradient, at Variable::core.
  void add_to(Eigen::Ref<Eigen::MatrixXd> H, Eigen::Ref<Eigen::VectorXd> g) const;
  // The diagonal that these rows would have added to H, had nothing been eliminated.
  void add_squares(Eigen::Ref<Eigen::VectorXd> squares) const;

  // The step of the private variables, given that of the core.
  void step(const Eigen::VectorXd& core, Graph& graph, GraphLandmark& landmark) const;

  // The newest state of the landmark (y alone when static) is E' core + e, e ~ N(0, covariance):
  // adds E, core x dim(). In the tangent spaces of the linearisation.
  int dim() const { return states_; }
  bool has_no_private_state() const { return independent_; }  // nothing is eliminated
  int steps() const { return steps_; }                        // of the chain
  void newest(Eigen::Ref<Eigen::MatrixXd> E, LandmarkMatrix& covariance) const;

  // Of all pixels, two rows of A each: C := (P J)' A, core x columns, and own := A' P A.
  void weigh(const Eigen::Ref<const Eigen::MatrixXd>& A, Eigen::Ref<Eigen::MatrixXd> C,
             MotionMatrix& own) const;

 private:
  // Columns that all rows may touch: the anchor, the scene, and states that are in the core.
  struct Shared {
    int core = 0, column = 0, dim = 0;
    bool is_state = false;
    int state = 0;  // of a state: its first row in (y, w)
  };

  void lay_out(const Graph& graph, const GraphLandmark& landmark);
  void share_core(const Graph& graph, const GraphLandmark& landmark);
  void fill(const Graph& graph, const GraphLandmark& landmark);
  void fill_row(const GraphPixel& pixel, Eigen::Index row);
  void fill_birth(const GraphLandmark& landmark);
  void fill_prior_of_motion(const GraphLandmark& landmark);
  void fill_prior(const Graph& graph);
  void damp_noises(const GraphLandmark& landmark, double damping);
  void eliminate_states(double damping);
  void advance(const ChainStep& step, std::size_t index, Eigen::Index rows);

  int pixels_ = 0, rows_ = 0, states_ = 3, steps_ = 0;
  int first_private_ = 0;    // of the states; those before it are in the core
  bool independent_ = true;  // nothing private: P = I
  std::vector<Shared> shared_;
  int shared_cols_ = 0, scene_column_ = 0;
  MarginalPrior::ConsideredRows
      own_;                 // of a considered landmark: what the prior says of it is its own
  int own_column_ = 0;      // of the shared ones: the first of the prior's
  std::vector<int> poses_;  // of each pixel: the core row of its camera

  GrowingMatrix A_;  // rows x 6, of the pixel's camera
  GrowingMatrix X_;  // rows x states
  GrowingMatrix S_;  // rows x shared columns
  Eigen::VectorXd q_;
  GrowingMatrix P_;  // rows x rows: M, then its inverse, then P
  GrowingMatrix T_;  // states x rows: covariance of the newest state with each row, by noise alone
  LandmarkMatrix Phi_, C_;         // of the newest state: d/d(base), covariance by noise alone
  LandmarkVector drift_;           // of the newest state, by the noises' present values
  std::vector<LandmarkVector> D_;  // of each step, when damped

  GrowingMatrix W_;       // then Q
  GrowingMatrix B_, ZV_;  // rows x private states; ZV: Z V^-1
  LandmarkMatrix V_;      // V^-1
  LandmarkVector b_;      // Q' r
  LandmarkVector u_;      // of the private states: minus their step where the core stays
  Eigen::VectorXd r_;     // the residual of W's rows
  Eigen::VectorXd e_;     // of the rows: P times the residual
  mutable GrowingMatrix PS_;
  mutable GrowingMatrix gain_;  // states x rows
  mutable Eigen::VectorXd change_, weighted_;
};

}  // namespace slammot
