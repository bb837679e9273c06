// The innovations of a frame from the last factorisation: what the core knows of them together, and
// what each has of its own.
#include "models/points/initialisation.h"
#include "smoothers/window/marginals.h"

namespace slammot {

void Marginals::innovations(std::span<const Observation> measured, FrameInnovation& result) {
  result.z.clear();
  result.nu.clear();
  expected_.clear();
  tracks_of(measured, tracks_);
  prepare(tracks_);
  for (const Observation& z : measured) {
    const auto pixel = expect_pixel(z);
    if (!pixel) continue;
    expected_.push_back(*pixel);
    result.z.push_back(z);
    result.nu.push_back(pixel->nu);
  }
  fill_HPHt(result.HPHt);
}

void Marginals::predict_pixels(std::span<const int> tracks, std::vector<Prediction>& result) {
  result.clear();
  prepare(tracks);
  for (const int track : tracks) {
    const auto pixel = expect_pixel({track, Eigen::Vector2d::Zero()});
    if (!pixel) continue;
    result.push_back({track, -pixel->nu, shared(landmarks_.at(track), pixel->h, pixel->h)});
  }
}

std::optional<Marginals::Expected> Marginals::expect_pixel(const Observation& z) const {
  const WindowLandmark& landmark = landmarks_.at(z.track);
  const GraphLandmark& l = graph_[landmark.id];
  const GraphModels& models = graph_.models();
  const CameraState x = cameras_.state(cameras_.newest());
  const auto h = expect(models.rig[z.camera], models.point(), x.position, x.orientation,
                        graph_.value(l.anchor), graph_.newest_state(l).head<3>());
  if (!h) return std::nullopt;
  Expected result{z.track, landmark.id, *h, z.pixel - h->pixel, {}};
  if (landmark.is_entering) {
    result.H = rows_of_new(l, *h) * F_;
    return result;
  }
  // Of the state as it was factorised: what has come since (noise, a motion) is its own.
  LandmarkMatrix J_state =
      LandmarkMatrix::Zero(2, l.is_free() ? graph_.models().landmark->dim() : 3);
  J_state.leftCols<3>() = h->J_y;
  for (int i = l.steps(); i-- > equations_.steps(landmark.id);) {
    J_state = (J_state * l.chain[static_cast<std::size_t>(i)].F).eval();
  }
  const int known = equations_.state_dim(graph_, landmark.id);
  result.H.setZero(2, kCameraDim + 3 + known);
  result.H.leftCols<kCameraDim + 3>() << h->J_pose * F_.topRows<6>(), h->J_anchor;
  const Eigen::Index both = std::min<Eigen::Index>(known, J_state.cols());
  result.H.middleCols(kCameraDim + 3, both) = J_state.leftCols(both);
  return result;
}

// What two pixels of one landmark in the newest frame have in common [px^2]; of one and the same,
// H P H'.
Eigen::Matrix2d Marginals::shared(const WindowLandmark& landmark, const ObservedPixel& a,
                                  const ObservedPixel& b) const {
  if (landmark.is_entering) return shared_of_new(graph_[landmark.id], a, b);
  const JointMatrix P = joint(landmark);
  Eigen::Matrix<double, 2, kCameraDim + 6> H_a, H_b;
  H_a << a.J_pose * F_.topRows<6>(), a.J_anchor, a.J_y;
  H_b << b.J_pose * F_.topRows<6>(), b.J_anchor, b.J_y;
  const auto P_seen = P.topLeftCorner<kCameraDim + 6, kCameraDim + 6>();
  return H_a * P_seen * H_b.transpose() +
         a.J_pose * Q_.topLeftCorner<6, 6>() * b.J_pose.transpose();
}

// A landmark known beforehand, at its first sight: y follows from its position and the camera.
Marginals::CameraRows Marginals::rows_of_new(const GraphLandmark& l, const ObservedPixel& h) const {
  const Matrix23d J_position = h.J_y * J_of_known(l);
  CameraRows H = CameraRows::Zero();
  H.leftCols<6>() = h.J_pose;
  H.leftCols<3>() += h.J_anchor - J_position;
  return H;
}

Eigen::Matrix2d Marginals::shared_of_new(const GraphLandmark& l, const ObservedPixel& a,
                                         const ObservedPixel& b) const {
  const Matrix12d P = F_ * equations_.camera_covariance() * F_.transpose() + Q_;
  const Eigen::Matrix3d J = J_of_known(l);
  const Matrix23d J_a = a.J_y * J, J_b = b.J_y * J;
  return rows_of_new(l, a) * P * rows_of_new(l, b).transpose() +
         std::pow(l.birth.known.sigma, 2) * J_a * J_b.transpose();
}

// dy / d(position in W).
Eigen::Matrix3d Marginals::J_of_known(const GraphLandmark& l) const {
  return initialise_known(graph_.models().point(), l.birth.known,
                          graph_.variables[l.anchor].point())
      .J_y_position;
}

// With E the columns of camera, anchor and state in the core, and L L' the core's information, two
// pixels share (L^-1 E H_i')' (L^-1 E H_j') and the motion noise of the newest camera. Its lower
// triangle.
void Marginals::fill_HPHt(GrowingMatrix& HPHt) {
  const Eigen::Index size = 2 * std::ssize(expected_);
  HPHt.resize(size, size);
  if (size == 0) return;
  core_columns_.resize(equations_.core_dim(), size);
  auto C = *core_columns_;
  for (Eigen::Index i = 0; i < std::ssize(expected_); ++i) {
    const Expected& pixel = expected_[static_cast<std::size_t>(i)];
    equations_.project(pixel.landmark, pixel.H, C.middleCols<2>(2 * i));
  }
  auto P = *HPHt;
  P.setZero();
  P.selfadjointView<Eigen::Lower>().rankUpdate(C.transpose());
  for (Eigen::Index i = 0; i < std::ssize(expected_); ++i) {
    const Expected& pixel = expected_[static_cast<std::size_t>(i)];
    const WindowLandmark& landmark = landmarks_.at(pixel.track);
    P.block<2, 2>(2 * i, 2 * i) = shared(landmark, pixel.h, pixel.h);
    const Eigen::Matrix<double, 2, 6> J_Q = pixel.h.J_pose * Q_.topLeftCorner<6, 6>();
    for (Eigen::Index j = 0; j < i; ++j) {
      const Expected& other = expected_[static_cast<std::size_t>(j)];
      if (other.track == pixel.track) {  // by another camera: also what is the landmark's own
        P.block<2, 2>(2 * i, 2 * j) = shared(landmark, pixel.h, other.h);
      } else {
        P.block<2, 2>(2 * i, 2 * j) += J_Q * other.h.J_pose.transpose();
      }
    }
  }
  add_inactive(P);
}

// What inactive landmarks share that the prior's variables do not say.
void Marginals::add_inactive(Eigen::Ref<Eigen::MatrixXd> HPHt) const {
  if (graph_.prior().inactive.empty()) return;
  std::vector<VariableId> ids;
  std::vector<std::pair<Eigen::Index, Matrix23d>> of;  // measurement, and its Jacobian
  for (Eigen::Index i = 0; i < std::ssize(expected_); ++i) {
    const Expected& pixel = expected_[static_cast<std::size_t>(i)];
    if (pixel.H.cols() == kCameraDim) continue;
    const GraphLandmark& l = graph_[pixel.landmark];
    for (const auto& [id, column] :
         {std::pair{l.anchor, kCameraDim}, std::pair{l.y, kCameraDim + 3}}) {
      if (graph_.variables[id].is_active) continue;
      ids.push_back(id);
      of.emplace_back(i, pixel.H.middleCols<3>(column));
    }
  }
  if (ids.size() < 2) return;
  std::vector<VariableId> distinct = ids;
  std::ranges::sort(distinct);
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  const Eigen::MatrixXd Sigma = graph_.prior().inactive.covariance(distinct);
  const auto place = [&](VariableId id) {
    return 3 * (std::ranges::lower_bound(distinct, id) - distinct.begin());
  };
  for (std::size_t a = 0; a < of.size(); ++a) {
    for (std::size_t b = 0; b < of.size(); ++b) {
      const Eigen::Index i = of[a].first, j = of[b].first;
      const auto track = [this](Eigen::Index k) {
        return expected_[static_cast<std::size_t>(k)].track;
      };
      if (j >= i || track(i) == track(j)) continue;  // shared() has it
      HPHt.block<2, 2>(2 * i, 2 * j) +=
          of[a].second * Sigma.block<3, 3>(place(ids[a]), place(ids[b])) * of[b].second.transpose();
    }
  }
}

}  // namespace slammot
