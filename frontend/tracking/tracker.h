// Points followed from image to image.
//
// Frame to frame by pyramidal Lucas-Kanade with a forward-backward check, then against the patch of
// the first image (patch.h), which makes it sub-pixel and stops drift. Nothing is assumed about the
// world: there is no epipolar test, because what moves has an epipolar geometry of its own. What
// has changed its looks, left the image or met another track is given up, and new corners take its
// place.
//
// The result does not depend on the number of threads: each point is computed by itself.
#pragma once

#include <optional>
#include <vector>

#include "frontend/features/corners.h"
#include "frontend/features/patch.h"
#include "models/measurement.h"

namespace slammot {

struct TrackerOptions {
  CornerOptions corners;
  int window = 21;                 // of Lucas-Kanade [px]
  int levels = 4;                  // of the pyramid, above the image
  double forward_backward = 1.0;   // [px] a track that does not come back to within this ends
  double least_correlation = 0.9;  // with the first patch, else the track ends
  double most_correction = 3.0;    // [px] between the two stages; further is another corner
};

class Tracker {
 public:
  explicit Tracker(const TrackerOptions& options) : options_(options) {}

  // Makes points of one's own choice tracks of the first image, before the corners found in it;
  // where a point has no patch its number is not used. Call before the first process().
  void seed(std::vector<Eigen::Vector2d> points) { seeds_ = std::move(points); }

  // The points in the next image (8-bit grey, all of one size), by increasing track, with the
  // sigmas of their alignment [px] as `relative_sigma`, for state_noise() (noise.h). Track numbers
  // are never used twice; seeds have 0, 1, ... in their order.
  std::vector<Observation> process(const cv::Mat& image);

  // The points that process() returned last, in their order, in another image of that moment:
  // looked for from `guesses`. Nothing where one is not found.
  std::vector<std::optional<Patch::Fit>> find_in(const cv::Mat& image,
                                                 const std::vector<Eigen::Vector2d>& guesses) const;

 private:
  struct Track {
    int number;
    Patch patch;
    Warp warp;
    Eigen::Vector2d step;  // from the image before [px]; where to look first in the next one
    double sigma;          // of the warp's t [px]
  };

  std::vector<std::optional<Patch::Fit>> find(const std::vector<cv::Mat>& from,
                                              const std::vector<cv::Mat>& pyramid,
                                              const cv::Mat& smooth,
                                              const std::vector<Eigen::Vector2d>& guesses) const;
  void follow(const std::vector<cv::Mat>& pyramid, const cv::Mat& smooth);
  void drop_crowded(const cv::Size& size);
  void replenish(const cv::Mat& image, const cv::Mat& smooth);
  void begin(const cv::Mat& smooth, int number, const Eigen::Vector2d& pixel);

  TrackerOptions options_;
  std::vector<Eigen::Vector2d> seeds_;
  std::vector<Track> tracks_;     // by increasing number
  std::vector<cv::Mat> pyramid_;  // of the image before
  int next_number_ = 0;
};

}  // namespace slammot
