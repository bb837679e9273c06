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
  for (int i = 0; i < 40; ++i) points.emplace_back(i % 2 == 0 ? 3.0 : 600.0, 1.0, 5.0);
  const MapFrame frame = map_frame({}, metres_forward(9), points);
  EXPECT_LT(frame.shown.sizes().maxCoeff(), 20.0);
  EXPECT_TRUE(frame.shown.contains(Eigen::Vector3d(3.0, 5.0, -1.0)));  // right, forward, up
}

TEST(Map, OfACameraAtRestShowsTheNearestPoints) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 1; i <= 40; ++i) points.emplace_back(0.0, 0.0, i);
  const MapFrame frame = map_frame({}, metres_forward(1), points);
  EXPECT_TRUE(frame.shown.contains(Eigen::Vector3d(0.0, 10.0, 0.0)));
  EXPECT_FALSE(frame.shown.contains(Eigen::Vector3d(0.0, 20.0, 0.0)));
}

PictureState measured(const LandmarkEstimate& landmark) {
  PictureState state;
  state.landmarks = {landmark};
  state.views[0].observations = {{landmark.track, {20.0, 30.0}}};
  return state;
}

// Where two pictures differ.
cv::Mat difference_of(const cv::Mat& a, const cv::Mat& b) {
  cv::Mat difference, grey;
  cv::absdiff(a, b, difference);
  cv::cvtColor(difference, grey, cv::COLOR_BGR2GRAY);
  return grey > 30;
}

cv::Mat on_map(const PictureState& state, const MapView& view = kTopView) {
  const MapFrame frame = map_frame({}, metres_forward(9), {{2.0, -1.0, 4.0}});
  return difference_of(draw_map(frame, view, {400, 400}, state),
                       draw_map(frame, view, {400, 400}, {}));
}

// The coloured pixels of one landmark, cut out.
cv::Mat mark_of(Label label) {
  const cv::Mat mask = on_map(measured(at({2.0, -1.0, 4.0}, label)));
  return mask(cv::boundingRect(mask)).clone();
}

TEST(Map, IsSeenFromTheSideToo) {
  const PictureState state = measured(at({2.0, -1.0, 4.0}, Label::kStatic));
  const cv::Rect above = cv::boundingRect(on_map(state)),
                 side = cv::boundingRect(on_map(state, kSideView));
  // The middle of what is shown: 1 m to the right, 4 m forward, 0.5 m up.
  EXPECT_GT(above.x, 200);                              // to the right
  EXPECT_NEAR(above.y + above.height / 2.0, 200, 2.0);  // forward
  EXPECT_NEAR(side.x + side.width / 2.0, 200, 2.0);
  EXPECT_LT(side.y, 200);  // up
}

TEST(Map, LeavesOffWhatIsNotMeasuredButADotWhereItIsStatic) {
  for (const Label label : {Label::kUnknown, Label::kStatic, Label::kMoving}) {
    PictureState state = measured(at({2.0, -1.0, 4.0}, label));
    state.views[0].observations.clear();
    const int marked = cv::countNonZero(on_map(state));
    EXPECT_EQ(marked > 0, label == Label::kStatic);
    EXPECT_LT(marked, 20);
  }
}

PictureState with_prediction(Measured what) {
  PictureState state = measured(at({2.0, -1.0, 4.0}, Label::kStatic));
  if (what == Measured::kNot) state.views[0].observations.clear();
  state.views[0].predictions = {{0, {60.0, 40.0}, Eigen::Vector2d(100.0, 25.0).asDiagonal(), what}};
  return state;
}

// Of what is drawn into an image of 120 x 80.
cv::Rect box_of(const PictureState& state) {
  const cv::Mat image(80, 120, CV_8UC1, cv::Scalar(128));
  return cv::boundingRect(
      difference_of(draw_predictions(image, 1, state), draw_predictions(image, 1, {})));
}

// Two sigma of S around the prediction, not around what was measured. Without a prediction, as in a
// run of an earlier build, a mark where it was measured.
TEST(Image, HasTheEllipseOfSOrTheMarkAtTheMeasurement) {
  const cv::Rect box = box_of(with_prediction(Measured::kNot));
  EXPECT_NEAR(box.x + box.width / 2.0, 60.5, 1.0);
  EXPECT_NEAR(box.width, 41.0, 2.0);
  EXPECT_NEAR(box.height, 21.0, 2.0);
  const cv::Rect mark = box_of(measured(at({2.0, -1.0, 4.0}, Label::kMoving)));
  EXPECT_NEAR(mark.x + mark.width / 2.0, 20.5, 1.0);
  EXPECT_NEAR(mark.y + mark.height / 2.0, 30.5, 1.0);
}

TEST(Image, TellsARejectedMeasurementByItsShape) {
  const cv::Mat image(80, 120, CV_8UC1, cv::Scalar(255));
  const auto dark = [&](Measured what, int dx, int dy) {
    cv::Mat grey;
    cv::cvtColor(draw_predictions(image, 1, with_prediction(what)), grey, cv::COLOR_BGR2GRAY);
    return grey.at<unsigned char>(30 + dy, 20 + dx) < 200;
  };
  EXPECT_TRUE(dark(Measured::kAccepted, 4, 0));
  EXPECT_FALSE(dark(Measured::kAccepted, 3, 3));
  EXPECT_FALSE(dark(Measured::kRejected, 4, 0));
  EXPECT_TRUE(dark(Measured::kRejected, 3, 3));
}

TEST(Page, HasEvenSides) {
  for (const cv::Size size : {cv::Size(161, 121), cv::Size(641, 481), cv::Size(1241, 377)}) {
    const MapFrame frame = map_frame({}, metres_forward(9), {});
    const cv::Mat page = draw_page({cv::Mat(size, CV_8UC1, cv::Scalar(128))}, {}, frame, "caption");
    EXPECT_EQ(page.rows % 2, 0);
    EXPECT_EQ(page.cols % 2, 0);
    EXPECT_GT(page.rows, size.height);
  }
}

// Beside each other, wide ones below each other. Without an image there are the tracks all the
// same.
TEST(Page, HasTheImagesOfBothCameras) {
  const MapFrame frame = map_frame({}, metres_forward(9), {});
  for (const cv::Size size : {cv::Size(640, 480), cv::Size(1200, 370)}) {
    const cv::Mat image(size, CV_8UC1, cv::Scalar(128));
    PictureState state = measured(at({0.0, 0.0, 900.0}, Label::kMoving));  // not on the map
    state.views = {{}, {{}, {{0, {200.0, 100.0}}}}};
    PictureState nothing = state;
    nothing.views[1].observations.clear();
    for (const cv::Mat& second : {image, cv::Mat()}) {
      const cv::Mat page = draw_page({image, second}, state, frame, "caption");
      const cv::Rect mark = cv::boundingRect(
          difference_of(page, draw_page({image, second}, nothing, frame, "caption")));
      const bool is_beside = size.width < 2 * size.height;
      EXPECT_NEAR(mark.x + mark.width / 2, 200 + (is_beside ? size.width : 0), 1);
      EXPECT_NEAR(mark.y + mark.height / 2, 100 + (is_beside ? 0 : size.height), 1);
      EXPECT_LT(mark.width, 20);
      EXPECT_EQ(page.cols, is_beside ? 2 * size.width : size.width);
    }
  }
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
