// Which landmarks are in the passive map (passive_map.h), with the option `deferred`.
#include <algorithm>

#include "filters/ekf_belief.h"

namespace slammot {

namespace {

constexpr int kPassiveAfter = 5;  // frames without a measurement

// Of a synchronisation, in operations at the speed of an update's: products, and what is copied.
double synchronisation_cost(double active, double adjoint, double passive) {
  constexpr double kCopy = 500.0;  // an entry of the active part's matrices
  return passive * passive * adjoint + 2.0 * active * adjoint * passive + kCopy * active * active;
}

}  // namespace

// What is measured comes back at once. What is not is deactivated at the next synchronisation, and
// a synchronisation comes once the updates of an active part larger than it need be (twice what is
// kept: the adjoint is as large) have cost what the synchronisation will. A map too small to pay is
// then never divided, and a synchronisation stays rare where the passive map is large.
void Ekf::divide(const Frame& frame) {
  deactivate();
  for (const Observation& z : frame.observations) {
    if (state_.landmarks.contains(z.track)) state_.reactivate(z.track);
  }
}

void Ekf::deactivate() {
  const double active = state_.covariance.size(), kept = find_passive();
  const double rows = 2.0 * static_cast<double>(measured_);
  overspent_ = std::max(0.0, overspent_ + rows * (active * active - 4.0 * kept * kept));
  const double passive = state_.size() - kept;
  if (overspent_ <= synchronisation_cost(active, state_.passive.adjoint().dim, passive)) return;
  state_.deactivate(tracks_);
  state_.passive.check();
  overspent_ = 0.0;
}

// Into tracks_; returns the rows of the active part without them, and without an adjoint.
int Ekf::find_passive() {
  tracks_.clear();
  anchors_.clear();
  int rows = JointState::kCamera.dim + (state_.scene ? 1 : 0);
  for (const auto& [track, landmark] : state_.landmarks) {
    if (landmark.is_passive()) continue;
    const bool is_idle = !landmark.is_free() && frames_ - landmark.last_used > kPassiveAfter &&
                         linearisation_.is_settled(track);
    if (is_idle) {
      tracks_.push_back(track);
    } else {
      rows += landmark.dim() + landmark.held_block.dim;
      anchors_.push_back(landmark.anchor);
    }
  }
  std::ranges::sort(anchors_);
  const auto repeated = std::unique(anchors_.begin(), anchors_.end());
  return rows + 3 * static_cast<int>(repeated - anchors_.begin());
}

}  // namespace slammot
