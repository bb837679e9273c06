// By how much a frame has changed the size of the world, where nothing measures it.
//
// No update says so by itself. Pixels are blind along n = dx / d(log scale), and with H n = 0 a
// correction dx = P H' S^-1 nu has n' P^-1 dx = 0: in the metric of the belief none moves along n.
// So the lengths must be chosen that tell the scale, and for a path they are its own: distances
// from where it began, o, of the past cameras a that the state still holds as anchors of its
// landmarks. Over those before and after the frame,
//
//   t = log(|a - o| after / |a - o| before)    of root mean squares,
//
// which is t exactly where the frame makes the world e^t as large, in every family and
// parametrisation, and 0 where it turns the world about o. Depths are not asked: while those of new
// landmarks settle they change, and the path does not.
#pragma once

#include <span>
#include <vector>

#include "estimation/belief.h"

namespace slammot {

class ScaleChange {
 public:
  explicit ScaleChange(const Eigen::Vector3d& origin) : origin_(origin) {}

  // t of the frame that has left these landmarks, and the camera here. 0 where the past cameras in
  // the state are much nearer to o than this one: of the length that it has gone since they tell
  // nothing but their own rounding or noise. NaN where none of those before is left.
  double operator()(std::span<const LandmarkPoint> points, const TrackRecords& records,
                    const Eigen::Vector3d& camera);

 private:
  struct Anchor {
    int frame = 0;
    double squared_distance = 0.0;  // from o
  };

  void measure(std::span<const LandmarkPoint> points, const TrackRecords& records);

  Eigen::Vector3d origin_;
  std::vector<Anchor> before_, after_;  // by frame
};

}  // namespace slammot
