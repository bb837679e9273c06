// A film as a sequence of images. Its pictures are decoded twice: for their times, and to be
// tracked.
#pragma once

#include <functional>
#include <opencv2/core.hpp>

#include "datasets/sequence/sequence.h"

namespace slammot {

// Frames without observations and without names of images, from time 0 on: as the film has its
// times, or at a rate [Hz]. The camera is not stated: width and height are 0. Throws InputError for
// what is no film, or has no times.
Sequence read_video(const std::filesystem::path& file, std::optional<double> rate);

// Its pictures, 8-bit grey, by place, to be called in their order.
std::function<cv::Mat(std::size_t place)> video_images(const std::filesystem::path& file);

}  // namespace slammot
