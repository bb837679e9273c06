// What an estimator believes of a frame, drawn (thesis figures 4.5 and 4.6): the image with where
// each landmark was expected and measured, the map from above and from the side, and a legend.
//
// An ellipse is two sigma of the innovation, as it was predicted before the frame's measurements
// were used: with what camera and landmark have in common. Its mark says the label that the
// landmark has after the frame; light blue was not measured.
#pragma once

#include <string>
#include <vector>

#include "frontend/rendering/map_view.h"
#include "frontend/rendering/picture_state.h"

namespace slammot {

// A camera's image (8 bits, grey or BGR) enlarged by a whole number, in colour, with the ellipses.
// Where nothing was predicted a measurement has the mark of its landmark alone.
cv::Mat draw_predictions(const cv::Mat& image, int enlarge, const PictureState& state,
                         std::size_t camera = 0);

// All of it; sides are even, as films want them. The images of the first cameras of the rig are of
// one size; one but the first may be empty, then its tracks are drawn on a plain ground.
cv::Mat draw_page(const std::vector<cv::Mat>& images, const PictureState& state,
                  const MapFrame& frame, const std::string& caption);

}  // namespace slammot
