// What is particular to the EKF.
#pragma once

namespace slammot {

enum class FilterLinearisation { kStandard, kFej, kIdeal, kInvariant };  // linearisation.h

struct EkfOptions {
  FilterLinearisation linearisation = FilterLinearisation::kStandard;
  int iterations = 1;    // 1: EKF; more: iterated EKF (Gauss-Newton steps on the same prior)
  bool delayed = false;  // a landmark's measurements move nothing but itself until it is classified
  // So many static landmarks measured in a frame, and those of moving ones move nothing but their
  // own landmark, in one step; 0: they always count (thesis). Not with `ideal` and `invariant`.
  int static_enough = 12;
  bool equivariant_scale = true;  // an update keeps what is known of the scale: scale_error.h
  int lag = 0;                    // poses of past frames kept in the state, without relinearisation
  bool second_order = true;       // noise of the product of depth and translation: second_order.h
  bool deferred = false;  // the map out of view is updated when it is seen again: passive_map.h
};

}  // namespace slammot
