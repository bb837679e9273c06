// GTSAM's BatchFixedLagSmoother on our measurements, in a static world.
#pragma once

#include <gtsam/nonlinear/BatchFixedLagSmoother.h>

#include <map>

#include "bench/peers/gtsam_factors.h"
#include "estimation/estimator.h"
#include "smoothers/window/window_options.h"

namespace slammot::bench {

class GtsamWindow {
 public:
  // As many cameras in an optimisation, and as exact a minimum, as ours.
  GtsamWindow(const Setup& setup, const WindowOptions& options);

  void process(const Frame& frame);
  CameraState camera() const { return camera_; }
  double iterations() const { return static_cast<double>(iterations_) / frames_; }  // of a frame

 private:
  // What one frame adds.
  struct News {
    gtsam::NonlinearFactorGraph factors;
    gtsam::Values values;
    gtsam::FixedLagSmoother::KeyTimestampMap times;
  };
  struct Point {
    Key key;
    int last_frame;
  };

  void add_camera(double timestamp, News& news);
  void add_point(const Observation& z, News& news);
  Point begin_point(const Observation& z, News& news);

  Setup setup_;
  gtsam::BatchFixedLagSmoother smoother_;
  std::map<int, Point> points_;  // by track
  CameraState camera_;
  double timestamp_ = 0.0;
  int frames_ = 0;
  std::size_t points_begun_ = 0, iterations_ = 0;
};

}  // namespace slammot::bench
