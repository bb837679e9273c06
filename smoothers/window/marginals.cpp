#include "smoothers/window/marginals.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace slammot {

namespace {

using PixelJacobian = Eigen::Matrix<double, 2, kCameraDim + 6>;

// With respect to camera, anchor and y.
PixelJacobian jacobian_of(const GraphPixel& pixel) {
  PixelJacobian J = PixelJacobian::Zero();
  J.leftCols<6>() = pixel.at.J_pose;
  J.rightCols<6>() << pixel.at.J_anchor, pixel.at.J_y;
  return J;
}

}  // namespace

void Marginals::start() {
  F_.setIdentity();
  Q_.setZero();
}

void Marginals::predict() {
  const CameraMotionFactor& motion = graph_.motions.back();
  const Matrix12d J_inverse = motion.J_to.inverse();
  F_ = -J_inverse * motion.J_from;
  Q_ = J_inverse * J_inverse.transpose();
}

void Marginals::prepare(std::span<const int> tracks) {
  ids_.clear();
  for (const int track : tracks) {
    const WindowLandmark& landmark = landmarks_.at(track);
    if (!landmark.is_entering) ids_.push_back(landmark.id);  // else rows_of_new()
  }
  equations_.prepare(graph_, ids_);
}

// Joint covariance of the camera, the anchor and the newest state. Since the factorisation the
// landmark may have become free, and its chain grown.
JointMatrix Marginals::joint(const WindowLandmark& landmark) const {
  const GraphLandmark& l = graph_[landmark.id];
  JointMatrix P = equations_.joint(landmark.id);
  if (!l.is_free()) return P;
  constexpr int kX = kCameraDim + 3;
  const Eigen::Index before = P.rows(), dim = graph_.models().landmark->dim();
  if (before < kX + dim) {
    P.conservativeResizeLike(JointMatrix::Zero(kX + dim, kX + dim));
    P.diagonal().tail(dim - 3) = l.w_prior.J_w.cwiseAbs2().cwiseInverse();
  }
  for (int i = equations_.steps(landmark.id); i < l.steps(); ++i) {
    const ChainStep& step = l.chain[static_cast<std::size_t>(i)];
    P.bottomRows(dim) = (step.F * P.bottomRows(dim)).eval();
    P.rightCols(dim) = (P.rightCols(dim) * step.F.transpose()).eval();
    P.bottomRightCorner(dim, dim) += step.G * step.G.transpose();
  }
  return P;
}

CameraEstimate Marginals::camera() {
  const WindowFrame& newest = cameras_.newest();
  const Matrix12d P = equations_.camera_covariance();
  return {newest.timestamp, cameras_.state(newest), 0.5 * (P + P.transpose())};
}

// With r the residual that is left and I - J P J' its covariance, r' (I - J P J')^-1 r is the NIS
// given all other measurements, as the EKF has it from its innovations (docs/filter.md, Gate).
void Marginals::leave_one_out(std::span<const int> tracks, std::vector<LeaveOneOut>& result) {
  result.clear();
  prepare(tracks);
  for (const int track : tracks) {
    const WindowLandmark& landmark = landmarks_.at(track);
    const GraphPixel& pixel = graph_[landmark.id].pixels.back();
    if (landmark.is_free || !pixel.valid) continue;
    if (graph_.models().rig.size() > 1) {
      result.push_back(leave_rig_out(landmark));
      continue;
    }
    const PixelJacobian J = jacobian_of(pixel);
    const auto P = equations_.joint(landmark.id);
    const Eigen::Matrix2d own =
        Eigen::Matrix2d::Identity() -
        J * P.topLeftCorner<kCameraDim + 6, kCameraDim + 6>() * J.transpose();
    result.push_back({track, pixel.at.r.dot(own.inverse() * pixel.at.r)});
  }
}

// Of all its pixels in the newest frame together.
LeaveOneOut Marginals::leave_rig_out(const WindowLandmark& landmark) const {
  const std::vector<GraphPixel>& all = graph_[landmark.id].pixels;
  std::vector<const GraphPixel*> newest;
  for (auto pixel = all.rbegin(); pixel != all.rend(); ++pixel) {
    if (pixel->position != all.back().position) break;
    if (pixel->valid) newest.push_back(&*pixel);
  }
  const auto n = 2 * std::ssize(newest);
  Eigen::MatrixXd J(n, kCameraDim + 6);
  Eigen::VectorXd r(n);
  for (Eigen::Index i = 0; i < n; i += 2) {
    const GraphPixel& pixel = *newest[static_cast<std::size_t>(i / 2)];
    J.middleRows<2>(i) = jacobian_of(pixel);
    r.segment<2>(i) = pixel.at.r;
  }
  const Eigen::MatrixXd P =
      equations_.joint(landmark.id).topLeftCorner<kCameraDim + 6, kCameraDim + 6>();
  const Eigen::MatrixXd own = Eigen::MatrixXd::Identity(n, n) - J * P * J.transpose();
  return {landmark.track, r.dot(own.llt().solve(r)), static_cast<int>(n / 2)};
}

std::optional<PoseEstimate> Marginals::pose_before(int frames) const {
  const auto& all = cameras_.frames();
  if (frames >= std::ssize(all)) return std::nullopt;
  const WindowFrame& frame = all[all.size() - 1 - static_cast<std::size_t>(frames)];
  const CameraState x = cameras_.state(frame);
  const Matrix12d P = equations_.camera_covariance(graph_, frame.camera);
  return PoseEstimate{x.position, x.orientation, P.topLeftCorner<6, 6>()};
}

void Marginals::inverse_depths(std::span<const int> tracks, std::vector<SeenDepth>& result) {
  result.clear();
  prepare(tracks);
  constexpr int kY = kCameraDim + 3;
  for (const int track : tracks) {
    const WindowLandmark& landmark = landmarks_.at(track);
    result.push_back(seen_depth(graph_.models().point(), graph_.value(graph_[landmark.id].y),
                                equations_.joint(landmark.id).block<3, 3>(kY, kY)));
  }
}

void Marginals::motions(std::span<const int> tracks, std::vector<MotionBelief>& result) {
  result.clear();
  prepare(tracks);
  const LandmarkFunctions& functions = *graph_.models().landmark;
  for (const int track : tracks) {
    const WindowLandmark& landmark = landmarks_.at(track);
    const LandmarkVector x = graph_.newest_state(graph_[landmark.id]);
    result.push_back(
        motion_belief(track, functions, x, joint(landmark).bottomRightCorner(x.size(), x.size())));
  }
}

std::vector<LandmarkBelief> Marginals::landmarks(std::span<const int> tracks) {
  std::vector<LandmarkBelief> beliefs;
  prepare(tracks);
  for (const int track : tracks) {
    const WindowLandmark& landmark = landmarks_.at(track);
    const GraphLandmark& l = graph_[landmark.id];
    const LandmarkVector x = graph_.newest_state(l);
    const Eigen::Index motion = landmark.is_free ? graph_.models().landmark->motion : 0;
    LandmarkBelief& belief = beliefs.emplace_back();
    belief.anchor = graph_.value(l.anchor);
    belief.y = x.head<3>();
    belief.w = x.tail(x.size() - 3).head(motion);
    belief.covariance = joint(landmark).block(kCameraDim, kCameraDim, 6 + motion, 6 + motion);
  }
  return beliefs;
}

LandmarkVector Marginals::at_rest(const WindowLandmark& landmark) const {
  return landmark_state(graph_.newest_state(graph_[landmark.id]).head<3>(),
                        MotionVector::Zero(graph_.models().landmark->motion));
}

}  // namespace slammot
