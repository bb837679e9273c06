// The camera's noise of the next step: as stated, or wider where its velocity goes on changing in
// one direction, or where measurements say that it is noisier.
//
// Curves. White noise changes the velocity by sqrt(n) sigma_a dt in n frames. A curve, whose
// accelerations have one sign, changes it by n times its acceleration, and a recording's root mean
// square, which users state, does not tell the two apart. A camera whose velocity is held too
// tightly moves the map instead, and landmarks at rest are then labelled moving.
//
// Let d = v(k|k) - v(k-1|k-1). If the model is right these are independent from frame to frame,
// with covariance P(k-1|k-1) - P(k|k) + (sigma_a dt)^2 I of v. So their mean with forgetting,
//   u <- (1 - a) u + a d,
//   V <- (1 - a)^2 V + a^2 (3 (sigma_a dt)^2 + max(0, tr(P(k-1|k-1) - P(k|k)))),
// has |u|^2 / V = 1 on average. P is that of the filter, whose noise may be wider than stated, so
// that it may grow; that is not counted. Where the ratio is more than 1, the variance of the next
// step is that many times the stated one; never less, for a camera that has moved evenly may turn.
// The same for omega, with sigma_alpha, on its own.
//
// Jolts. Static landmarks agree where most of them, and five at least, agree with the accepted
// measurements (gate.h). Let r be the NIS of the measurement of a static landmark on its own,
// median over those that agree: wrong labels and wrong matches hardly move it. It is 1.4 on average
// where pixels are most of S, and 2 where the camera's motion is, which all share. With
// f = max(1, m), m of the last frame,
//   m <- (1 - a) m + a f min(r, 13.8) / 2
// is the factor that the measurements ask for, for both velocities. Where they do not agree, r is
// the median over all static ones, and m stays. Beyond 13.8, the 99.9% quantile of chi-square(2),
// this very step may have been noisier: it is tried with r / 2 times the variance. If they agree
// then, it stays so, and m learns. If not, their matches are wrong, and it is taken back. No step
// is tried so in a frame in which a landmark has entered at the camera as it was before.
#pragma once

#include "estimation/estimator.h"

namespace slammot {

class AdaptiveCameraNoise {
 public:
  // Without `adapts` the noise stays as stated.
  AdaptiveCameraNoise(const MotionNoise& stated, bool adapts)
      : adapts_(adapts), stated_(stated), of_next_(stated) {}

  const MotionNoise& of_next() const { return of_next_; }
  bool adapts() const { return adapts_; }
  long widened() const { return widened_; }  // steps whose noise was more than stated

  // The factor by which a step's variance was more than predicted, from r; 1 where r does not say
  // so.
  static double jolt(double median_nis);

  // r of a frame whose static landmarks agree, with the step's noise as predicted.
  void note(double median_nis);

  // The camera before and after a frame, `dt` [s] apart, where it adapts.
  void learn(const CameraEstimate& before, const CameraEstimate& after, double dt);

 private:
  // Of the linear or of the angular velocity.
  struct Drift {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();  // u
    double variance = 0.0;                           // V

    // |u|^2 / V with the change of this frame, 1 at least. `at`: where the velocity is among the
    // camera's errors; `sigma`: what the stated noise lets it change by in this step.
    double add(const Eigen::Vector3d& change, const CameraEstimate& before,
               const CameraEstimate& after, int at, double sigma);
  };

  bool adapts_;
  MotionNoise stated_, of_next_;
  Drift linear_, angular_;
  long widened_ = 0;
  double factor_ = 1.0;  // f
  double asked_ = 1.0;   // m
};

}  // namespace slammot
