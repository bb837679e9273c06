#include "filters/update.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <array>
#include <cassert>

#include "filters/second_order.h"
#include "models/lapack.h"

namespace slammot {

namespace {

using Eigen::Index;

// h at the estimate with the Jacobians of the linearisation point; its own where there are none. At
// the truth a measurement counts whether or not the estimate sees its landmark: what is learnt must
// not depend on the estimate.
std::optional<ObservedPixel> linearised(const JointState& state, const Devices& devices,
                                        const MountedCamera& camera, int track) {
  const FilterLandmark& landmark = state.landmarks.at(track);
  const PointFunctions& point = devices.point();
  const Linearisation& linearisation = devices.linearisation;
  auto h = expect(camera, point, state.camera.position, state.camera.orientation,
                  state.anchors.at(landmark.anchor).position, landmark.y);
  if (linearisation.at_estimate() || (!h && !linearisation.at_truth())) return h;
  const CameraState at = linearisation.camera(state);
  const LandmarkVector x = linearisation.landmark(state, track);
  auto there = observe(camera, point, at.position, at.orientation,
                       linearisation.anchor(state, landmark.anchor), Eigen::Vector3d(x.head<3>()));
  if (!there) return h;
  if (h) there->pixel = h->pixel;
  return there;
}

void stack_J_pose(Innovation& innovation) {
  innovation.J_pose.resize(innovation.rows(), 6);
  for (Index i = 0; i < std::ssize(innovation.predicted); ++i) {
    (*innovation.J_pose).middleRows<2>(2 * i) =
        innovation.predicted[static_cast<std::size_t>(i)].J_pose;
  }
}

// The rows of a constrained w hold Phi' and -J, no covariance (covariance/constrained_motion.cpp).
// P H' has Phi' H' there; the pixel depends on w directly too, by J_y F_yw, since y is that of the
// time of rest. S has no part of w: it is held at 0.
void add_J_w(const JointState& state, const Devices& devices, int track, const Matrix23d& J_y,
             Eigen::Ref<Eigen::MatrixX2d> P_Ht) {
  const FilterLandmark& landmark = state.landmarks.at(track);
  if (!landmark.is_constrained()) return;
  const Eigen::Vector3d y = devices.linearisation.landmark(state, track).head<3>();
  const auto F_yw = moved_from_rest(devices.functions, y, state.time - landmark.rest_time);
  const StateBlock w = landmark.constrained_block;
  P_Ht.middleRows(w.offset, w.dim) += (J_y * F_yw).transpose();
}

// Of a landmark that several cameras measure.
bool is_of_many(const Innovation& innovation, std::size_t i) {
  return innovation.is_again(i) ||
         (i + 1 < innovation.matches.size() && innovation.is_again(i + 1));
}

// As JointCovariance::add_columns() for anchor and y, whose columns are read once for all cameras.
void add_gathered(const JointCovariance& P, std::array<StateBlock, 2> blocks,
                  Innovation& innovation, std::size_t i) {
  auto gathered = *innovation.columns;
  if (!innovation.is_again(i)) {
    P.columns(blocks[0], gathered.leftCols<3>());
    P.columns(blocks[1], gathered.rightCols<3>());
  }
  Eigen::Matrix<double, 2, 6> J;
  J << innovation.predicted[i].J_anchor, innovation.predicted[i].J_y;
  (*innovation.P_Ht).middleCols<2>(static_cast<Index>(2 * i)) +=
      gathered.lazyProduct(J.transpose());
}

// P H': a measurement touches 6 + 3 + 3 columns of P.
void fill_P_Ht(const JointState& state, const Devices& devices, Innovation& innovation) {
  const JointCovariance& P = state.covariance;
  innovation.P_Ht.resize(P.size(), innovation.rows());
  if (innovation.rows() == 0) return;
  stack_J_pose(innovation);
  innovation.columns.resize(P.size(), 6);
  P.columns(JointState::kPose, *innovation.columns);
  auto P_Ht = *innovation.P_Ht;
  P_Ht.noalias() = *innovation.columns * (*innovation.J_pose).transpose();
  for (std::size_t i = 0; i < innovation.matches.size(); ++i) {
    const int track = innovation.matches[i].track;
    const FilterLandmark& landmark = state.landmarks.at(track);
    const StateBlock anchor = state.anchors.at(landmark.anchor).block;
    const ObservedPixel& h = innovation.predicted[i];
    const auto columns = P_Ht.middleCols<2>(static_cast<Index>(2 * i));
    if (is_of_many(innovation, i)) {
      add_gathered(P, {anchor, landmark.y_block}, innovation, i);
    } else {
      P.add_columns(anchor, h.J_anchor, columns);
      P.add_columns(landmark.y_block, h.J_y, columns);
    }
    add_J_w(state, devices, track, h.J_y, columns);
  }
}

// The rows of H x of match i, for a matrix x with the state's rows.
template <typename X, typename Out>
void rows_of_H(const JointState& state, const Innovation& innovation, std::size_t i, const X& x,
               Out&& out) {
  const ObservedPixel& h = innovation.predicted[i];
  const FilterLandmark& landmark = state.landmarks.at(innovation.matches[i].track);
  const int anchor = state.anchors.at(landmark.anchor).block.offset;
  out = h.J_pose.lazyProduct(x.template topRows<6>()) +
        h.J_anchor.lazyProduct(x.template middleRows<3>(anchor)) +
        h.J_y.lazyProduct(x.template middleRows<3>(landmark.y_block.offset));
}

// W := W L^-T, by halves: OpenBLAS's triangular solve with AVX-512 kernels is much slower than its
// product.
void solve_on_the_right(const Eigen::Ref<const Eigen::MatrixXd>& L, Eigen::Ref<Eigen::MatrixXd> W) {
  const Index half = L.cols() / 2, rest = L.cols() - half;
  auto first = W.leftCols(half), second = W.rightCols(rest);
  L.topLeftCorner(half, half)
      .triangularView<Eigen::Lower>()
      .transpose()
      .solveInPlace<Eigen::OnTheRight>(first);
  second.noalias() -= first * L.bottomLeftCorner(rest, half).transpose();
  L.bottomRightCorner(rest, rest)
      .triangularView<Eigen::Lower>()
      .transpose()
      .solveInPlace<Eigen::OnTheRight>(second);
}

// P H' becomes W = P H' L^-T with S = L L', so that W W' = P H' S^-1 H P, and dx = W L^-1 nu.
void solve(Innovation& innovation) {
  auto S = *innovation.S;
  if (!cholesky_in_place(S)) throw Diverged("the innovation covariance is not positive definite");
  auto W = *innovation.P_Ht;
  solve_on_the_right(S, W);
  auto r = *innovation.r;
  S.triangularView<Eigen::Lower>().solveInPlace(r);
  innovation.dx.resize(W.rows(), 1);
  (*innovation.dx).noalias() = W * r;
  if (!(*innovation.dx).allFinite()) throw Diverged("the correction of the state is not finite");
}

// The innovation at an iterate x_i = x [+] dx, written as one of the prior's coordinates. An error
// e of the prior's rotation is J_r(dtheta) e at the iterate, so that H~ is H(x_i) with its rotation
// columns times J_r(dtheta), and nu~ = z - h(x_i) + H~ dx (docs/filter.md). Where the linearisation
// point is fixed, H~ = H.
void relinearise(const JointState& prior, const Devices& devices, const Rig& rig,
                 const Innovation& first, Innovation& innovation) {
  const Eigen::VectorXd dx = *innovation.dx;
  JointState iterate{prior.camera, prior.scene, prior.anchors, prior.landmarks, {}, {}, prior.time};
  iterate.move(dx);
  const Eigen::Matrix3d J_r = right_jacobian_so3(dx.segment<3>(kRotation));
  innovation.nu = first.nu;
  innovation.predicted = first.predicted;
  std::vector<bool> evaluated(first.matches.size(), false);
  for (std::size_t k = 0; k < first.matches.size(); ++k) {
    const FilterLandmark& landmark = iterate.landmarks.at(first.matches[k].track);
    const auto h = observe(rig[first.matches[k].camera], devices.point(), iterate.camera.position,
                           iterate.camera.orientation, iterate.anchors.at(landmark.anchor).position,
                           landmark.y);
    if (!h) continue;  // out of view there: as at the prior
    evaluated[k] = true;
    innovation.nu[k] = first.matches[k].pixel - h->pixel;
    if (!devices.linearisation.at_estimate()) continue;
    innovation.predicted[k] = *h;
    innovation.predicted[k].J_pose.rightCols<3>() *= J_r;
  }
  fill_P_Ht(prior, devices, innovation);
  for (std::size_t k = 0; k < evaluated.size(); ++k) {
    Eigen::Matrix<double, 2, 1> H_dx;
    rows_of_H(prior, innovation, k, dx, H_dx);
    if (evaluated[k]) innovation.nu[k] += H_dx;
  }
}

}  // namespace

void linearise(const JointState& state, const Devices& devices, const Rig& rig,
               std::span<const Observation> matches, Innovation& result) {
  result.matches.clear();
  result.predicted.clear();
  result.nu.clear();
  for (const Observation& match : matches) {
    const auto h = linearised(state, devices, rig[match.camera], match.track);
    if (!h) continue;
    result.matches.push_back(match);
    result.predicted.push_back(*h);
    result.nu.emplace_back(match.pixel - h->pixel);
  }
  fill_P_Ht(state, devices, result);
  fill_P_rho(state, devices, result);
}

std::optional<Prediction> predict_pixel(const JointState& state, const Devices& devices,
                                        const Rig& rig, int track) {
  const auto h = linearised(state, devices, rig[0], track);
  if (!h) return std::nullopt;
  const FilterLandmark& landmark = state.landmarks.at(track);
  const StateBlock blocks[] = {JointState::kPose, state.anchors.at(landmark.anchor).block,
                               landmark.y_block};
  Eigen::Matrix<double, 2, 12> H;
  H << h->J_pose, h->J_anchor, h->J_y;
  const Matrix12d P = state.marginal(blocks);
  Eigen::Matrix2d HPHt = H * P * H.transpose();
  if (devices.second_order != SecondOrder::kNone && !landmark.is_free()) {
    constexpr int kPlaces[] = {0, 1, 2, 6, 7, 8, 9, 10, 11};  // of r, a, y
    HPHt += second_order_noise(devices.point(), landmark.y, P(kPlaces, kPlaces), *h);
  }
  return Prediction{track, h->pixel, HPHt};
}

// The camera's part of all matches in one product, then each landmark's.
void fill_HPHt(const JointState& state, Innovation& innovation, GrowingMatrix& result) {
  result.resize(innovation.rows(), innovation.rows());
  auto HPHt = *result;
  const auto P_Ht = *innovation.P_Ht;
  stack_J_pose(innovation);  // some matches may have gone since P H' was filled
  HPHt.noalias() = *innovation.J_pose * P_Ht.topRows<6>();
  for (std::size_t i = 0; i < innovation.matches.size(); ++i) {
    const ObservedPixel& h = innovation.predicted[i];
    const FilterLandmark& landmark = state.landmarks.at(innovation.matches[i].track);
    const int anchor = state.anchors.at(landmark.anchor).block.offset;
    const auto row = static_cast<Index>(2 * i);
    for (Index column = 0; column < row + 2; ++column) {
      HPHt.block<2, 1>(row, column) +=
          h.J_anchor.lazyProduct(P_Ht.block<3, 1>(anchor, column)) +
          h.J_y.lazyProduct(P_Ht.block<3, 1>(landmark.y_block.offset, column));
    }
  }
  add_second_order(state, innovation, result);
}

void keep(std::span<const Observation> accepted, Innovation& innovation) {
  auto P_Ht = *innovation.P_Ht, P_rho = *innovation.P_rho;
  std::size_t kept = 0;
  for (std::size_t i = 0; kept < accepted.size(); ++i) {
    assert(i < innovation.matches.size());
    if (!is_same_view(innovation.matches[i], accepted[kept])) continue;
    if (kept < i) {
      innovation.matches[kept] = innovation.matches[i];
      innovation.predicted[kept] = innovation.predicted[i];
      innovation.nu[kept] = innovation.nu[i];
      innovation.products[kept] = innovation.products[i];
      if (P_rho.cols() > 0) P_rho.col(static_cast<Index>(kept)) = P_rho.col(static_cast<Index>(i));
      P_Ht.middleCols<2>(static_cast<Index>(2 * kept)) =
          P_Ht.middleCols<2>(static_cast<Index>(2 * i));
    }
    ++kept;
  }
  innovation.matches.resize(kept);
  innovation.predicted.resize(kept);
  innovation.nu.resize(kept);
  innovation.products.resize(kept);
  innovation.P_Ht.keep_columns(innovation.rows());
  if (P_rho.cols() > 0) innovation.P_rho.keep_columns(static_cast<Index>(kept));
}

void stack_rows(Innovation& innovation) {
  innovation.landmarks.clear();
  innovation.r.resize(innovation.rows(), 1);
  for (std::size_t i = 0; i < innovation.matches.size(); ++i) {
    const int track = innovation.matches[i].track;
    const auto row = static_cast<Index>(2 * i);
    (*innovation.r).middleRows<2>(row) = innovation.nu[i];
    if (innovation.is_again(i)) {
      ++innovation.landmarks.back().pixels;
      innovation.landmarks.back().count += 2;
    } else {
      innovation.landmarks.push_back({.track = track, .first = row});
    }
  }
}

void update(JointState& state, Devices& devices, const Rig& rig, double pixel_sigma, int iterations,
            Innovation& innovation) {
  if (innovation.rows() == 0) return;
  std::optional<Innovation> first;
  if (iterations > 1) first = innovation;
  for (int i = 0; i < iterations; ++i) {
    if (i > 0) relinearise(state, devices, rig, *first, innovation);
    fill_HPHt(state, innovation, innovation.S);
    add_pixel_noise(innovation.matches, pixel_sigma, innovation.S);
    stack_rows(innovation);
    // What is linearised again needs its rows as they were.
    if (iterations == 1 && rig.size() > 1) merge_views(pixel_sigma, innovation);
    solve(innovation);
  }
  state.covariance.subtract_outer(*innovation.P_Ht);
  devices.correct(state, (*innovation.dx).col(0));
}

}  // namespace slammot
