#include "frontend/tracking/tracker.h"

#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace slammot {
namespace {

cv::Point2f point_of(const Eigen::Vector2d& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y())};
}

Eigen::Vector2d vector_of(const cv::Point2f& p) { return {p.x, p.y}; }

// Takes off the sensor's noise and what bilinear sampling makes of the finest detail.
cv::Mat smoothed(const cv::Mat& image) {
  cv::Mat smooth;
  cv::GaussianBlur(image, smooth, {5, 5}, 0.8);
  return smooth;
}

}  // namespace

std::vector<Observation> Tracker::process(const cv::Mat& image) {
  const cv::Mat smooth = smoothed(image);
  std::vector<cv::Mat> pyramid;
  cv::buildOpticalFlowPyramid(image, pyramid, {options_.window, options_.window}, options_.levels);
  const bool first = pyramid_.empty();
  if (!first) follow(pyramid, smooth);
  for (const Eigen::Vector2d& point : seeds_) begin(smooth, next_number_++, point);
  seeds_.clear();
  drop_crowded(image.size());
  replenish(image, smooth);
  pyramid_ = std::move(pyramid);
  std::vector<Observation> observations;
  for (const Track& track : tracks_)
    observations.push_back({track.number, track.warp.t, track.sigma});
  return observations;
}

void Tracker::begin(const cv::Mat& smooth, int number, const Eigen::Vector2d& pixel) {
  const auto patch = Patch::cut(smooth, pixel);
  if (!patch) return;
  tracks_.push_back(
      {number, *patch, {Eigen::Matrix2d::Identity(), pixel}, {0.0, 0.0}, patch->sigma()});
}

std::vector<std::optional<Patch::Fit>> Tracker::find_in(
    const cv::Mat& image, const std::vector<Eigen::Vector2d>& guesses) const {
  std::vector<cv::Mat> pyramid;
  cv::buildOpticalFlowPyramid(image, pyramid, {options_.window, options_.window}, options_.levels);
  return find(pyramid_, pyramid, smoothed(image), guesses);
}

// From the image of the pyramid `from`, where they are, to that of `pyramid`.
std::vector<std::optional<Patch::Fit>> Tracker::find(
    const std::vector<cv::Mat>& from, const std::vector<cv::Mat>& pyramid, const cv::Mat& smooth,
    const std::vector<Eigen::Vector2d>& guesses) const {
  std::vector<std::optional<Patch::Fit>> fits(tracks_.size());
  if (tracks_.empty()) return fits;
  std::vector<cv::Point2f> before, after;
  for (const Track& track : tracks_) before.push_back(point_of(track.warp.t));
  for (const Eigen::Vector2d& guess : guesses) after.push_back(point_of(guess));
  std::vector<cv::Point2f> back = before;  // where they should come back to, a fair first guess
  std::vector<uchar> found, found_back;
  const cv::Size window(options_.window, options_.window);
  const cv::TermCriteria enough(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 30, 0.01);
  cv::calcOpticalFlowPyrLK(from, pyramid, before, after, found, cv::noArray(), window,
                           options_.levels, enough, cv::OPTFLOW_USE_INITIAL_FLOW);
  cv::calcOpticalFlowPyrLK(pyramid, from, after, back, found_back, cv::noArray(), window,
                           options_.levels, enough, cv::OPTFLOW_USE_INITIAL_FLOW);
  cv::parallel_for_({0, static_cast<int>(tracks_.size())}, [&](const cv::Range& range) {
    for (int k = range.start; k < range.end; ++k) {
      const auto i = static_cast<size_t>(k);
      const double missed = (vector_of(back[i]) - vector_of(before[i])).norm();
      if (found[i] == 0 || found_back[i] == 0 || !(missed < options_.forward_backward)) continue;
      const Eigen::Vector2d guess = vector_of(after[i]);
      const auto fit = tracks_[i].patch.align(smooth, {tracks_[i].warp.A, guess});
      if (!fit || fit->correlation < options_.least_correlation) continue;
      if ((fit->warp.t - guess).norm() > options_.most_correction) continue;
      fits[i] = fit;
    }
  });
  return fits;
}

void Tracker::follow(const std::vector<cv::Mat>& pyramid, const cv::Mat& smooth) {
  std::vector<Eigen::Vector2d> guesses;
  for (const Track& track : tracks_) guesses.emplace_back(track.warp.t + track.step);
  const auto fits = find(pyramid_, pyramid, smooth, guesses);
  for (size_t i = 0; i < tracks_.size(); ++i) {
    if (!fits[i]) continue;
    tracks_[i].step = fits[i]->warp.t - tracks_[i].warp.t;
    tracks_[i].warp = fits[i]->warp;
    tracks_[i].sigma = fits[i]->sigma;
  }
  size_t i = 0;
  std::erase_if(tracks_, [&](const Track&) { return !fits[i++]; });
}

// Of two tracks that have come close the older one stays.
void Tracker::drop_crowded(const cv::Size& size) {
  const double apart = cell_side(size, options_.corners) / 3.0;
  std::vector<Eigen::Vector2d> kept;
  std::erase_if(tracks_, [&](const Track& track) {
    for (const Eigen::Vector2d& other : kept) {
      if ((track.warp.t - other).squaredNorm() < apart * apart) return true;
    }
    kept.push_back(track.warp.t);
    return false;
  });
}

void Tracker::replenish(const cv::Mat& image, const cv::Mat& smooth) {
  std::vector<Eigen::Vector2d> taken;
  for (const Track& track : tracks_) taken.push_back(track.warp.t);
  for (const Eigen::Vector2d& corner : find_corners(image, taken, options_.corners)) {
    begin(smooth, next_number_, corner);
    if (!tracks_.empty() && tracks_.back().number == next_number_) ++next_number_;
  }
}

}  // namespace slammot
