// Whether the errors of a track last: what a covariance that takes each pixel's for new cannot say.
//
// Of a consistent estimator the innovations of one frame are independent of those of another
// (Mehra 1970). So n_k, those of a landmark in one camera given all others of the frame, scaled to
// unit covariance, have over L sightings of a track
//
//   |n_1 + .. + n_L|^2 / L,    2 on average,
//
// and less where pixels are better than stated or the gate cuts off their tail. What is too far to
// one side for as long (patches that drift, a match between two cameras that is off by the same
// tenth of a pixel, a lens that is not as stated) is hidden in the NIS of a frame where sigma is
// stated large enough, and not here: it adds up like L^2. What the map has already taken up of such
// an error is not seen, so that this is its least.
#pragma once

#include <Eigen/Core>
#include <map>
#include <utility>

#include "estimation/track_policy.h"

namespace slammot {

class LastingErrors {
 public:
  static constexpr int kSightings = 30;  // L

  // Sums that ended in a frame.
  struct Ended {
    int sums = 0;
    double nis = 0.0;  // of all of them
  };

  // `n`: given all others, of unit covariance; of the landmark that was `born` in that frame.
  void add(int track, int camera, int born, const Eigen::Vector2d& n);
  // Those since it was asked last; forgets tracks that are not there any more.
  Ended take(const TrackRecords& records);

 private:
  struct Sum {
    Eigen::Vector2d n = Eigen::Vector2d::Zero();
    int sightings = 0;
    int born = 0;
  };

  std::map<std::pair<int, int>, Sum> sums_;  // by track and camera
  Ended ended_;
};

}  // namespace slammot
