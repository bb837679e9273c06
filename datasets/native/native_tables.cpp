#include "datasets/native/native_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <tuple>

#include "datasets/native/native_format.h"
#include "datasets/native/native_settings.h"
#include "datasets/sequence/plausible.h"
#include "datasets/text/text_table.h"

namespace slammot {
namespace {

int existing_frame(const TextTable& table, size_t i, size_t frames) {
  const int frame = table.count(i);
  if (static_cast<size_t>(frame) >= frames) {
    table.refuse(fmt::format("frame {} does not exist (frames.csv ends at {})", frame, frames - 1));
  }
  return frame;
}

int existing_camera(const TextTable& table, size_t i, const Rig& rig) {
  const int camera = table.count(i);
  if (camera >= rig.size()) {
    table.refuse(
        fmt::format("camera {} does not exist (sequence.yaml ends at {})", camera, rig.size() - 1));
  }
  return camera;
}

}  // namespace

void read_frames(const std::filesystem::path& file, std::string_view text, Sequence& sequence) {
  constexpr std::string_view headers[] = {native::kFramesHeader, native::kFramesWithImagesHeader};
  TextTable table(file, text);
  const size_t columns = 2 + table.expect_header(headers);
  while (table.next_comma_row_and_rest(columns)) {
    Frame frame;
    frame.index = table.count(0);
    frame.timestamp = table.real(1);
    if (static_cast<size_t>(frame.index) != sequence.frames.size()) {
      table.refuse(
          fmt::format("frame {} stands where frame {} must", frame.index, sequence.frames.size()));
    }
    table.refuse_if(sequence.frames.empty()
                        ? time_fault(frame.timestamp)
                        : step_fault(sequence.frames.back().timestamp, frame.timestamp));
    sequence.frames.push_back(std::move(frame));
    if (columns == 3) sequence.images.emplace_back(table.field(2));
  }
  if (sequence.frames.empty()) table.refuse("there is no frame");
}

void read_other_images(const std::filesystem::path& file, std::string_view text,
                       Sequence& sequence) {
  constexpr std::string_view headers[] = {native::kOtherImagesHeader};
  TextTable table(file, text);
  table.expect_header(headers);
  const Rig rig(sequence.camera, sequence.other_cameras);
  sequence.other_images.assign(sequence.other_cameras.size(),
                               std::vector<std::string>(sequence.frames.size()));
  while (table.next_comma_row_and_rest(3)) {
    const int frame = existing_frame(table, 0, sequence.frames.size());
    const int camera = existing_camera(table, 1, rig);
    if (camera == 0) table.refuse("the images of camera 0 stand in frames.csv");
    std::string& image =
        sequence.other_images[static_cast<size_t>(camera) - 1][static_cast<size_t>(frame)];
    if (!image.empty()) {
      table.refuse(fmt::format("frame {} has a second image of camera {}", frame, camera));
    }
    image = table.field(2);
    if (image.empty()) table.refuse("names no image");
  }
}

namespace {

struct ObservationRow {
  int frame;
  Observation observation;
  int line;

