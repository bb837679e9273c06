// What is particular to the EKF.
#pragma once

#include <string>

namespace slammot {

struct EkfOptions {
  std::string linearisation = "standard";  // | fej | ideal | invariant: linearisation.h
  int iterations = 1;    // 1: EKF; more: iterated EKF (Gauss-Newton steps on the same prior)
  bool delayed = false;  // a landmark's measurements move nothing but itself until it is classified
  bool deferred = false;  // the map out of view is updated when it is seen again: far_part.h
};

}  // namespace slammot
