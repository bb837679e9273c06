#include "frontend/rendering/picture.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace slammot {
namespace {

const cv::Scalar missing(233, 180, 86), grey(150, 150, 150), black(0, 0, 0), pale(225, 225, 225);
constexpr int kShift = 4;  // bits of a fraction of a pixel, as OpenCV draws
constexpr double kTwoSigma = 2.0;
const double region_95 = std::sqrt(5.991464547107979);  // chi-square, two dimensions

// Okabe and Ito's, safe for all kinds of colour vision.
cv::Scalar colour_of(Label label) {
  const cv::Scalar colours[] = {{167, 121, 204}, {178, 114, 0}, {0, 94, 213}};  // BGR, as Label
  return colours[static_cast<int>(label)];
}

cv::Point fixed(const Eigen::Vector2d& p) {
  return {static_cast<int>(std::lround(p.x() * (1 << kShift))),
          static_cast<int>(std::lround(p.y() * (1 << kShift)))};
}

// Unknown is an open square, static a disc, moving a diamond: told apart without their colours.
void draw_marker(cv::Mat& picture, const Eigen::Vector2d& at, Label label,
                 const cv::Scalar& colour) {
  constexpr double kHalf = 3.5;  // [px]
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

// x' C^-1 x = scale^2 around `centre`; nothing where it is no ellipse or too large for the picture.
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

bool is_measured(const std::vector<Observation>& observations, int track) {
  const auto found = std::lower_bound(observations.begin(), observations.end(), track,
                                      [](const Observation& z, int t) { return z.track < t; });
  return found != observations.end() && found->track == track;
}

}  // namespace

cv::Mat draw_predictions(const cv::Mat& image, int enlarge, const PictureState& state) {
  cv::Mat picture;
  cv::resize(image, picture, {}, enlarge, enlarge, cv::INTER_NEAREST);
  if (picture.channels() == 1) cv::cvtColor(picture, picture, cv::COLOR_GRAY2BGR);
  const Eigen::Matrix3d R_camera_world =
      state.estimate.state.orientation.conjugate().toRotationMatrix();
  for (const LandmarkEstimate& landmark : state.landmarks) {
    const Eigen::Vector3d ray =
        R_camera_world * (landmark.position - state.estimate.state.position);
    const auto projection = state.camera.project(ray);
    if (!projection || !state.camera.in_image(projection->pixel)) continue;
    const Eigen::Matrix<double, 2, 3> J = projection->J_pixel_ray * R_camera_world;
    const Eigen::Matrix2d S = J * landmark.position_covariance * J.transpose() +
                              state.pixel_sigma * state.pixel_sigma * Eigen::Matrix2d::Identity();
    const bool found = is_measured(state.observations, landmark.track);
    const cv::Scalar colour = found ? colour_of(landmark.label) : missing;
    const Eigen::Vector2d centre =
        enlarge * (projection->pixel + Eigen::Vector2d(0.5, 0.5)) - Eigen::Vector2d(0.5, 0.5);
    draw_ellipse(picture, centre, enlarge * enlarge * S, kTwoSigma, colour);
    draw_marker(picture, centre, landmark.label, colour);
  }
  return picture;
}

MapPlane map_plane(const CameraState& first, const std::vector<Eigen::Vector3d>& path,
                   const std::vector<Eigen::Vector3d>& points) {
  MapPlane plane;
  plane.origin = first.position;
  const Eigen::Matrix3d R = first.orientation.toRotationMatrix();
  plane.axes << R.col(0).transpose(), R.col(2).transpose();
  const auto on_plane = [&](const Eigen::Vector3d& p) -> Eigen::Vector2d {
    return plane.axes * (p - plane.origin);
  };
  for (const Eigen::Vector3d& p : path) plane.shown.extend(on_plane(p));
  const Eigen::Vector2d middle = plane.shown.center();
  const double size = plane.shown.sizes().maxCoeff();
  std::vector<Eigen::Vector2d> on_map;
  for (const Eigen::Vector3d& p : points) on_map.push_back(on_plane(p));
  std::sort(on_map.begin(), on_map.end(), [&](const auto& a, const auto& b) {
    return (a - middle).squaredNorm() < (b - middle).squaredNorm();
  });
  // A quarter of the points is always shown: a camera may hardly have moved.
  for (size_t i = 0; i < on_map.size(); ++i) {
    const bool near = (on_map[i] - middle).lpNorm<Eigen::Infinity>() < size;
    if (near || 4 * i < on_map.size()) plane.shown.extend(on_map[i]);
  }
  const double margin = 0.05 * plane.shown.sizes().maxCoeff() + 0.1;
  plane.shown.extend(plane.shown.min() - Eigen::Vector2d::Constant(margin));
  plane.shown.extend(plane.shown.max() + Eigen::Vector2d::Constant(margin));
  return plane;
}

namespace {

// From the plane to the pixels of a map: forward is up.
struct MapView {
  const MapPlane& plane;
  double scale;  // [px/m]
  Eigen::Vector2d middle;

