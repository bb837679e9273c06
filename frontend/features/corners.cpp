#include "frontend/features/corners.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace slammot {
namespace {

struct Grid {
  int columns, rows;
  double width, height;  // of a cell [px]

  Grid(const cv::Size& image, double side)
      : columns(std::max(1, static_cast<int>(std::lround(image.width / side)))),
        rows(std::max(1, static_cast<int>(std::lround(image.height / side)))),
        width(static_cast<double>(image.width) / columns),
        height(static_cast<double>(image.height) / rows) {}

  int cell_of(const Eigen::Vector2d& p) const {
    const int column = std::clamp(static_cast<int>(p.x() / width), 0, columns - 1);
    const int row = std::clamp(static_cast<int>(p.y() / height), 0, rows - 1);
    return row * columns + column;
  }
  cv::Rect rectangle(int cell) const {
    const int column = cell % columns, row = cell / columns;
    const cv::Point from(static_cast<int>(column * width), static_cast<int>(row * height));
    const cv::Point to(static_cast<int>((column + 1) * width),
                       static_cast<int>((row + 1) * height));
    return {from, to};
  }
};

struct Corner {
  cv::Point pixel;
  float strength;
};

// Half a pixel of error matters not: the patch cut there defines the point. But a corner found to a
// pixel only would sit beside the texture's centre, where it is told worst.
std::vector<Eigen::Vector2d> refined(const cv::Mat& image, const std::vector<Corner>& corners) {
  std::vector<cv::Point2f> points;
  for (const Corner& corner : corners) points.emplace_back(corner.pixel);
  if (!points.empty()) {
    const cv::TermCriteria enough(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 10, 0.03);
    cv::cornerSubPix(image, points, {4, 4}, {-1, -1}, enough);
  }
  std::vector<Eigen::Vector2d> result;
  for (const cv::Point2f& p : points) result.emplace_back(p.x, p.y);
  return result;
}

}  // namespace

double cell_side(const cv::Size& image, const CornerOptions& options) {
  return std::sqrt(static_cast<double>(image.area()) / options.count);
}

std::vector<Eigen::Vector2d> find_corners(const cv::Mat& image,
                                          const std::vector<Eigen::Vector2d>& taken,
                                          const CornerOptions& options) {
  const double side = cell_side(image.size(), options);
  const Grid grid(image.size(), side);
  std::vector<char> occupied(static_cast<size_t>(grid.columns) * static_cast<size_t>(grid.rows), 0);
  for (const Eigen::Vector2d& p : taken) occupied[static_cast<size_t>(grid.cell_of(p))] = 1;

  cv::Mat strength;
  cv::cornerMinEigenVal(image, strength, 5);
  cv::Mat allowed = cv::Mat::zeros(image.size(), CV_8U);
  const cv::Rect inside(options.border, options.border, image.cols - 2 * options.border,
                        image.rows - 2 * options.border);
  if (inside.width <= 0 || inside.height <= 0) return {};
  allowed(inside).setTo(255);
  const int apart = static_cast<int>(side / 2.0);
  const auto forbid = [&](const cv::Point& p) { cv::circle(allowed, p, apart, 0, cv::FILLED); };
  for (const Eigen::Vector2d& p : taken) {
    forbid({static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y()))});
  }

  std::vector<Corner> corners;
  for (size_t cell = 0; cell < occupied.size(); ++cell) {
    if (occupied[cell] != 0) continue;
    const cv::Rect where = grid.rectangle(static_cast<int>(cell));
    double value = 0.0;
    cv::Point at;
    cv::minMaxLoc(strength(where), nullptr, &value, nullptr, &at, allowed(where));
    if (at.x < 0 || !(value > 0.0)) continue;
    corners.push_back({at + where.tl(), static_cast<float>(value)});
    forbid(corners.back().pixel);
  }
  std::stable_sort(corners.begin(), corners.end(),
                   [](const Corner& a, const Corner& b) { return a.strength > b.strength; });
  return refined(image, corners);
}

}  // namespace slammot
