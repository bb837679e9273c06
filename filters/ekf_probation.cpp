// Landmarks that enter with pixels of past frames (probation.h), whose poses the state keeps.
#include <Eigen/Cholesky>

#include "filters/ekf_belief.h"
#include "models/points/observation.h"

namespace slammot {

void Ekf::add_seen(std::span<const Candidate> candidates, std::vector<int>& refused) {
  refused.clear();
  for (const Candidate& candidate : candidates) {
    if (!add_seen(candidate)) refused.push_back(candidate.track);
  }
}

// At its first pixel as any landmark, (2.7); then pixel by pixel, predicted in between by (2.5).
bool Ekf::add_seen(const Candidate& candidate) {
  const int track = candidate.track;
  for (const Sighting& seen : candidate.sightings) {
    const FilterPose& pose = clone_of(frames_ - seen.frames_before);
    if (&seen == &candidate.sightings.front()) {
      if (!add(seen.z, pose, seen.frame, candidate.prior, candidate.is_free())) {
        return false;
      }
    } else if (!use_past(pose, seen.z)) {
      state_.remove_landmarks({&track, 1});
      return false;
    }
    FilterLandmark& landmark = state_.landmarks.at(track);
    if (landmark.is_free()) predict_landmark(track, landmark, candidate.label, seen.to_next);
  }
  return true;
}

// The update of one measurement from a past pose. False when it fails the gate given the others,
// which for a filter are those before it.
bool Ekf::use_past(const FilterPose& pose, const Observation& z) {
  const FilterLandmark& landmark = state_.landmarks.at(z.track);
  const FilterAnchor& anchor = state_.anchors.at(landmark.anchor);
  const auto h = expect(setup_.camera, functions_.point, pose.position, pose.orientation,
                        anchor.position, landmark.y);
  if (!h) return false;
  const JointCovariance& P = state_.covariance;
  Eigen::MatrixXd of_pose(P.size(), 6);
  P.columns(pose.block, of_pose);
  Eigen::MatrixX2d P_Ht = of_pose * h->J_pose.transpose();
  P.add_columns(anchor.block, h->J_anchor, P_Ht);
  P.add_columns(landmark.y_block, h->J_y, P_Ht);
  Eigen::Matrix2d S = h->J_pose * P_Ht.middleRows<6>(pose.block.offset) +
                      h->J_anchor * P_Ht.middleRows<3>(anchor.block.offset) +
                      h->J_y * P_Ht.middleRows<3>(landmark.y_block.offset);
  S.diagonal().array() += z.variance(setup_.pixel_sigma);
  const Eigen::LLT<Eigen::Matrix2d> L(S);
  if (L.info() != Eigen::Success) {
    throw Diverged("the innovation covariance is not positive definite");
  }
  const Eigen::Vector2d whitened = L.matrixL().solve(z.pixel - h->pixel);
  if (!(whitened.squaredNorm() <= threshold_given_others_)) return false;
  Eigen::MatrixXd W = P_Ht;
  L.matrixU().solveInPlace<Eigen::OnTheRight>(W);
  const Eigen::VectorXd dx = W * whitened;
  state_.covariance.subtract_outer(W);
  linearisation_.correct(state_, dx);
  return true;
}

}  // namespace slammot
