// What is particular to the EKF.
#pragma once

namespace slammot {

enum class FilterLinearisation { kStandard, kFej, kIdeal };  // linearisation.h

struct EkfOptions {
  FilterLinearisation linearisation = FilterLinearisation::kStandard;
  int iterations = 1;        // 1: EKF; more: iterated EKF (Gauss-Newton steps on the same prior)
  int lag = 0;               // poses of past frames kept in the state, without relinearisation
  bool second_order = true;  // noise of the product of depth and translation: second_order.h
};

}  // namespace slammot
