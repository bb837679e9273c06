#include "datasets/readers/tum_images.h"

#include <fmt/format.h>

#include <algorithm>

#include "datasets/native/native_tables.h"
#include "datasets/readers/foreign_images.h"
#include "datasets/text/text_table.h"

namespace slammot {
namespace {

// The colour cameras as the data set's page calibrates them; freiburg3's images are undistorted.
// Its rgb.txt names the sequence.
constexpr std::pair<std::string_view, Camera> kTumCameras[] = {
    {"freiburg1",
     {640, 480, 517.3, 516.5, 318.6, 255.3,
      RadtanLens{{0.2624, -0.9531, -0.0054, 0.0026, 1.1633}}}},
    {"freiburg2",
     {640, 480, 520.9, 521.0, 325.1, 249.7,
      RadtanLens{{0.2312, -0.7849, -0.0033, -0.0001, 0.9172}}}},
    {"freiburg3", {640, 480, 535.4, 539.2, 320.1, 247.6, PinholeLens{}}}};
constexpr Camera kRosDefault{640, 480, 525.0, 525.0, 319.5, 239.5, PinholeLens{}};

void state_camera(std::string_view text, Sequence& sequence) {
  const auto named = std::ranges::find_if(
      kTumCameras, [&](const auto& c) { return text.find(c.first) != std::string_view::npos; });
  sequence.camera_assumed = named == std::end(kTumCameras);
  sequence.camera = sequence.camera_assumed ? kRosDefault : named->second;
}

// Rows of a time and a file.
void list_images(const std::filesystem::path& file, std::string_view text, Sequence& sequence) {
  TextTable table(file, text);
  while (table.next_blank_row(2)) {
    add_image(table, table.real(0), std::string(table.field(1)), sequence);
  }
  require_frames(file, sequence);
}

}  // namespace

bool is_tum_rgbd(const std::filesystem::path& folder) {
  return std::filesystem::is_regular_file(folder / "rgb.txt");
}

Sequence read_tum_rgbd(const std::filesystem::path& folder) {
  Sequence sequence = foreign_sequence(folder);
  const std::filesystem::path file = folder / "rgb.txt";
  const std::string text = read_text_file(file);
  state_camera(text, sequence);
  list_images(file, text, sequence);
  const std::filesystem::path truth = folder / "groundtruth.txt";
  if (is_there(truth)) {
    sequence.truth = true_cameras(read_poses(truth, read_text_file(truth)), sequence.frames);
  }
  return sequence;
}

// The two cameras are not triggered together.
void add_tum_depth(Sequence& sequence) {
  constexpr double kApart = 0.02;  // [s]
  const std::filesystem::path file = sequence.folder / "depth.txt";
  if (!std::filesystem::is_regular_file(file)) return;
  Sequence listed;
  list_images(file, read_text_file(file), listed);
  sequence.depth_images = nearest_images(file, listed, sequence.frames, kApart);
  sequence.depth_unit = 1.0 / 5000.0;
}

}  // namespace slammot
