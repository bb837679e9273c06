// What is particular to the EKF.
#pragma once

namespace slammot {

enum class FilterLinearisation { kStandard, kFej, kIdeal };  // linearisation.h

// What an update keeps of a direction that no measurement tells; gauge.h.
enum class Gauge { kNone, kHeading, kScale };

struct EkfOptions {
  FilterLinearisation linearisation = FilterLinearisation::kStandard;
  int iterations = 1;           // 1: EKF; more: iterated EKF (Gauss-Newton steps on the same prior)
  Gauge gauge = Gauge::kScale;  // with linearisation standard and one iteration
  int lag = 0;                  // poses of past frames kept in the state, without relinearisation
  bool second_order = true;     // noise of the product of depth and translation: second_order.h
};

}  // namespace slammot
