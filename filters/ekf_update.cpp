#include "slammot/filters/ekf_update.h"

#include <Eigen/Cholesky>

namespace slammot {

namespace {

// h at the estimate with the Jacobians of the linearisation point; its own where there are none. At
// the truth a measurement counts whether or not the estimate sees its landmark: what is learnt must
// not depend on the estimate.
std::optional<ObservedPixel> linearised(const JointState& state, const Linearisation& linearisation,
                                        const Camera& camera, const FilterLandmark& landmark) {
  auto h = expect(camera, state.camera.position, state.camera.orientation,
                  state.anchors.at(landmark.anchor).position, landmark.y);
  if (linearisation.at_estimate() || (!h && !linearisation.at_truth())) return h;
  const CameraState at = linearisation.camera(state);
  const Vector6d x = linearisation.landmark(state, landmark.record.track);
  auto there = observe(camera, at.position, at.orientation,
                       linearisation.anchor(state, landmark.anchor), Eigen::Vector3d(x.head<3>()));
  if (!there) return h;
  if (h) there->pixel = h->pixel;
  return there;
}

}  // namespace

Innovation innovation(const JointState& state, const Linearisation& linearisation,
                      const Camera& camera, const std::vector<Match>& matches) {
  Innovation result;
  for (const Match& match : matches) {
    const FilterLandmark& landmark = state.landmarks.at(match.track);
    const auto h = linearised(state, linearisation, camera, landmark);
    if (!h) continue;
    result.matches.push_back(match);
    result.predicted.push_back(*h);
  }
  const int rows = result.rows();
  result.nu.resize(rows);
  result.P_Ht.resize(state.covariance.size(), rows);
  for (int i = 0; i < rows / 2; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const ObservedPixel& h = result.predicted[k];
    const FilterLandmark& landmark = state.landmarks.at(result.matches[k].track);
    const StateBlock anchor = state.anchors.at(landmark.anchor).block;
    const JointCovariance& P = state.covariance;
    result.nu.segment<2>(2 * i) = result.matches[k].pixel - h.pixel;
    auto columns = result.P_Ht.middleCols<2>(2 * i);
    columns.noalias() = P.cols(JointState::kPose) * h.J_pose.transpose();
    columns.noalias() += P.cols(anchor) * h.J_anchor.transpose();
    columns.noalias() += P.cols(landmark.y_block()) * h.J_y.transpose();
  }
  return result;
}

Eigen::MatrixXd apply_H(const JointState& state, const Innovation& innovation,
                        const Eigen::MatrixXd& x) {
  Eigen::MatrixXd Hx(innovation.rows(), x.cols());
  for (int i = 0; i < innovation.rows() / 2; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const ObservedPixel& h = innovation.predicted[k];
    const FilterLandmark& landmark = state.landmarks.at(innovation.matches[k].track);
    const StateBlock anchor = state.anchors.at(landmark.anchor).block;
    auto rows = Hx.middleRows<2>(2 * i);
    rows.noalias() = h.J_pose * x.topRows<6>();
    rows.noalias() += h.J_anchor * x.middleRows<3>(anchor.offset);
    rows.noalias() += h.J_y * x.middleRows<3>(landmark.block.offset);
  }
  return Hx;
}

namespace {

Eigen::MatrixXd innovation_covariance(const JointState& state, const Innovation& innovation,
                                      double pixel_variance) {
  Eigen::MatrixXd S = apply_H(state, innovation, innovation.P_Ht);
  S.diagonal().array() += pixel_variance;
  return S;
}

}  // namespace

Gate gate(const JointState& state, const Innovation& innovation, const PixelGate& test) {
  const Eigen::MatrixXd HPHt = apply_H(state, innovation, innovation.P_Ht);
  Gate result;
  std::vector<int> rows;
  for (int i = 0; i < innovation.rows() / 2; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double nis = test.nis(innovation.nu.segment<2>(2 * i), HPHt.block<2, 2>(2 * i, 2 * i));
    result.nis.push_back(nis);
    if (!test.passes(nis)) {
      result.rejected.push_back(innovation.matches[k].track);
      continue;
    }
    result.nis_sum += nis;
    result.accepted.matches.push_back(innovation.matches[k]);
    result.accepted.predicted.push_back(innovation.predicted[k]);
    rows.insert(rows.end(), {2 * i, 2 * i + 1});
  }
  result.accepted.nu = innovation.nu(rows);
  result.accepted.P_Ht = innovation.P_Ht(Eigen::all, rows);
  return result;
}

namespace {

// The innovation at an iterate x_i = x [+] dx, written as one of the prior's coordinates: with
// dr = J_r dtheta the Jacobian of the iterate, H~ = H dr and nu~ = z - h(x_i) + H~ dx. Where the
// linearisation point is fixed, H~ = H.
Innovation relinearise(const JointState& prior, const Linearisation& linearisation,
                       const Camera& camera, const Innovation& first, const Eigen::VectorXd& dx) {
  JointState iterate = prior;
  iterate.move(dx);
  const Eigen::Matrix3d J_r = right_jacobian_so3(dx.segment<3>(kRotation));
  Innovation result = first;
  std::vector<bool> evaluated(first.matches.size(), false);
  for (std::size_t k = 0; k < first.matches.size(); ++k) {
    const FilterLandmark& landmark = iterate.landmarks.at(first.matches[k].track);
    const auto h = observe(camera, iterate.camera.position, iterate.camera.orientation,
                           iterate.anchors.at(landmark.anchor).position, landmark.y);
    if (!h) continue;  // keeps the residual and linearisation it had
    evaluated[k] = true;
    result.nu.segment<2>(2 * static_cast<int>(k)) = first.matches[k].pixel - h->pixel;
    if (!linearisation.at_estimate()) continue;
    result.predicted[k] = *h;
    result.predicted[k].J_pose.rightCols<3>() *= J_r;
    const JointCovariance& P = prior.covariance;
    auto columns = result.P_Ht.middleCols<2>(2 * static_cast<int>(k));
    columns = P.cols(JointState::kPose) * result.predicted[k].J_pose.transpose() +
              P.cols(iterate.anchors.at(landmark.anchor).block) * h->J_anchor.transpose() +
              P.cols(landmark.y_block()) * h->J_y.transpose();
  }
  const Eigen::VectorXd H_dx = apply_H(prior, result, dx);
  for (std::size_t k = 0; k < evaluated.size(); ++k) {
    const auto row = 2 * static_cast<Eigen::Index>(k);
    if (evaluated[k]) result.nu.segment<2>(row) += H_dx.segment<2>(row);
  }
  return result;
}

}  // namespace

void update(JointState& state, const Linearisation& linearisation, const Camera& camera,
            const Innovation& first, double pixel_variance, int iterations) {
  if (first.rows() == 0) return;
  Innovation current = first;
  Eigen::VectorXd dx;
  Eigen::MatrixXd W;
  for (int i = 0; i < iterations; ++i) {
    if (i > 0) current = relinearise(state, linearisation, camera, first, dx);
    const Eigen::LLT<Eigen::MatrixXd> S(innovation_covariance(state, current, pixel_variance));
    if (S.info() != Eigen::Success) {
      throw Diverged("the innovation covariance is not positive definite");
    }
    W = current.P_Ht;
    S.matrixU().solveInPlace<Eigen::OnTheRight>(W);  // W W' = P H' S^-1 H P
    dx.noalias() = W * S.matrixL().solve(current.nu);
    if (!dx.allFinite()) throw Diverged("the correction of the state is not finite");
  }
  state.covariance.subtract_outer(W);
  linearisation.correct(state, dx);
}

void update_alone(JointState& state, const Linearisation& linearisation, const Camera& camera,
                  const Match& match, double pixel_variance) {
  const Innovation z = innovation(state, linearisation, camera, {match});
  if (z.rows() == 0) return;
  const StateBlock own = state.landmarks.at(match.track).block;
  const Eigen::Matrix2d S = innovation_covariance(state, z, pixel_variance);
  const Eigen::MatrixXd K = z.P_Ht.middleRows(own.offset, own.dim) * S.inverse();
  const Eigen::MatrixXd K_S_Kt = K * S * K.transpose();
  auto P = state.covariance.P();
  const Eigen::MatrixXd own_block = state.covariance.block(own, own) - K_S_Kt;
  state.covariance.rows(own).noalias() -= K * z.P_Ht.transpose();
  P.middleRows(own.offset, own.dim).middleCols(own.offset, own.dim) =
      0.5 * (own_block + own_block.transpose());
  P.middleCols(own.offset, own.dim) = P.middleRows(own.offset, own.dim).transpose();
  Eigen::VectorXd dx = Eigen::VectorXd::Zero(state.covariance.size());
  dx.segment(own.offset, own.dim) = K * z.nu;
  state.move(dx);
}

}  // namespace slammot
