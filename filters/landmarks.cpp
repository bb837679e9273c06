// The rows of landmarks in the EKF's state.
#include <Eigen/Cholesky>
#include <algorithm>

#include "filters/ekf.h"

namespace slammot {

// Thesis (2.5).
void Ekf::predict_landmark(int track, FilterLandmark& landmark, Label label, double dt) {
  const LandmarkVector at = devices_.linearisation.landmark(state_, track);
  const LandmarkMatrix F = functions_.predict_jacobian(at, dt);
  const LandmarkVector x = functions_.predict(landmark.x(), dt);
  landmark.y = x.head<3>();
  landmark.w = x.tail(functions_.motion);
  const LandmarkMatrix G = functions_.noise_root(functions_.predict(at, dt),
                                                 setup_.prior.noise(label == Label::kMoving), dt);
  state_.covariance.propagate({landmark.y_block, landmark.w_block}, F, G * G.transpose());
}

void Ekf::forget_motions(std::span<const int> tracks) {
  for (const int track : tracks) state_.forget_motion(track);
}

void Ekf::constrained_motions(std::span<const int> tracks, RememberedMotions& result) {
  const auto block = [&](int track) { return state_.landmarks.at(track).constrained_block; };
  const auto remembered = std::ranges::count_if(tracks, [&](int t) { return block(t).dim > 0; });
  result.reset(remembered, functions_.motion);
  for (const int track : tracks) {
    const FilterLandmark& landmark = state_.landmarks.at(track);
    if (!landmark.is_constrained()) continue;
    const std::size_t i = result.size();
    result.add(track, landmark.y);
    result.vector(i) = landmark.information_vector;
    for (std::size_t k = 0; k <= i; ++k) {
      const MotionMatrix J =
          -state_.covariance.block(landmark.constrained_block, block(result.track(k)));
      result.information(i, k) = J;
      result.information(k, i) = J.transpose();
    }
  }
}

// y is that of the time at which each came to rest, and moves on by F_yw w. All of them at the same
// estimate.
void Ekf::release(std::span<const int> tracks, const TrackRecords& records) {
  std::vector<JointState::Released> released;
  for (const int track : tracks) {
    const FilterLandmark& landmark = state_.landmarks.at(track);
    if (!landmark.is_constrained()) {
      free(track, records.at(track).prior);
      continue;
    }
    const Eigen::Vector3d y = devices_.linearisation.landmark(state_, track).head<3>();
    released.push_back({track, moved_from_rest(functions_, y, state_.time - landmark.rest_time)});
  }
  if (!released.empty()) devices_.correct(state_, state_.release_motions(released));
}

// w = 0 as an exact measurement: K = P[:,w] P_ww^-1.
void Ekf::condition_on_rest(std::span<const int> tracks) {
  const Eigen::Index n = functions_.motion, m = n * std::ssize(tracks);
  Eigen::MatrixXd P_w(state_.covariance.size(), m);
  Eigen::VectorXd w(m);
  std::vector<int> rows;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    const FilterLandmark& landmark = state_.landmarks.at(tracks[i]);
    const auto at = n * static_cast<Eigen::Index>(i);
    state_.covariance.columns(landmark.w_block, P_w.middleCols(at, n));
    w.segment(at, n) = landmark.w;
    for (int k = 0; k < n; ++k) rows.push_back(landmark.w_block.offset + k);
  }
  const Eigen::LLT<Eigen::MatrixXd> P_ww(P_w(rows, Eigen::all));
  if (P_ww.info() != Eigen::Success) throw Diverged("a velocity's covariance is not positive");
  Eigen::MatrixXd W = P_w;
  P_ww.matrixU().solveInPlace<Eigen::OnTheRight>(W);
  Eigen::VectorXd dx = -W * P_ww.matrixL().solve(w);
  state_.covariance.subtract_outer(W);
  if (remembers_) {
    const Eigen::MatrixXd J = P_ww.solve(Eigen::MatrixXd::Identity(m, m));
    const Eigen::VectorXd j = P_ww.solve(w);
    Eigen::MatrixXd sensitivity = P_w * J;
    sensitivity(rows, Eigen::all) = -J;
    dx(rows).setZero();
    for (std::size_t i = 0; i < tracks.size(); ++i) {
      const auto at = n * static_cast<Eigen::Index>(i);
      state_.landmarks.at(tracks[i]).rest_time = state_.time;
      state_.constrain_motion(tracks[i], sensitivity.middleCols(at, n), J.block(at, at, n, n),
                              j.segment(at, n));
    }
  }
  devices_.correct(state_, dx);
}

// The rows of a landmark's (y) or (y, w) when it is initialised.
StateBlock Ekf::append_new(const FirstSight& seen, const NewLandmark& at,
                           const LandmarkPrior& prior, int dim) {
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(dim, dim);
  const double pixel_variance = seen.z.variance(setup_.pixel_sigma);
  const double depth_variance = seen.prior.sigma * seen.prior.sigma;
  R.topLeftCorner<3, 3>() = pixel_variance * at.J_pixel * at.J_pixel.transpose() +
                            depth_variance * at.J_inverse_depth * at.J_inverse_depth.transpose();
  if (!seen.is_of_one_camera()) {
    Eigen::Matrix3d J_u;
    J_u << at.J_pixel, at.J_inverse_depth;
    R.topLeftCorner<3, 3>() = J_u * seen.covariance * J_u.transpose();
  }
  if (dim > 3) R.diagonal().tail(dim - 3) = functions_.prior_sigmas(prior).cwiseAbs2();
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(dim, 3);
  J.topRows<3>() = at.J_rotation;
  std::vector<JointCovariance::Dependence> on{{{kRotation, 3}, J}};
  if (state_.scene && !seen.has_own_depth) {
    Eigen::MatrixXd J_scene = Eigen::MatrixXd::Zero(dim, 1);
    J_scene.topRows<3>() = at.J_inverse_depth;
    on.push_back({state_.scene->block, J_scene});
  }
  return state_.covariance.append(on, R);
}

FilterAnchor& Ekf::anchor_here() {
  const auto found = state_.anchors.find(frame_);
  if (found != state_.anchors.end()) return found->second;
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  const StateBlock block =
      state_.covariance.append({{{kPosition, 3}, I}}, Eigen::MatrixXd::Zero(3, 3));
  return state_.anchors[frame_] = {state_.camera.position, block, 0};
}

void Ekf::insert(int track, const Eigen::Vector3d& y, StateBlock block) {
  ++state_.anchors.at(frame_).landmarks;
  FilterLandmark& landmark = state_.landmarks[track];
  landmark.anchor = frame_;
  landmark.last_used = frames_;
  landmark.y = y;
  landmark.y_block = {block.offset, 3};
  if (block.dim == 3) return;
  landmark.w.setZero(block.dim - 3);
  landmark.w_block = {block.offset + 3, block.dim - 3};
}

}  // namespace slammot
