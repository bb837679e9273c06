// Which landmarks are in the far part (far_part.h), with the option `deferred`.
#include <algorithm>

#include "filters/ekf_belief.h"

namespace slammot {

namespace {

constexpr int kRestAfter = 5;  // frames without a measurement

// Of a fold, in operations at the speed of an update's: products, and what is copied.
double fold_cost(double near, double adjoint, double far) {
  constexpr double kCopy = 500.0;  // an entry of the near part's matrices
  return far * far * adjoint + 2.0 * near * adjoint * far + kCopy * near * near;
}

}  // namespace

// What is measured comes back at once. What is not rests at the next fold, and a fold comes once
// the updates of a near part larger than it need be (twice what is kept: the adjoint is as large)
// have cost what the fold will. A map too small to pay is then never divided, and a fold stays rare
// where the far part is large.
void Ekf::divide(const Frame& frame) {
  rest();
  for (const Observation& z : frame.observations) {
    if (state_.landmarks.contains(z.track)) state_.bring_back(z.track);
  }
}

void Ekf::rest() {
  const double near = state_.covariance.size(), kept = find_resting();
  const double rows = 2.0 * static_cast<double>(measured_);
  overspent_ = std::max(0.0, overspent_ + rows * (near * near - 4.0 * kept * kept));
  const double far = state_.size() - kept;
  if (overspent_ <= fold_cost(near, state_.far.adjoint().dim, far)) return;
  state_.rest(tracks_);
  state_.far.check();
  overspent_ = 0.0;
}

// Into tracks_; returns the rows of the near part without them, and without an adjoint.
int Ekf::find_resting() {
  tracks_.clear();
  anchors_.clear();
  int rows = JointState::kCamera.dim + (state_.scene ? 1 : 0);
  for (const auto& [track, landmark] : state_.landmarks) {
    if (landmark.is_far()) continue;
    const bool rests = !landmark.is_free() && frames_ - landmark.last_used > kRestAfter &&
                       linearisation_.is_settled(track);
    if (rests) {
      tracks_.push_back(track);
    } else {
      rows += landmark.dim();
      anchors_.push_back(landmark.anchor);
    }
  }
  std::ranges::sort(anchors_);
  const auto repeated = std::ranges::unique(anchors_);
  return rows + 3 * static_cast<int>(repeated.begin() - anchors_.begin());
}

}  // namespace slammot
