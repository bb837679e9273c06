#include "frontend/rendering/map_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "frontend/rendering/marks.h"

namespace slammot {

using namespace marks;

MapFrame map_frame(const CameraState& first, const std::vector<Eigen::Vector3d>& path,
                   const std::vector<Eigen::Vector3d>& points) {
  MapFrame frame;
  frame.origin = first.position;
  const Eigen::Matrix3d R = first.orientation.toRotationMatrix();
  frame.axes << R.col(0).transpose(), R.col(2).transpose(), -R.col(1).transpose();
  for (const Eigen::Vector3d& p : path) frame.shown.extend(frame.at(p));
  const Eigen::Vector3d middle = frame.shown.center();
  const double size = frame.shown.sizes().maxCoeff();
  std::vector<Eigen::Vector3d> on_map;
  for (const Eigen::Vector3d& p : points) on_map.push_back(frame.at(p));
  std::sort(on_map.begin(), on_map.end(), [&](const auto& a, const auto& b) {
    return (a - middle).squaredNorm() < (b - middle).squaredNorm();
  });
  // A third of the points is always shown: a camera may hardly have moved.
  for (size_t i = 0; i < on_map.size(); ++i) {
    const bool near = (on_map[i] - middle).lpNorm<Eigen::Infinity>() < size;
    if (near || 3 * i < on_map.size()) frame.shown.extend(on_map[i]);
  }
  const double margin = 0.05 * frame.shown.sizes().maxCoeff() + 0.1;
  frame.shown.extend(frame.shown.min() - Eigen::Vector3d::Constant(margin));
  frame.shown.extend(frame.shown.max() + Eigen::Vector3d::Constant(margin));
  return frame;
}

namespace {

// From the map to the pixels of a view, and the picture of it.
class Canvas {
 public:
  Canvas(const MapFrame& frame, const MapView& view, const cv::Size& size)
      : map(size, CV_8UC3, kWhite), frame_(frame), middle_(size.width / 2.0, size.height / 2.0) {
    axes_ << frame.axes.row(view.across), -frame.axes.row(view.upwards);
    const Eigen::Vector3d sizes = frame.shown.sizes();
    scale = std::min(size.width / sizes(view.across), size.height / sizes(view.upwards));
    const Eigen::Vector3d centre = frame.shown.center();
    centre_ = {centre(view.across), -centre(view.upwards)};
  }

  Eigen::Vector2d at(const Eigen::Vector3d& p) const {
    return middle_ + scale * (axes_ * (p - frame_.origin) - centre_);
  }
  void region(const Eigen::Vector3d& p, const Eigen::Matrix3d& P, const cv::Scalar& colour) {
    const Eigen::Matrix2d C = scale * scale * axes_ * P * axes_.transpose();
    draw_ellipse(map, at(p), C, kRegion95, colour);
  }
  void line(const Eigen::Vector3d& from, const Eigen::Vector3d& to, const cv::Scalar& colour,
            int width = 1) {
    if (is_drawable(from) && is_drawable(to)) draw_line(map, at(from), at(to), colour, width);
  }
  // OpenCV's fixed points overflow far outside.
  bool is_drawable(const Eigen::Vector3d& p) const {
    return at(p).cwiseAbs().maxCoeff() < 1e4;  // NaN is not
  }

  cv::Mat map;
  double scale;  // [px/m]

 private:
  const MapFrame& frame_;
  Eigen::Vector2d middle_, centre_;
  Eigen::Matrix<double, 2, 3> axes_;
};

void draw_path(Canvas& canvas, std::span<const Eigen::Vector3d> path, const cv::Scalar& colour) {
  for (size_t i = 1; i < path.size(); ++i) canvas.line(path[i - 1], path[i], colour);
}

// A length of 1, 2 or 5 times a power of ten, about a fifth of the map.
void draw_scale(Canvas& canvas, const MapView& view) {
  const double wanted = canvas.map.cols / 5.0 / canvas.scale;
  const double power = std::pow(10.0, std::floor(std::log10(wanted)));
  const double length = (wanted >= 5.0 * power ? 5.0 : wanted >= 2.0 * power ? 2.0 : 1.0) * power;
  const Eigen::Vector2d from(12.0, canvas.map.rows - 12.0);
  draw_line(canvas.map, from, from + Eigen::Vector2d(length * canvas.scale, 0.0), kBlack, 2);
  draw_text(canvas.map, fmt::format("{:g} m", length), from - Eigen::Vector2d(0.0, 6.0));
  draw_text(canvas.map, view.name, {8.0, 16.0});
}

void draw_landmark(Canvas& canvas, const LandmarkEstimate& landmark) {
  const cv::Scalar colour = colour_of(landmark.label);
  canvas.region(landmark.position, landmark.position_covariance, colour);
  draw_label(canvas.map, canvas.at(landmark.position), landmark.label, colour);
  if (landmark.label != Label::kMoving) return;
  canvas.line(landmark.position, landmark.position + landmark.velocity, colour);  // in a second
}

void draw_camera(Canvas& canvas, const CameraEstimate& estimate) {
  const CameraState& camera = estimate.state;
  const double length = 14.0 / canvas.scale;  // [m] of the wedge that stands for it
  for (const double side : {-0.5, 0.5}) {
    const Eigen::Vector3d corner(side * length, side * length, length);
    canvas.line(camera.position, camera.position + camera.orientation * corner, kBlack, 2);
  }
  canvas.region(camera.position, estimate.covariance.topLeftCorner<3, 3>(), kBlack);
}

}  // namespace

cv::Mat draw_map(const MapFrame& frame, const MapView& view, const cv::Size& size,
                 const PictureState& state) {
  Canvas canvas(frame, view, size);
  // What is not measured lies below.
  for (const bool measured : {false, true}) {
    for (const LandmarkEstimate& landmark : state.landmarks) {
      if (state.is_measured(landmark.track) != measured) continue;
      if (!canvas.is_drawable(landmark.position)) continue;
      if (measured) {
        draw_landmark(canvas, landmark);
      } else if (landmark.label == Label::kStatic) {
        draw_dot(canvas.map, canvas.at(landmark.position), kGrey);
      }
    }
  }
  draw_path(canvas, state.truth, kGrey);
  draw_path(canvas, state.path, kBlack);
  draw_camera(canvas, state.estimate);
  draw_scale(canvas, view);
  cv::rectangle(canvas.map, {0, 0}, {size.width - 1, size.height - 1}, kPale);
  return canvas.map;
}

}  // namespace slammot
