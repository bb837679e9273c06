#include "frontend/rendering/picture.h"

#include <functional>
#include <opencv2/imgproc.hpp>

#include "frontend/rendering/marks.h"

namespace slammot {

using namespace marks;

namespace {

// Of the image's pixels, whose centres are whole numbers before and after.
Eigen::Vector2d enlarged(const Eigen::Vector2d& pixel, int enlarge) {
  return enlarge * (pixel + Eigen::Vector2d(0.5, 0.5)) - Eigen::Vector2d(0.5, 0.5);
}

Label label_of(const PictureState& state, int track) {
  const LandmarkEstimate* landmark = state.landmark(track);
  return landmark ? landmark->label : Label::kUnknown;  // pruned in this frame
}

}  // namespace

cv::Mat draw_predictions(const cv::Mat& image, int enlarge, const PictureState& state) {
  cv::Mat picture;
  cv::resize(image, picture, {}, enlarge, enlarge, cv::INTER_NEAREST);
  if (picture.channels() == 1) cv::cvtColor(picture, picture, cv::COLOR_GRAY2BGR);
  for (const Observation& z : state.observations) {
    const Prediction* prediction = state.prediction(z.track);
    draw_cross(picture, enlarged(z.pixel, enlarge),
               prediction ? prediction->measured : Measured::kNot);
  }
  for (const Prediction& p : state.predictions) {
    const Label label = label_of(state, p.track);
    const cv::Scalar colour = p.measured == Measured::kNot ? kNotFound : colour_of(label);
    const Eigen::Vector2d centre = enlarged(p.pixel, enlarge);
    draw_ellipse(picture, centre, enlarge * enlarge * p.S, kTwoSigma, colour);
    draw_label(picture, centre, label, colour);
  }
  for (const Observation& z : state.observations) {
    const LandmarkEstimate* landmark = state.landmark(z.track);
    if (state.prediction(z.track) || !landmark) continue;
    draw_label(picture, enlarged(z.pixel, enlarge), landmark->label, colour_of(landmark->label));
  }
  return picture;
}

namespace {

struct LegendEntry {
  const char* text;
  std::function<void(cv::Mat&, const Eigen::Vector2d& at)> draw;
};

LegendEntry of_label(const char* text, Label label, const cv::Scalar& colour) {
  return {text, [=](cv::Mat& m, const Eigen::Vector2d& at) { draw_label(m, at, label, colour); }};
}
LegendEntry of_measured(const char* text, Measured measured) {
  return {text, [=](cv::Mat& m, const Eigen::Vector2d& at) { draw_cross(m, at, measured); }};
}
LegendEntry of_path(const char* text, const cv::Scalar& colour) {
  return {text, [=](cv::Mat& m, const Eigen::Vector2d& at) {
            draw_line(m, at - Eigen::Vector2d(7.0, 0.0), at + Eigen::Vector2d(7.0, 0.0), colour, 2);
          }};
}

std::vector<LegendEntry> legend() {
  return {of_label("static", Label::kStatic, colour_of(Label::kStatic)),
          of_label("unknown", Label::kUnknown, colour_of(Label::kUnknown)),
          of_label("moving, one second of it", Label::kMoving, colour_of(Label::kMoving)),
          of_label("predicted, not measured", Label::kStatic, kNotFound),
          of_measured("measured", Measured::kAccepted),
          of_measured("measured, rejected", Measured::kRejected),
          of_measured("measured, new", Measured::kNot),
          {"static, not measured now",
           [](cv::Mat& m, const Eigen::Vector2d& at) { draw_dot(m, at, kGrey); }},
          of_path("camera", kBlack),
          of_path("true camera", kGrey),
          {"2 sigma; on the map 95%", [](cv::Mat& m, const Eigen::Vector2d& at) {
             draw_ellipse(m, at, Eigen::Vector2d(49.0, 16.0).asDiagonal(), 1.0,
                          colour_of(Label::kStatic));
           }}};
}

constexpr int kRow = 24, kColumn = 260;  // of the legend [px]

// The caption above, entries in columns.
cv::Mat draw_legend(const cv::Size& size, const std::string& caption) {
  cv::Mat panel(size, CV_8UC3, kWhite);
  draw_text(panel, caption, {8.0, 18.0}, 0.5);
  const int columns = std::max(1, size.width / kColumn);
  int column = 0, row = 1;
  for (const LegendEntry& entry : legend()) {
    const Eigen::Vector2d at(18.0 + kColumn * column, 18.0 + kRow * row);
    entry.draw(panel, at);
    draw_text(panel, entry.text, at + Eigen::Vector2d(14.0, 5.0));
    if (++column < columns) continue;
    column = 0;
    ++row;
  }
  return panel;
}

int legend_height(int width) {
  const int columns = std::max(1, width / kColumn);
  return kRow * (2 + (static_cast<int>(legend().size()) - 1) / columns) + 12;
}

// The maps beside the image, or below one that is wide.
cv::Mat joined(const cv::Mat& a, const cv::Mat& b, bool below) {
  cv::Mat both;
  below ? cv::vconcat(a, b, both) : cv::hconcat(a, b, both);
  return both;
}

}  // namespace

cv::Mat draw_page(const cv::Mat& image, const PictureState& state, const MapFrame& frame,
                  const std::string& caption) {
  const int enlarge = image.cols < 500 ? 2 : 1;
  const cv::Mat seen = draw_predictions(image, enlarge, state);
  const bool is_wide = seen.cols > 2 * seen.rows;
  const auto map = [&](const MapView& view, int width, int height) {
    return draw_map(frame, view, {width, height}, state);
  };
  cv::Mat page;
  if (is_wide) {
    const int height = 480, half = seen.cols / 2;
    const cv::Mat maps =
        joined(map(kTopView, half, height), map(kSideView, seen.cols - half, height), false);
    page = joined(joined(seen, maps, true),
                  draw_legend({seen.cols, legend_height(seen.cols)}, caption), true);
  } else {
    const int side = seen.rows, below = std::max(legend_height(seen.cols), 2 * side / 5);
    page = joined(joined(seen, draw_legend({seen.cols, below}, caption), true),
                  joined(map(kTopView, side, side), map(kSideView, side, below), true), false);
  }
  cv::copyMakeBorder(page, page, 0, page.rows % 2, 0, page.cols % 2, cv::BORDER_CONSTANT, kWhite);
  return page;
}

}  // namespace slammot
