// The measurement side of the EKF: innovations, and one update for all
// measurements of a frame. Knows nothing of how landmarks move: all models observe alike.
#pragma once

#include "estimation/belief.h"
#include "filters/devices.h"
#include "models/growing_matrix.h"
#include "models/points/observation.h"

namespace slammot {

// Of a measurement whose product of depth and translation N states (second_order.h), at the prior;
// zero where it states none.
struct ProductJacobians {
  Eigen::RowVector3d rho = Eigen::RowVector3d::Zero();  // of y
  Matrix23d pixel = Matrix23d::Zero();                  // of the ray (W)
};

// The measurements of a frame linearised at the state: innovation nu = z - h(x), H as its thin
// product P H' (n x 2m), and what N of second order is made of. Two rows (columns) a match, in the
// order of the matches. Kept from frame to frame for its memory.
struct Innovation {
  std::vector<Observation> matches;  // of landmarks in the state
  std::vector<ObservedPixel> predicted;
  std::vector<Eigen::Vector2d> nu;
  std::vector<ProductJacobians> products;
  GrowingMatrix P_Ht;
  GrowingMatrix P_rho;  // P J_rho', n x m; no columns where no N is stated at all
  bool has_common_second_order = false;

  Eigen::Index rows() const { return 2 * std::ssize(matches); }
  Eigen::Map<Eigen::VectorXd> stacked_nu() { return {nu.data()->data(), rows()}; }

  GrowingMatrix columns, J_pose, S, S_inverse, dx, P_d;  // working memory
  std::vector<StateBlock> places;                        // anchors
  std::vector<Eigen::Index> place_of;                    // of each match
};

// Linearises; matches whose landmark is not expected in view are left out (observation.h).
void linearise(const JointState& state, const Devices& devices, const Rig& rig,
               std::span<const Observation> matches, Innovation& result);

// Where a landmark is expected, with H P H' + N; nothing where it is not expected in view.
std::optional<Prediction> predict_pixel(const JointState& state, const Devices& devices,
                                        const Rig& rig, int track);

// Second order, as linearise() does: P J_rho' of each static landmark, what its inverse depth has
// in common with the state.
void fill_P_rho(const JointState& state, const Devices& devices, Innovation& innovation);

// result := result + N of all matches, its lower triangle.
void add_second_order(const JointState& state, Innovation& innovation, GrowingMatrix& result);

// H P H' + N of all matches, its lower triangle.
void fill_HPHt(const JointState& state, Innovation& innovation, GrowingMatrix& result);

// Only these of the matches, in their order, are left.
void keep(std::span<const Observation> accepted, Innovation& innovation);

// x and P after the measurements. `iterations` Gauss-Newton steps on the same prior (1: EKF).
// Afterwards S holds its factor L, nu L^-1 nu and P_Ht W = P H' L^-T. Throws Diverged when S is not
// positive definite or the correction not finite.
void update(JointState& state, Devices& devices, const Rig& rig, double pixel_sigma, int iterations,
            Innovation& innovation);

// After update(), and once: the NIS of each landmark's measurements given those of all the others,
// its leave-one-out innovation. With a = S^-1 nu and B = S^-1, a_i' B_ii^-1 a_i (docs/filter.md,
// Gate): what all of them share, above all the camera's motion, is not in it.
void nis_given_others(Innovation& innovation, std::vector<LeaveOneOut>& result);

// update_considered.cpp. Measurements that correct only their own landmarks, free ones, one after
// the other, the rest of the state being considered but not corrected (Schmidt's gain, 1966).
void update_considered(JointState& state, Devices& devices, const Rig& rig,
                       std::span<const Observation> matches, double pixel_sigma,
                       Innovation& memory);

}  // namespace slammot
