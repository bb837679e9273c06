#include "datasets/readers/tum_images.h"

#include <fmt/format.h>

#include "datasets/native/native_tables.h"
#include "datasets/readers/foreign_images.h"
#include "datasets/text/text_table.h"

namespace slammot {
namespace {

constexpr Camera kRosDefault{640, 480, 525.0, 525.0, 319.5, 239.5, PinholeLens{}};
constexpr Camera kFreiburg3{640, 480, 535.4, 539.2, 320.1, 247.6, PinholeLens{}};

}  // namespace

bool is_tum_rgbd(const std::filesystem::path& folder) {
  return std::filesystem::is_regular_file(folder / "rgb.txt");
}

Sequence read_tum_rgbd(const std::filesystem::path& folder) {
  Sequence sequence = foreign_sequence(folder);
  const std::filesystem::path file = folder / "rgb.txt";
  const std::string text = read_text_file(file);
  sequence.camera = text.find("freiburg3") != std::string::npos ? kFreiburg3 : kRosDefault;
  TextTable table(file, text);
  while (table.next_blank_row(2)) {
    add_image(table, table.real(0), std::string(table.field(1)), sequence);
  }
  require_frames(file, sequence);
  const std::filesystem::path truth = folder / "groundtruth.txt";
  if (std::filesystem::exists(truth)) {
    sequence.truth = interpolate_truth(read_poses(truth, read_text_file(truth)), sequence.frames);
  }
  return sequence;
}

}  // namespace slammot
