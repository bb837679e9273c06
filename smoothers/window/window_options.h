// What is particular to the sliding window.
#pragma once

namespace slammot {

// Jacobians at the estimate | at first estimates, once a prior holds them.
enum class WindowLinearisation { kStandard, kFej };

// Who minimises: our Gauss-Newton | ceres::Solve, on the same factors, until it has converged or
// has taken 1000 iterations.
enum class WindowSolver { kOwn, kCeres };

struct WindowOptions {
  int frames = 20;      // camera states kept; older ones are marginalised
  int iterations = 20;  // Gauss-Newton steps a frame at most; 1 and one frame make it the EKF
  double linearisation_error = 0.02;  // [sigma] a step with less of it is the last one
  WindowLinearisation linearisation = WindowLinearisation::kStandard;
  WindowSolver solver = WindowSolver::kOwn;
};

}  // namespace slammot