  MapView(const MapPlane& p, const cv::Size& size)
      : plane(p),
        scale(std::min(size.width / p.shown.sizes().x(), size.height / p.shown.sizes().y())),
        middle(size.width / 2.0, size.height / 2.0) {}

  Eigen::Vector2d at(const Eigen::Vector3d& p) const {
    const Eigen::Vector2d d = plane.axes * (p - plane.origin) - plane.shown.center();
    return middle + scale * Eigen::Vector2d(d.x(), -d.y());
  }
  Eigen::Matrix2d covariance(const Eigen::Matrix3d& P) const {
    Eigen::Matrix<double, 2, 3> J = scale * plane.axes;
    J.row(1) *= -1.0;
    return J * P * J.transpose();
  }
};

void draw_path(cv::Mat& map, const MapView& view, const std::vector<Eigen::Vector3d>& path,
               const cv::Scalar& colour) {
  for (size_t i = 1; i < path.size(); ++i) {
    cv::line(map, fixed(view.at(path[i - 1])), fixed(view.at(path[i])), colour, 1, cv::LINE_AA,
             kShift);
  }
}

// A length of 1, 2 or 5 times a power of ten, about a fifth of the map.
void draw_scale(cv::Mat& map, double pixels_per_metre) {
  const double wanted = map.cols / 5.0 / pixels_per_metre;
  const double power = std::pow(10.0, std::floor(std::log10(wanted)));
  const double length = (wanted >= 5.0 * power ? 5.0 : wanted >= 2.0 * power ? 2.0 : 1.0) * power;
  const cv::Point from(12, map.rows - 14);
  const cv::Point to(from.x + static_cast<int>(length * pixels_per_metre), from.y);
  cv::line(map, from, to, black, 2);
  cv::putText(map, fmt::format("{:g} m", length), {from.x, from.y - 6}, cv::FONT_HERSHEY_SIMPLEX,
              0.45, black, 1, cv::LINE_AA);
}

void draw_landmark(cv::Mat& map, const MapView& view, const LandmarkEstimate& landmark) {
  if (!landmark.position.allFinite()) return;
  const cv::Scalar colour = colour_of(landmark.label);
  const Eigen::Vector2d at = view.at(landmark.position);
  if (!(at.cwiseAbs().maxCoeff() < 1e4)) return;
  draw_ellipse(map, at, view.covariance(landmark.position_covariance), region_95, colour);
  draw_marker(map, at, landmark.label, colour);
  if (landmark.label != Label::kMoving || !landmark.velocity.allFinite()) return;
  const Eigen::Vector2d in_a_second = view.at(landmark.position + landmark.velocity);
  if (!(in_a_second.cwiseAbs().maxCoeff() < 1e4)) return;
  cv::line(map, fixed(at), fixed(in_a_second), colour, 1, cv::LINE_AA, kShift);
}

}  // namespace

cv::Mat draw_map(const MapPlane& plane, const cv::Size& size, const PictureState& state,
                 const std::vector<Eigen::Vector3d>& path,
                 const std::vector<Eigen::Vector3d>& truth) {
  cv::Mat map(size, CV_8UC3, cv::Scalar(255, 255, 255));
  const MapView view(plane, size);
  cv::rectangle(map, {0, 0}, {size.width - 1, size.height - 1}, pale);
  for (const LandmarkEstimate& landmark : state.landmarks) draw_landmark(map, view, landmark);
  draw_path(map, view, truth, grey);
  draw_path(map, view, path, black);
  const CameraState& camera = state.estimate.state;
  const double length = 14.0 / view.scale;  // [m] of the wedge that stands for the camera
  const Eigen::Vector2d tip = view.at(camera.position);
  for (const double side : {-0.5, 0.5}) {
    const Eigen::Vector3d corner =
        camera.position + camera.orientation * Eigen::Vector3d(side * length, 0.0, length);
    cv::line(map, fixed(tip), fixed(view.at(corner)), black, 2, cv::LINE_AA, kShift);
  }
  draw_ellipse(map, tip, view.covariance(state.estimate.covariance.topLeftCorner<3, 3>()),
               region_95, black);
  draw_scale(map, view.scale);
  return map;
}

namespace {

bool is_wide(const cv::Size& image) { return image.width > 2 * image.height; }

}  // namespace

cv::Size map_size(const cv::Size& image) {
  return is_wide(image) ? cv::Size(image.width, 480) : cv::Size(image.height, image.height);
}

cv::Mat picture_page(const cv::Mat& image, const cv::Mat& map, const std::string& caption) {
  cv::Mat page;
  if (is_wide(image.size())) {
    cv::vconcat(image, map, page);
  } else {
    cv::hconcat(image, map, page);
  }
  cv::copyMakeBorder(page, page, 0, 24 + page.rows % 2, 0, page.cols % 2, cv::BORDER_CONSTANT,
                     cv::Scalar(255, 255, 255));
  cv::putText(page, caption, {8, page.rows - 7}, cv::FONT_HERSHEY_SIMPLEX, 0.5, black, 1,
              cv::LINE_AA);
  return page;
}

}  // namespace slammot
