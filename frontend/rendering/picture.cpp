#include "frontend/rendering/picture.h"

#include <fmt/format.h>

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
  const LandmarkEstimate* landmark = find_track(state.landmarks, track);
  return landmark ? landmark->label : Label::kUnknown;  // pruned in this frame
}

}  // namespace

cv::Mat draw_predictions(const cv::Mat& image, int enlarge, const PictureState& state,
                         std::size_t camera) {
  const CameraView& view = state.views[camera];
  cv::Mat picture;
  cv::resize(image, picture, {}, enlarge, enlarge, cv::INTER_NEAREST);
  if (picture.channels() == 1) cv::cvtColor(picture, picture, cv::COLOR_GRAY2BGR);
  for (const Observation& z : view.observations) {
    const Prediction* prediction = find_track(view.predictions, z.track);
    draw_cross(picture, enlarged(z.pixel, enlarge),
               prediction ? prediction->measured : Measured::kNot);
  }
  for (const Prediction& p : view.predictions) {
    const Label label = label_of(state, p.track);
    const cv::Scalar colour = p.measured == Measured::kNot ? kNotFound : colour_of(label);
    const Eigen::Vector2d centre = enlarged(p.pixel, enlarge);
    draw_ellipse(picture, centre, enlarge * enlarge * p.S, kTwoSigma, colour);
    draw_label(picture, centre, label, colour);
  }
  for (const Observation& z : view.observations) {
    const LandmarkEstimate* landmark = find_track(state.landmarks, z.track);
    if (find_track(view.predictions, z.track) || !landmark) continue;
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

cv::Mat joined(const cv::Mat& a, const cv::Mat& b, bool below) {
  cv::Mat both;
  below ? cv::vconcat(a, b, both) : cv::hconcat(a, b, both);
  return both;
}

bool is_wide(const cv::Mat& image) { return image.cols > 2 * image.rows; }

// Says on the image whose it is, and frames it.
void draw_tag(cv::Mat& picture, const std::string& text) {
  const cv::Size size = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, kTextScale, 1, nullptr);
  cv::rectangle(picture, {0, 0, size.width + 12, size.height + 12}, cv::Scalar(kWhite), cv::FILLED);
  draw_text(picture, text, {6.0, size.height + 6.0});
  cv::rectangle(picture, {0, 0}, {picture.cols - 1, picture.rows - 1}, cv::Scalar(kWhite));
}

// Of several cameras beside each other, wide ones below each other.
cv::Mat draw_images(const std::vector<cv::Mat>& images, const PictureState& state) {
  const cv::Mat& first = images.front();
  const int enlarge = first.cols < 500 ? 2 : 1;
  cv::Mat seen;
  for (std::size_t camera = 0; camera < images.size(); ++camera) {
    const bool is_there = !images[camera].empty();
    const cv::Mat ground = is_there ? images[camera] : cv::Mat(first.size(), CV_8UC3, kPale);
    cv::Mat drawn = draw_predictions(ground, enlarge, state, camera);
    if (images.size() > 1) {
      draw_tag(drawn, fmt::format("camera {}{}", camera, is_there ? "" : ": no image"));
    }
    seen = seen.empty() ? drawn : joined(seen, drawn, is_wide(first));
  }
  return seen;
}

}  // namespace

// The maps are beside the image, or below what is wide.
cv::Mat draw_page(const std::vector<cv::Mat>& images, const PictureState& state,
                  const MapFrame& frame, const std::string& caption) {
  const cv::Mat seen = draw_images(images, state);
  const auto map = [&](const MapView& view, int width, int height) {
    return draw_map(frame, view, {width, height}, state);
  };
  cv::Mat page;
  if (is_wide(seen) || images.size() > 1) {
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
