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

// The rows of a landmark in the update: two a pixel, or fewer (merge_views()).
struct LandmarkRows {
  int track = 0, pixels = 1;
  Eigen::Index first = 0, count = 2;
  double noise_nis = 0.0;  // of what its merged pixels say of their noise alone
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
  // Whether match i is of the landmark of the one before, by another camera.
  bool is_again(std::size_t i) const { return i > 0 && matches[i - 1].track == matches[i].track; }

  // Of the update: its rows; r is nu, after update() L^-1 nu, after nis_given_others() S^-1 nu.
  std::vector<LandmarkRows> landmarks;
  GrowingMatrix r, S;

  GrowingMatrix columns, J_pose, L_inverse, merged, dx, P_d;  // working memory
  std::vector<StateBlock> places;                             // anchors
  std::vector<Eigen::Index> place_of;                         // of each match
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
// Afterwards S holds its factor L, r L^-1 r and P_Ht W = P H' L^-T. Throws Diverged when S is not
// positive definite or the correction not finite.
void update(JointState& state, Devices& devices, const Rig& rig, double pixel_sigma, int iterations,
            Innovation& innovation);

// leave_one_out.cpp. After update(), and once: the NIS of each landmark's measurements given those
// of all the others, its leave-one-out innovation. With a = S^-1 nu and B = S^-1,
// a_i' B_ii^-1 a_i (docs/filter.md, Gate): what all of them share, above all the camera's motion,
// is not in it.
void nis_given_others(Innovation& innovation, std::vector<LeaveOneOut>& result);

// r := nu, and which rows are of one landmark: two a pixel.
void stack_rows(Innovation& innovation);

// merge_views.cpp. After stack_rows(): the pixels of a landmark in several cameras depend on three
// numbers, where it is seen from camera 0. An orthogonal change of their whitened rows leaves
// three, and others that are nothing but noise, independent of all else. The update is the same,
// with fewer rows.
void merge_views(double pixel_sigma, Innovation& innovation);

// update_considered.cpp. Measurements that correct only their own landmarks, free ones, one after
// the other, the rest of the state being considered but not corrected (Schmidt's gain, 1966).
void update_considered(JointState& state, Devices& devices, const Rig& rig,
                       std::span<const Observation> matches, double pixel_sigma,
                       Innovation& memory);

}  // namespace slammot
