// The map of a frame, from above and from the side (thesis figure 4.6).
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "frontend/rendering/picture_state.h"

namespace slammot {

// The axes of all views: right, forward and up of the first camera, so that the map is seen from
// above wherever the world's axes point.
struct MapFrame {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  // W
  Eigen::Matrix3d axes;                              // rows: right, forward, up (W)
  Eigen::AlignedBox3d shown;                         // [m]

  Eigen::Vector3d at(const Eigen::Vector3d& p) const { return axes * (p - origin); }
};
// That shows all of a path, the `points` (W) within its size around it, and the nearest third of
// them, with a margin: what is near can be read however far the scene reaches.
MapFrame map_frame(const CameraState& first, const std::vector<Eigen::Vector3d>& path,
                   const std::vector<Eigen::Vector3d>& points);

// Which axis is horizontal, and which vertical.
struct MapView {
  const char* name;
  int across, upwards;
};
inline constexpr MapView kTopView{"from above", 0, 1}, kSideView{"from the side", 1, 2};

// With 95% regions, those of landmarks that were measured in this frame. Other static ones are grey
// dots, and what else was not measured is left out: nobody knows where it is now.
cv::Mat draw_map(const MapFrame& frame, const MapView& view, const cv::Size& size,
                 const PictureState& state);

}  // namespace slammot
