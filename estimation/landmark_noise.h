// Whether movers accelerate, learnt from their innovations.
//
// Free landmarks are taken to keep their velocity, whatever acceleration is stated, until the
// latest innovations of the moving ones reject that; from then on all free landmarks have the noise
// stated. Static landmarks that are not yet known as such do not accelerate: with noise their
// velocity never converges to rest.
#pragma once

#include <vector>

namespace slammot {

class LandmarkNoise {
 public:
  // Without innovations (label_policy.h) the noise is as stated: the thesis.
  explicit LandmarkNoise(bool learns) : keeps_velocity_(learns) {}

  // What the root of a free landmark's noise is multiplied by.
  double scale() const { return keeps_velocity_ ? 0.0 : 1.0; }

  // The NIS of a moving landmark's measurement given all others of its frame.
  void note_innovation(double nis);

 private:
  bool keeps_velocity_;
  std::vector<double> latest_;
};

}  // namespace slammot
