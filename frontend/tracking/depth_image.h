// Depths of points from the image of a depth camera that sees as camera 0 does.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "models/measurement.h"

namespace slammot {

// Of each measurement with a depth: the median of the 3 x 3 values around it, of which at least
// five must be there. `image`: 16 bits, 0 where nothing is known; `unit` of its values [m].
//
// Its sigma is 0.01 m + 0.005 d^2 [m], and half of the patch's range, for at the edge of a thing
// the point is on either side. The error of a structured-light sensor grows as d^2: of Kinect's by
// 1.4e-3 d^2 on planes (Khoshelham & Elberink, Sensors 2012). More is stated for what that does not
// hold: colour and depth images that are not taken at once, and their calibration.
void measure_depths(const cv::Mat& image, double unit, std::vector<Observation>& z);

}  // namespace slammot
