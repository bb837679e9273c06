// Pictures of a run: marks that can be told apart without their colours, and a map of what is near.
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "frontend/rendering/picture.h"

namespace slammot {
namespace {

LandmarkEstimate at(const Eigen::Vector3d& position, Label label) {
  LandmarkEstimate landmark;
  landmark.position = position;
  landmark.label = label;
  return landmark;
}

std::vector<Eigen::Vector3d> metres_forward(int count) {
  std::vector<Eigen::Vector3d> path;
  for (int i = 0; i < count; ++i) path.emplace_back(0.0, 0.0, i);
  return path;
}

TEST(Map, FramesThePathNotTheFarthestPoint) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 40; ++i) points.emplace_back(i % 2 == 0 ? 3.0 : 600.0, 0.0, 5.0);
  const MapPlane plane = map_plane({}, metres_forward(9), points);
  EXPECT_LT(plane.shown.sizes().maxCoeff(), 20.0);
  EXPECT_TRUE(plane.shown.contains(Eigen::Vector2d(3.0, 5.0)));
}

TEST(Map, OfACameraAtRestShowsTheNearestPoints) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 1; i <= 40; ++i) points.emplace_back(0.0, 0.0, i);
  const MapPlane plane = map_plane({}, metres_forward(1), points);
  EXPECT_TRUE(plane.shown.contains(Eigen::Vector2d(0.0, 10.0)));
  EXPECT_FALSE(plane.shown.contains(Eigen::Vector2d(0.0, 20.0)));
}

// The coloured pixels of one landmark, cut out.
cv::Mat mark_of(Label label) {
  const Camera camera;
  const CameraEstimate estimate;
  const Eigen::Vector3d position(2.0, 0.0, 4.0);
  const MapPlane plane = map_plane({}, metres_forward(9), {position});
  const PictureState nothing{camera, 1.0, estimate, {}, {}};
  const PictureState one{camera, 1.0, estimate, {at(position, label)}, {}};
  const cv::Size size(400, 400);
  cv::Mat difference, grey;
  cv::absdiff(draw_map(plane, size, one, {}, {}), draw_map(plane, size, nothing, {}, {}),
              difference);
  cv::cvtColor(difference, grey, cv::COLOR_BGR2GRAY);
  const cv::Mat mask = grey > 30;
  return mask(cv::boundingRect(mask)).clone();
}

TEST(Map, MarksAreSixPixelsAtLeastAndDifferInShape) {
  std::vector<cv::Mat> marks;
  for (const Label label : {Label::kUnknown, Label::kStatic, Label::kMoving}) {
    marks.push_back(mark_of(label));
    EXPECT_GE(marks.back().cols, 6);
    EXPECT_GE(marks.back().rows, 6);
  }
  // Parts of the box that are filled: an open square, a disc, a diamond.
  const auto filled = [](const cv::Mat& mask) {
    return cv::countNonZero(mask) / static_cast<double>(mask.total());
  };
  EXPECT_EQ(marks[0].at<unsigned char>(marks[0].rows / 2, marks[0].cols / 2), 0);
  EXPECT_GT(filled(marks[1]), 0.7);
  EXPECT_LT(filled(marks[2]), 0.68);
  EXPECT_EQ(marks[2].at<unsigned char>(0, 0), 0);
}

}  // namespace
}  // namespace slammot
