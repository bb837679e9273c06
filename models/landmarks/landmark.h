// What a model of a possibly moving landmark must provide, and what such models have in common.
//
// The state of a free (unknown or moving) landmark is x = (y, w): y is its position as a
// parametrisation P has it (models/points/point.h), and the numbers w say how it moves, as many as
// the model wants. w = 0 means that it is at rest, and the first three of w are its velocity or a
// multiple of it. A model is a template over P in one file, with fixed sizes, and one entry of
// all_models.h; estimators use its row, whose sizes are known at run time and bounded, so that
// nothing is allocated.
#pragma once

#include <Eigen/Cholesky>
#include <concepts>

#include "models/camera_motion.h"
#include "models/measurement.h"
#include "models/points/point.h"

namespace slammot {

inline constexpr int kMaxMotion = 9;                 // numbers of w
inline constexpr int kMaxLandmark = 3 + kMaxMotion;  // of (y, w)

template <int Rows, int Cols, int MaxRows, int MaxCols>
using BoundedMatrix = Eigen::Matrix<double, Rows, Cols, Eigen::ColMajor, MaxRows, MaxCols>;
using LandmarkVector = BoundedMatrix<Eigen::Dynamic, 1, kMaxLandmark, 1>;
using LandmarkMatrix = BoundedMatrix<Eigen::Dynamic, Eigen::Dynamic, kMaxLandmark, kMaxLandmark>;
using MotionVector = BoundedMatrix<Eigen::Dynamic, 1, kMaxMotion, 1>;
using MotionMatrix = BoundedMatrix<Eigen::Dynamic, Eigen::Dynamic, kMaxMotion, kMaxMotion>;
using VelocityJacobian = BoundedMatrix<3, Eigen::Dynamic, 3, kMaxLandmark>;

// (y, w) in one.
inline LandmarkVector landmark_state(const Eigen::Vector3d& y, const MotionVector& w) {
  LandmarkVector x(3 + w.size());
  x << y, w;
  return x;
}

template <typename T>
using Vector6 = Eigen::Matrix<T, 6, 1>;
using Matrix36d = Eigen::Matrix<double, 3, 6>;

// Of a model's own sizes.
template <typename M>
inline constexpr int kLandmarkDim = 3 + M::kMotion;
template <typename M, typename T = double>
using StateOf = Eigen::Matrix<T, kLandmarkDim<M>, 1>;
template <typename M>
using JacobianOf = Eigen::Matrix<double, kLandmarkDim<M>, kLandmarkDim<M>>;
template <typename M>
using VelocityJacobianOf = Eigen::Matrix<double, 3, kLandmarkDim<M>>;

template <typename M>
concept LandmarkModel = requires(const StateOf<M>& x, const Eigen::Vector3d& v, double dt,
                                 const LandmarkPrior& prior) {
  requires PointParametrisation<typename M::Point>;
  { M::kName } -> std::convertible_to<std::string_view>;
  { M::kDescription } -> std::convertible_to<std::string_view>;
  { M::kMotion } -> std::convertible_to<int>;  // numbers of w, 3 to kMaxMotion
  // Whether all of w is in metres, and grows with the scale; else in units of the depth.
  { M::kMotionInMetres } -> std::convertible_to<bool>;
  // x after dt without noise, thesis (2.5), and its Jacobian.
  { M::predict(x, dt) } -> std::convertible_to<StateOf<M>>;
  { M::predict_jacobian(x, dt) } -> std::convertible_to<JacobianOf<M>>;
  // The noise of one step in metres: the root of the covariance of (position, velocity, ..) in W,
  // and d x / d(position, velocity, ..) at x, which carries it into the state.
  { M::metric_noise_root(prior, dt) } -> std::convertible_to<JacobianOf<M>>;
  { M::noise_jacobian(x) } -> std::convertible_to<JacobianOf<M>>;
  // Velocity in W [m/s] and its Jacobian; not finite where rho = 0 makes it so.
  { M::velocity(x) } -> std::convertible_to<Eigen::Vector3d>;
  { M::velocity_jacobian(x) } -> std::convertible_to<VelocityJacobianOf<M>>;
  // w of a landmark at y with the velocity v in W, which it keeps.
  { M::motion_of(v, v) } -> std::convertible_to<Eigen::Matrix<double, M::kMotion, 1>>;
  // |dw/dv| at rest, of the first three of w: turns a density of these into one of v.
  { M::density_scale(x) } -> std::convertible_to<double>;
  // The prior standard deviation of each number of w, thesis (2.6).
  { M::prior_sigmas(prior) } -> std::convertible_to<Eigen::Matrix<double, M::kMotion, 1>>;
}
&&M::kMotion >= 3 && M::kMotion <= kMaxMotion;

// dy / d(position in W), per metre, at y: moving the point by p moves the scaled ray G by rho p,
// and rho' = rho / |G + rho p|.
template <PointParametrisation P>
Eigen::Matrix3d noise_jacobian_static(const Eigen::Vector3d& y) {
  const double rho = P::inverse_depth(y);
  const Eigen::Vector3d G = P::direction(y);
  const Matrix34d J = P::of_jacobian(G, rho);
  return rho * J.template leftCols<3>() - rho * rho * J.col(3) * G.transpose();
}

// dy'/dx of a point that has moved: y' in the direction of g at the inverse depth rho, both of them
// functions of x.
template <PointParametrisation P, int N>
Eigen::Matrix<double, 3, N> moved_jacobian(const Eigen::Vector3d& g, double rho,
                                           const Eigen::Matrix<double, 3, N>& J_g_x,
                                           const Eigen::Matrix<double, 1, N>& J_rho_x) {
  const Matrix34d J = P::of_jacobian(g, rho);
  return J.template leftCols<3>() * J_g_x + J.col(3) * J_rho_x;
}

// The root of Wiener noise of acceleration sigma_a [m/s^2] per axis in (position, velocity), 6x6:
// what models of constant velocity have for metric_noise_root().
inline Matrix6d acceleration_noise_root(double sigma_a, double dt) {
  const Eigen::Matrix2d L = white_noise_pattern(dt).llt().matrixL();
  Matrix6d root = Matrix6d::Zero();
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j <= i; ++j) {
      root.block<3, 3>(3 * i, 3 * j).diagonal().setConstant(sigma_a * L(i, j));
    }
  }
  return root;
}

// G with Q = G G' for one step of a free landmark, at the predicted state. At rho = 0 the noise of
// a bearing vanishes, so that Q is singular there; neither the filter nor the smoother inverts it.
template <LandmarkModel M>
JacobianOf<M> landmark_noise_root(const StateOf<M>& predicted, const LandmarkPrior& prior,
                                  double dt) {
  return M::noise_jacobian(predicted) * M::metric_noise_root(prior, dt);
}

}  // namespace slammot
