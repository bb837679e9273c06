// The marks of pictures: told apart by shape, and by colours that are safe for all kinds of colour
// vision. python/slammot/report/frame_figure.py has the same.
//
// By label: an open square is unknown, a disc static, a diamond moving. By measurement: an upright
// cross was accepted, a diagonal one rejected.
#pragma once

#include <opencv2/core.hpp>

#include "estimation/estimator.h"

namespace slammot::marks {

struct Colour {
  double blue, green, red;
  operator cv::Scalar() const { return {blue, green, red}; }
};
// Okabe and Ito's.
inline constexpr Colour kNotFound{233, 180, 86}, kRejected{0, 159, 230}, kGrey{150, 150, 150},
    kBlack{0, 0, 0}, kPale{225, 225, 225}, kWhite{255, 255, 255};
Colour colour_of(Label label);

inline constexpr double kTwoSigma = 2.0;
inline constexpr double kRegion95 = 2.4477468306808161;  // root of chi-square's, two dimensions

void draw_label(cv::Mat& picture, const Eigen::Vector2d& at, Label label, const cv::Scalar& colour);
// A measurement; kNot: of a track that is no landmark yet.
void draw_cross(cv::Mat& picture, const Eigen::Vector2d& at, Measured measured);
void draw_dot(cv::Mat& picture, const Eigen::Vector2d& at, const cv::Scalar& colour);
void draw_line(cv::Mat& picture, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
               const cv::Scalar& colour, int width = 1);
inline constexpr double kTextScale = 0.45;
void draw_text(cv::Mat& picture, const std::string& text, const Eigen::Vector2d& left_foot,
               double scale = kTextScale);

// x' C^-1 x = scale^2 around `centre`; nothing where it is no ellipse, or larger than a quarter of
// the picture: a depth that is not known yet would cover it.
void draw_ellipse(cv::Mat& picture, const Eigen::Vector2d& centre, const Eigen::Matrix2d& C,
                  double scale, const cv::Scalar& colour);

}  // namespace slammot::marks
