// What gate, labels, births and reports read from the last factorisation.
#include "models/points/initialisation.h"
#include "smoothers/window/window_belief.h"

namespace slammot {

void Window::prepare(std::span<const int> tracks) const {
  ids_.clear();
  const VariableId newest = cameras_.newest().camera.position;
  for (const int track : tracks) {
    const LandmarkId id = landmarks_.at(track).id;
    const GraphLandmark& l = graph_[id];
    const bool is_new = l.birth.kind == BirthPrior::Kind::kKnown && l.anchor == newest &&
                        l.pixels.empty();  // innovation_of_new()
    if (!is_new) ids_.push_back(id);
  }
  optimiser_.equations().prepare(graph_, ids_);
}

// Joint covariance of the camera, the anchor and the newest state. Since the factorisation the
// landmark may have become free, and its chain grown.
JointMatrix Window::joint(const WindowLandmark& landmark) const {
  const GraphLandmark& l = graph_[landmark.id];
  JointMatrix P = optimiser_.equations().joint(landmark.id);
  if (!l.is_free()) return P;
  constexpr int kX = kCameraDim + 3;
  const Eigen::Index before = P.rows(), dim = functions_.dim();
  if (before < kX + dim) {
    P.conservativeResizeLike(JointMatrix::Zero(kX + dim, kX + dim));
    P.diagonal().tail(dim - 3) = l.w_sigmas.cwiseAbs2();
  }
  for (int i = optimiser_.equations().steps(landmark.id); i < l.steps(); ++i) {
    const ChainStep& step = l.chain[static_cast<std::size_t>(i)];
    P.bottomRows(dim) = (step.F * P.bottomRows(dim)).eval();
    P.rightCols(dim) = (P.rightCols(dim) * step.F.transpose()).eval();
    P.bottomRightCorner(dim, dim) += step.G * step.G.transpose();
  }
  return P;
}

void Window::innovations(std::span<const Observation> measured,
                         std::vector<PixelInnovation>& result) {
  result.clear();
  measured_.clear();
  for (const Observation& z : measured) measured_.push_back(z.track);
  prepare(measured_);
  for (const Observation& z : measured) {
    if (const auto found = innovation(z)) result.push_back(*found);
  }
  if (!options_.retest) return;
  gated_.clear();
  for (const PixelInnovation& innovation : result) gated_.push_back(innovation.z);
}

std::optional<PixelInnovation> Window::innovation(const Observation& z) const {
  const WindowLandmark& landmark = landmarks_.at(z.track);
  const GraphLandmark& l = graph_[landmark.id];
  const CameraState x = cameras_.state(cameras_.newest());
  const auto h = expect(setup_.camera, functions_.point, x.position, x.orientation,
                        graph_.value(l.anchor), graph_.newest_state(l).head<3>());
  if (!h) return std::nullopt;
  PixelInnovation result{z, z.pixel - h->pixel, Eigen::Matrix2d::Zero()};
  const ObservedPixel at = truth_ ? truth_.observe(landmark).value_or(*h) : *h;
  if (l.anchor == cameras_.newest().camera.position) {
    result.HPHt = innovation_of_new(landmark, at);
    return result;
  }
  const JointMatrix P = joint(landmark);
  Eigen::Matrix<double, 2, kCameraDim + 6> H;
  H << at.J_pose * F_.topRows<6>(), at.J_anchor, at.J_y;
  const auto P_seen = P.topLeftCorner<kCameraDim + 6, kCameraDim + 6>();
  result.HPHt =
      H * P_seen * H.transpose() + at.J_pose * Q_.topLeftCorner<6, 6>() * at.J_pose.transpose();
  return result;
}

// A landmark known beforehand, at its first sight: y follows from its position and the camera.
Eigen::Matrix2d Window::innovation_of_new(const WindowLandmark& landmark,
                                          const ObservedPixel& h) const {
  const GraphLandmark& l = graph_[landmark.id];
  const Eigen::Matrix3d J_y_position =
      initialise_known(functions_.point, l.birth.known, graph_.variables[l.anchor].point())
          .J_y_position;
  const Matrix23d J_position = h.J_y * J_y_position;
  Eigen::Matrix<double, 2, kCameraDim> H = Eigen::Matrix<double, 2, kCameraDim>::Zero();
  H.leftCols<6>() = h.J_pose;
  H.leftCols<3>() += h.J_anchor - J_position;
  const Matrix12d P = F_ * optimiser_.equations().camera_covariance() * F_.transpose() + Q_;
  return H * P * H.transpose() +
         std::pow(l.birth.known.sigma, 2) * J_position * J_position.transpose();
}

// With r the residual that is left and I - J P J' its covariance, r' (I - J P J')^-1 r is the NIS
// given all other measurements, as the EKF has it from its innovations (mathematics.md).
void Window::leave_one_out(std::vector<LeaveOneOut>& result) {
  result.clear();
  prepare(used_);
  for (const int track : used_) {
    const WindowLandmark& landmark = landmarks_.at(track);
    const GraphPixel& pixel = graph_[landmark.id].pixels.back();
    if (landmark.is_free || !pixel.valid) continue;
    Eigen::Matrix<double, 2, kCameraDim + 6> J = Eigen::Matrix<double, 2, kCameraDim + 6>::Zero();
    J.leftCols<6>() = pixel.at.J_pose;
    J.rightCols<6>() << pixel.at.J_anchor, pixel.at.J_y;
    const auto P = optimiser_.equations().joint(landmark.id);
    const Eigen::Matrix2d own =
        Eigen::Matrix2d::Identity() -
        J * P.topLeftCorner<kCameraDim + 6, kCameraDim + 6>() * J.transpose();
    result.push_back({track, pixel.at.r.dot(own.inverse() * pixel.at.r)});
  }
}

void Window::inverse_depths(std::span<const int> tracks, std::vector<SeenDepth>& result) {
  result.clear();
  prepare(tracks);
  constexpr int kY = kCameraDim + 3;
  for (const int track : tracks) {
    const WindowLandmark& landmark = landmarks_.at(track);
    result.push_back(seen_depth(functions_.point, graph_.value(graph_[landmark.id].y),
                                optimiser_.equations().joint(landmark.id).block<3, 3>(kY, kY)));
  }
}

void Window::motions(std::span<const int> tracks, std::vector<MotionBelief>& result) {
  result.clear();
  prepare(tracks);
  for (const int track : tracks) {
    const WindowLandmark& landmark = landmarks_.at(track);
    const LandmarkVector x = graph_.newest_state(graph_[landmark.id]);
    MotionBelief& motion = result.emplace_back();
    motion.track = track;
    motion.w = x.tail(functions_.motion);
    motion.density_scale = functions_.density_scale(x);
    motion.covariance = joint(landmark).bottomRightCorner(functions_.motion, functions_.motion);
  }
}

std::vector<LandmarkBelief> Window::landmarks(std::span<const int> tracks) const {
  std::vector<LandmarkBelief> beliefs;
  prepare(tracks);
  for (const int track : tracks) {
    const WindowLandmark& landmark = landmarks_.at(track);
    const GraphLandmark& l = graph_[landmark.id];
    const LandmarkVector x = graph_.newest_state(l);
    const Eigen::Index motion = landmark.is_free ? functions_.motion : 0;
    LandmarkBelief& belief = beliefs.emplace_back();
    belief.anchor = graph_.value(l.anchor);
    belief.y = x.head<3>();
    belief.w = x.tail(x.size() - 3).head(motion);
    belief.covariance = joint(landmark).block(kCameraDim, kCameraDim, 6 + motion, 6 + motion);
  }
  return beliefs;
}

}  // namespace slammot
