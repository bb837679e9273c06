// The rotation of an estimate between two images, beside the five-point estimate from the same
// tracks: what a front end finds, and a run's self-check judges.
#pragma once

namespace slammot {

struct RotationSpan {
  int first = 0, last = 0;  // Frame::index
  int five_point = 0;       // matches that the five-point estimate explains
  int estimate = 0;    // those that the estimate's rotation explains, with its best translation
  double angle = 0.0;  // between the two rotations [rad]
};

}  // namespace slammot
