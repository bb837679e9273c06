// What an estimator believes after a frame, drawn (thesis figure 4.5): the image with the 2-sigma
// ellipse of each landmark where it is predicted, and the map from above with 95% regions.
//
// Blue disc: static, purple square: unknown, red diamond: moving, light blue: predicted in the
// image but not found in it. An ellipse is the landmark's own position covariance seen from the
// camera's estimate, plus the pixel noise. What camera and landmark have in common is not known to
// a run folder: it is too large where both are uncertain together, and too small where the camera
// is the less certain.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "estimation/estimator.h"

namespace slammot {

struct PictureState {
  Camera camera;
  double pixel_sigma = 1.0;  // [px]
  CameraEstimate estimate;
  std::vector<LandmarkEstimate> landmarks;  // all in the state
  std::vector<Observation> observations;    // by increasing track
};

// The image (8 bits, grey or BGR) enlarged by a whole number, in colour, with the ellipses.
cv::Mat draw_predictions(const cv::Mat& image, int enlarge, const PictureState& state);

// The plane of a map: spanned by the first camera's right and forward axes, so that it is seen from
// above wherever the world's axes point.
struct MapPlane {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  // W
  Eigen::Matrix<double, 2, 3> axes;                  // right, forward (W)
  Eigen::AlignedBox2d shown;                         // [m]
};
// That shows all of a path, the `points` (W) within its size around it, and the nearest quarter of
// them, with a margin.
MapPlane map_plane(const CameraState& first, const std::vector<Eigen::Vector3d>& path,
                   const std::vector<Eigen::Vector3d>& points);

// Regions larger than a quarter of the map are left out: they are depths not known yet, and would
// cover it. `path` and `truth` (W) up to this frame; the truth may be empty.
cv::Mat draw_map(const MapPlane& plane, const cv::Size& size, const PictureState& state,
                 const std::vector<Eigen::Vector3d>& path,
                 const std::vector<Eigen::Vector3d>& truth);

// The two beside each other, or below each other where the image is a wide one; sides are even, as
// films want them.
cv::Mat picture_page(const cv::Mat& image, const cv::Mat& map, const std::string& caption);
// The size of the map that fits beside (or below) an image.
cv::Size map_size(const cv::Size& image);

}  // namespace slammot
