#include "frontend/features/chessboard.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <stdexcept>

#include "datasets/text/number.h"

namespace slammot {
namespace {

constexpr double kCornerSigma = 0.2;  // [px] of a chessboard's corner, a cautious value

std::vector<Eigen::Vector3d> positions_of(const Chessboard& board) {
  std::vector<Eigen::Vector3d> positions;
  for (int row = 0; row < board.rows; ++row) {
    for (int column = 0; column < board.columns; ++column) {
      positions.emplace_back(board.pitch * column, board.pitch * row, 0.0);
    }
  }
  return positions;
}

// T_WC from the corners, seen by a pinhole of focal length 1.
std::optional<CameraState> camera_pose(const std::vector<Eigen::Vector3d>& positions,
                                       const std::vector<cv::Point2d>& plane) {
  std::vector<cv::Point3d> points;
  for (const Eigen::Vector3d& p : positions) points.emplace_back(p.x(), p.y(), p.z());
  cv::Vec3d turn, shift;
  if (!cv::solvePnP(points, plane, cv::Matx33d::eye(), cv::noArray(), turn, shift)) {
    return std::nullopt;
  }
  CameraState state;
  const Eigen::Quaterniond R_camera_world = exp_so3(Eigen::Vector3d(turn[0], turn[1], turn[2]));
  state.orientation = R_camera_world.conjugate();
  state.position = -(state.orientation * Eigen::Vector3d(shift[0], shift[1], shift[2]));
  return state;
}

// The largest axis of position and of rotation in the inverse of the normal equations, with
// z = h(R'(p - r)): dz/dr = -J R', dz/dtheta = J hat(R'(p - r)).
void state_sigmas(const Camera& camera, const std::vector<Eigen::Vector3d>& positions,
                  InitialCamera& initial) {
  Matrix6d information = Matrix6d::Zero();
  const Eigen::Matrix3d R_transposed = initial.state.orientation.toRotationMatrix().transpose();
  for (const Eigen::Vector3d& position : positions) {
    const Eigen::Vector3d ray = R_transposed * (position - initial.state.position);
    const auto projection = camera.project(ray);
    if (!projection) continue;
    Eigen::Matrix<double, 2, 6> J;
    J << -projection->J_pixel_ray * R_transposed, projection->J_pixel_ray * hat(ray);
    information += J.transpose() * J / (kCornerSigma * kCornerSigma);
  }
  const Matrix6d covariance = information.ldlt().solve(Matrix6d::Identity());
  initial.position_sigma = std::sqrt(covariance.diagonal().head<3>().maxCoeff());
  initial.rotation_sigma = std::sqrt(covariance.diagonal().tail<3>().maxCoeff());
}

}  // namespace

Chessboard parse_chessboard(const std::string& text) {
  const auto [first, rest] = cut_at('x', text);
  const auto [second, third] = cut_at(',', rest);
  const auto columns = parse_number<int>(first), rows = parse_number<int>(second);
  const auto pitch = parse_number<double>(third);
  if (!columns || !rows || !pitch || *columns < 3 || *rows < 3 || !(*pitch > 0.0) ||
      !std::isfinite(*pitch)) {
    throw std::invalid_argument(fmt::format(
        "chessboard '{}': expected COLSxROWS,PITCH, as in 9x6,0.04 (inner corners, metres)", text));
  }
  return {*columns, *rows, *pitch};
}

std::vector<size_t> outer_corners(const Chessboard& board) {
  const auto columns = static_cast<size_t>(board.columns), rows = static_cast<size_t>(board.rows);
  return {0, columns - 1, columns * (rows - 1), columns * rows - 1};
}

std::optional<BoardView> find_chessboard(const cv::Mat& image, const Camera& camera,
                                         const Chessboard& board) {
  std::vector<cv::Point2f> corners;
  const cv::Size size(board.columns, board.rows);
  const bool found = cv::findChessboardCornersSB(
      image, size, corners, cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_ACCURACY);
  if (!found) return std::nullopt;
  const auto from_corner = [](const cv::Point2f& p) { return p.x + p.y; };
  if (from_corner(corners.back()) < from_corner(corners.front())) {
    std::reverse(corners.begin(), corners.end());
  }
  BoardView view;
  view.positions = positions_of(board);
  std::vector<cv::Point2d> plane;
  for (const cv::Point2f& corner : corners) {
    view.pixels.emplace_back(corner.x, corner.y);
    const auto bearing = camera.unproject(view.pixels.back());
    if (!bearing) return std::nullopt;
    plane.emplace_back(bearing->ray.x(), bearing->ray.y());
  }
  const auto pose = camera_pose(view.positions, plane);
  if (!pose) return std::nullopt;
  view.camera.state = *pose;
  state_sigmas(camera, view.positions, view.camera);
  return view;
}

}  // namespace slammot
