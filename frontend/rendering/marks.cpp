#include "frontend/rendering/marks.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace slammot::marks {
namespace {

constexpr int kShift = 4;      // bits of a fraction of a pixel, as OpenCV draws
constexpr double kHalf = 3.5;  // of a mark [px]

cv::Point fixed(const Eigen::Vector2d& p) {
  return {static_cast<int>(std::lround(p.x() * (1 << kShift))),
          static_cast<int>(std::lround(p.y() * (1 << kShift)))};
}

}  // namespace

Colour colour_of(Label label) {
  constexpr Colour kColours[] = {{167, 121, 204}, {178, 114, 0}, {0, 94, 213}};  // as Label
  return kColours[static_cast<int>(label)];
}

void draw_dot(cv::Mat& picture, const Eigen::Vector2d& at, const cv::Scalar& colour) {
  cv::circle(picture, fixed(at), 2 << kShift, colour, cv::FILLED, cv::LINE_AA, kShift);
}

void draw_label(cv::Mat& picture, const Eigen::Vector2d& at, Label label,
                const cv::Scalar& colour) {
  if (label == Label::kStatic) {
    const int radius = static_cast<int>(kHalf * (1 << kShift));
    cv::circle(picture, fixed(at), radius, colour, cv::FILLED, cv::LINE_AA, kShift);
    return;
  }
  std::vector<cv::Point> corners;
  for (const int quarter : {0, 1, 2, 3}) {
    const double turn = CV_PI / 2.0 * quarter + (label == Label::kMoving ? 0.0 : CV_PI / 4.0);
    const double reach = label == Label::kMoving ? 1.4 * kHalf : std::sqrt(2.0) * kHalf;
    corners.push_back(fixed(at + reach * Eigen::Vector2d(std::cos(turn), std::sin(turn))));
  }
  if (label == Label::kMoving) cv::fillConvexPoly(picture, corners, colour, cv::LINE_AA, kShift);
  cv::polylines(picture, corners, true, colour, 1, cv::LINE_AA, kShift);
}

void draw_line(cv::Mat& picture, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
               const cv::Scalar& colour, int width) {
  cv::line(picture, fixed(from), fixed(to), colour, width, cv::LINE_AA, kShift);
}

// Dark on light, so that it is seen on any image; it sticks out from under the mark of its
// landmark.
void draw_cross(cv::Mat& picture, const Eigen::Vector2d& at, Measured measured) {
  const double half = 2.0 * kHalf, part = half / std::sqrt(2.0);
  const bool is_rejected = measured == Measured::kRejected;
  const Eigen::Vector2d first =
      is_rejected ? Eigen::Vector2d(part, part) : Eigen::Vector2d(half, 0);
  const Eigen::Vector2d second(-first.y(), first.x());
  const Colour colour = is_rejected ? kRejected : measured == Measured::kNot ? kGrey : kBlack;
  for (const auto& [line, width] : {std::pair(kWhite, 3), std::pair(colour, 1)}) {
    draw_line(picture, at - first, at + first, line, width);
    draw_line(picture, at - second, at + second, line, width);
  }
}

void draw_text(cv::Mat& picture, const std::string& text, const Eigen::Vector2d& left_foot,
               double scale) {
  const cv::Point at(static_cast<int>(left_foot.x()), static_cast<int>(left_foot.y()));
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, scale, kBlack, 1, cv::LINE_AA);
}

void draw_ellipse(cv::Mat& picture, const Eigen::Vector2d& centre, const Eigen::Matrix2d& C,
                  double scale, const cv::Scalar& colour) {
  constexpr double kLargest = 0.25;  // half an axis, in parts of the picture
  if (!C.allFinite() || !centre.allFinite()) return;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(C);
  const Eigen::Vector2d half = scale * solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  if (!(half(1) < kLargest * picture.cols)) return;
  const Eigen::Vector2d axis = solver.eigenvectors().col(1);
  const double angle = std::atan2(axis.y(), axis.x()) * 180.0 / CV_PI;
  const Eigen::Vector2d sides(std::max(half(1), 1.5), std::max(half(0), 1.5));
  cv::ellipse(picture, fixed(centre), cv::Size(fixed(sides)), angle, 0.0, 360.0, colour, 1,
              cv::LINE_AA, kShift);
}

}  // namespace slammot::marks