  auto key() const { return std::tuple(frame, observation.track, observation.camera); }
};

// Where the optional columns begin; 0: they are not there.
struct ObservationColumns {
  size_t count, sigma, camera, depth;
};

ObservationColumns observation_columns(TextTable& table) {
  constexpr std::string_view optional[] = {native::kSigmaColumn, native::kCameraColumn,
                                           native::kDepthColumns};
  const std::vector<size_t> at = table.expect_header(native::kObservationsHeader, optional);
  const size_t count = 4 + (at[0] > 0 ? 1 : 0) + (at[1] > 0 ? 1 : 0) + (at[2] > 0 ? 2 : 0);
  return {count, at[0], at[1], at[2]};
}

// Both fields are empty where nothing is measured.
void read_depth(const TextTable& table, size_t i, Observation& z) {
  constexpr double kNearest = 0.05, kFarthest = 1000.0;  // [m]
  if (table.field(i).empty() && table.field(i + 1).empty()) return;
  z.depth = table.real(i);
  z.depth_sigma = table.real(i + 1);
  if (z.camera > 0) table.refuse("a depth is that of camera 0");
  if (!(z.depth >= kNearest && z.depth <= kFarthest)) {
    table.refuse(fmt::format("a depth is {} to {} m, not {}", kNearest, kFarthest, z.depth));
  }
  if (!(z.depth_sigma > 0.0)) {
    table.refuse(fmt::format("the sigma of a depth is above zero, not {}", z.depth_sigma));
  }
}

std::vector<ObservationRow> observation_rows(TextTable& table, size_t frames, const Rig& rig) {
  const ObservationColumns columns = observation_columns(table);
  std::vector<ObservationRow> rows;
  while (table.next_comma_row(columns.count)) {
    ObservationRow row{existing_frame(table, 0, frames), {}, table.line()};
    Observation& z = row.observation;
    z.track = table.count(1);
    z.pixel = {table.real(2), table.real(3)};
    if (columns.sigma > 0) z.relative_sigma = table.positive(columns.sigma);
    if (columns.camera > 0) z.camera = existing_camera(table, columns.camera, rig);
    if (columns.depth > 0) read_depth(table, columns.depth, z);
    table.refuse_if(pixel_fault(rig[z.camera].lens, z.pixel));
    rows.push_back(row);
  }
  const auto before = [](const auto& a, const auto& b) { return a.key() < b.key(); };
  if (!std::is_sorted(rows.begin(), rows.end(), before)) {
    std::stable_sort(rows.begin(), rows.end(), before);
  }
  return rows;
}

}  // namespace

void read_observations(const std::filesystem::path& file, std::string_view text, const Rig& rig,
                       std::vector<Frame>& frames) {
  TextTable table(file, text);
  const std::vector<ObservationRow> rows = observation_rows(table, frames.size(), rig);
  for (size_t i = 0; i < rows.size(); ++i) {
    const Observation& z = rows[i].observation;
    if (i > 0 && rows[i].key() == rows[i - 1].key()) {
      const std::string by = z.camera > 0 ? fmt::format(" of camera {}", z.camera) : "";
      throw InputError(file, rows[i].line,
                       fmt::format("track {} stands twice in frame {}{} (first in line {})",
                                   z.track, rows[i].frame, by, rows[i - 1].line));
    }
    Frame& frame = frames[static_cast<size_t>(rows[i].frame)];
    (z.camera == 0 ? frame.observations : frame.other_views).push_back(z);
  }
}

std::vector<TimedPose> read_poses(const std::filesystem::path& file, std::string_view text) {
  TextTable table(file, text);
  std::vector<TimedPose> poses;
  while (table.next_blank_row(8)) {
    const Eigen::Vector4d xyzw(table.real(4), table.real(5), table.real(6), table.real(7));
    const Eigen::Quaterniond q = unit_quaternion(table, Eigen::Quaterniond(xyzw));
    const double timestamp = table.real(0);
    table.refuse_if(poses.empty() ? time_fault(timestamp)
                                  : order_fault(poses.back().timestamp, timestamp));
    poses.push_back({timestamp, vector_at(table, 1), q, table.line()});
  }
  return poses;
}

namespace {

Label read_class(const TextTable& table, size_t i) {
  for (const Label label : {Label::kStatic, Label::kMoving}) {
    if (table.field(i) == to_string(label)) return label;
  }
  table.refuse(fmt::format("unknown class '{}' (known: static, moving)", table.field(i)));
}

void add_row(const TextTable& table, Label label, int frame, TrueLandmark& landmark) {
  if (!landmark.by_frame.empty() && landmark.label != label) {
    table.refuse(fmt::format("track {} is both static and moving", table.field(0)));
  }
  if (!landmark.by_frame.empty() && label == Label::kStatic) {
    table.refuse(fmt::format("static track {} has a second row", table.field(0)));
  }
  landmark.label = label;
  const TruePoint point{vector_at(table, 3), vector_at(table, 6)};
  if (!landmark.by_frame.emplace(frame, point).second) {
    table.refuse(fmt::format("track {} stands twice in frame {}", table.field(0), frame));
  }
}

}  // namespace

std::map<int, TrueLandmark> read_landmarks(const std::filesystem::path& file, std::string_view text,
                                           size_t frames) {
  constexpr std::string_view headers[] = {native::kLandmarksHeader};
  TextTable table(file, text);
  table.expect_header(headers);
  std::map<int, TrueLandmark> landmarks;
  while (table.next_comma_row(9)) {
    const int track = table.count(0);
    const int frame = existing_frame(table, 1, frames);
    add_row(table, read_class(table, 2), frame, landmarks[track]);
  }
  return landmarks;
}

std::vector<KnownLandmark> read_known(const std::filesystem::path& file, std::string_view text) {
  constexpr std::string_view headers[] = {native::kKnownHeader};
  TextTable table(file, text);
  table.expect_header(headers);
  std::vector<KnownLandmark> known;
  std::set<int> tracks;
  while (table.next_comma_row(5)) {
    const int track = table.count(0);
    if (!tracks.insert(track).second) table.refuse(fmt::format("track {} stands twice", track));
    known.push_back({track, vector_at(table, 1), table.positive(4)});
  }
  return known;
}

std::map<int, double> read_priors(const std::filesystem::path& file, std::string_view text) {
  constexpr std::string_view headers[] = {native::kPriorsHeader};
  TextTable table(file, text);
  table.expect_header(headers);
  std::map<int, double> p_static;
  while (table.next_comma_row(2)) {
    const int track = table.count(0);
    const double p = table.real(1);
    if (!(p >= 0.0 && p <= 1.0)) table.refuse(fmt::format("a probability is 0 to 1, not {}", p));
    if (!p_static.emplace(track, p).second) {
      table.refuse(fmt::format("track {} stands twice", track));
    }
  }
  return p_static;
}

}  // namespace slammot
