// A landmark in the graph: its variables, and everything that was measured or is assumed of it.
//
// A static landmark is y (models/points/point.h). A free one is the base state x_0 = (y, w) at the
// oldest frame that concerns it, and from each frame to the next the landmark model with its noise
// as a variable of its own,
//
//   x_j = f(x_{j-1}) + G_j n_j,   n_j ~ N(0, I),   Q_j = G_j G_j'.
//
// That is one state per frame joined by factors of covariance Q, without stiff constraints: when
// depth and velocity of the base change, the whole chain follows exactly. Q may be singular.
#pragma once

#include "models/landmarks/landmark_models.h"
#include "smoothers/graph/residuals.h"
#include "smoothers/variables/variable.h"

namespace slammot {

using LandmarkId = int;  // its slot in the graph

using PixelMotion = BoundedMatrix<2, Eigen::Dynamic, 2, kMaxMotion>;

// One step of a chain.
struct ChainStep {
  double dt = 0.0;        // [s]
  bool is_moving = true;  // as it was believed then, LandmarkPrior::noise()
  LandmarkMatrix G;
  double unit = 0.0;  // of G's rows of w [1/m], or 0: in metres (chain_step.h)
  LandmarkVector noise;

  // At the last linearisation: the state after the step, and F = df/dx before it.
  LandmarkVector x;
  LandmarkMatrix F;
  LandmarkVector point;  // the state where Jacobians are taken, with fixed points
  LandmarkVector step;   // the correction of the noise last computed
};

// A measurement, with the residual and Jacobians of the last linearisation.
struct GraphPixel {
  VariableId position = 0, orientation = 0;
  int depth = 0;      // chain steps between the base and the frame
  double time = 0.0;  // of the frame [s]
  MeasuredPixel z;
  bool valid = true;  // false: behind the camera; all of it is zero
  PixelResidual at;
  PixelMotion J_w;  // of a constrained motion, at the same point as the others; else empty
};

// What was assumed of y at birth, until it is marginalised: rows of the residual.
struct BirthPrior {
  enum class Kind {
    kNone,
    kDepth,        // (rho - rho0) / sigma_rho
    kSharedDepth,  // (rho - m) / sigma(m), where m is the mean of the scene, a variable
    kKnown         // (a + G/rho - X) / sigma
  };
  Kind kind = Kind::kNone;
  double inverse_depth = 0.0;  // rho0 [1/m]
  DepthSpread spread;
  VariableId scene = -1;
  KnownLandmark known;

  Eigen::Vector3d r = Eigen::Vector3d::Zero();
  Eigen::Matrix3d J_anchor = Eigen::Matrix3d::Zero(), J_y = Eigen::Matrix3d::Zero();
  Eigen::Vector3d J_scene = Eigen::Vector3d::Zero();

  int rows() const { return kind == Kind::kNone ? 0 : kind == Kind::kKnown ? 3 : 1; }
};

// What was assumed of w at the base, until it is marginalised: rows of the residual. With `unit` >
// 0 in units of the landmark's distance (chain_step.h), else w / sigma.
struct MotionPrior {
  MotionVector sigmas;  // of w; empty: no rows
  double unit = 0.0;    // rho where they were stated [1/m]

  MotionVector r, J_w;  // J_w: a diagonal
  BoundedMatrix<Eigen::Dynamic, 3, kMaxMotion, 3> J_y;

  Eigen::Index rows() const { return sigmas.size(); }
};

// The motion of a landmark that is static: a variable that is constrained to zero until it is
// released. What leaves the graph goes into the prior with its columns.
struct ConstrainedMotion {
  VariableId w = 0;
  MotionPrior prior;
  double rest_time = 0.0;  // of y, and of w [s]
};

struct GraphLandmark {
  bool is_alive = true;
  bool is_considered = false;  // it corrects itself only; of a free one
  VariableId anchor = 0;       // camera position at its birth
  VariableId y = 0;            // at the base
  VariableId w = -1;           // at the base; -1: static
  MotionPrior w_prior;
  std::optional<ConstrainedMotion> constrained;  // only of a static one
  std::vector<ChainStep> chain;
  std::vector<GraphPixel> pixels;  // oldest first
  BirthPrior birth;

  bool is_free() const { return w >= 0; }
  int steps() const { return static_cast<int>(chain.size()); }
};

}  // namespace slammot
