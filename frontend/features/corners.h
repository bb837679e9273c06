// New corners where there are none yet: the strongest (Shi & Tomasi) of each cell of a grid.
// Whether a cell's strongest is any good, its patch tells (patch.h): contrast differs too much
// within an image for one threshold.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

namespace slammot {

struct CornerOptions {
  int count = 60;   // cells of the grid: about as many corners as there will be
  int border = 12;  // [px] nothing nearer to the edge of the image
};

// The side of a cell [px]; corners and tracks keep half of it between each other.
double cell_side(const cv::Size& image, const CornerOptions& options);

// At most one corner for each cell without a point in `taken`, at least half a cell away from all
// points; sub-pixel. The strongest first, so that any number of them is spread over the image.
std::vector<Eigen::Vector2d> find_corners(const cv::Mat& image,
                                          const std::vector<Eigen::Vector2d>& taken,
                                          const CornerOptions& options);

}  // namespace slammot
