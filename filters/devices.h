// How the EKF linearises, what it states beside the thesis's noise, and how a correction changes
// its covariance: the three in which one EKF differs from another.
#pragma once

#include <optional>

#include "filters/gauge.h"
#include "filters/linearisation.h"

namespace slammot {

// Noise of second order (second_order.h): none | each measurement's own | also what they share.
enum class SecondOrder { kNone, kOwn, kCommon };

struct Devices {
  const LandmarkFunctions& functions;
  Linearisation linearisation;
  std::optional<GaugeError> gauge;
  SecondOrder second_order = SecondOrder::kNone;

  const PointFunctions& point() const { return functions.point; }

  // x := x [+] dx after an update or a collapse. P is re-expressed at the new estimate only where
  // Jacobians are taken there: elsewhere its coordinates are those of the fixed points.
  void correct(JointState& state, Eigen::Ref<const Eigen::VectorXd> dx) {
    if (gauge) {
      gauge->correct(state, dx);
    } else if (linearisation.at_estimate()) {
      state.correct(dx);
    } else {
      state.move(dx);
    }
  }
};

}  // namespace slammot
