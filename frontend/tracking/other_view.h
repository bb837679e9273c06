// Points of camera 0 found in the image that another camera of the rig took at that moment.
//
// As from image to image (tracker.h): Lucas-Kanade there and back, then the point's first patch. It
// begins where a point at infinity would be, moved as the track was in the image before. Unlike in
// time the geometry is known, for what moves too: from infinity towards the epipole a point has
// half a line to be on, and further from it than the lenses and the calibration err is another
// point.
#pragma once

#include <map>

#include "frontend/tracking/tracker.h"
#include "models/rig.h"

namespace slammot {

class OtherView {
 public:
  OtherView(const Camera& first, const MountedCamera& other, int number)
      : first_(first), other_(other), number_(number) {}

  // `z` as the tracker's process() has just returned them; `image` as it takes them. By track.
  std::vector<Observation> match(const Tracker& tracker, const cv::Mat& image,
                                 const std::vector<Observation>& z);

  // How far a pixel of this camera is from where a point may be that camera 0 has at `first`, in
  // pixels of an image without distortion. Nothing where a lens has no ray for it, or the point at
  // infinity is behind this camera.
  std::optional<double> off_line(const Eigen::Vector2d& first, const Eigen::Vector2d& pixel) const;

 private:
  // Of a point at infinity; where this camera has none, the same pixel.
  Eigen::Vector2d at_infinity(const Eigen::Vector2d& first) const;

  Camera first_;
  MountedCamera other_;
  int number_;
  std::map<int, Eigen::Vector2d> moved_;  // from infinity, where last seen, by track [px]
};

}  // namespace slammot
