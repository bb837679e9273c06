// What is particular to the sliding window.
#pragma once

#include <string>

namespace slammot {

struct WindowOptions {
  int frames = 20;           // camera states kept; older ones are marginalised
  int iterations = 20;       // Gauss-Newton steps a frame at most; 1 and one frame make it the EKF
  double negligible = 1e-2;  // a step that promises to lower chi-square by less is the last one
  std::string linearisation = "standard";  // standard | fej: first estimates, once a prior
                                           // holds them | ideal: at the truth
  std::string loss = "none";               // none | huber, on the normalised measurement residual
};

}  // namespace slammot
