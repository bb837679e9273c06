#include "datasets/native/native_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

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

namespace {

struct ObservationRow {
  int frame;
  Observation observation;
  int line;
};

// Frame and track as one number that sorts by frame, then track.
std::int64_t key(const ObservationRow& row) {
  return (std::int64_t{row.frame} << 32) + row.observation.track;
}

std::vector<ObservationRow> observation_rows(TextTable& table, size_t frames,
                                             const Camera& camera) {
  constexpr std::string_view headers[] = {native::kObservationsHeader,
                                          native::kObservationsWithSigmaHeader};
  const size_t columns = 4 + table.expect_header(headers);
  std::vector<ObservationRow> rows;
  while (table.next_comma_row(columns)) {
    const int frame = existing_frame(table, 0, frames);
    const Eigen::Vector2d pixel(table.real(2), table.real(3));
    table.refuse_if(pixel_fault(camera, pixel));
    const double relative_sigma = columns == 5 ? table.positive(4) : 1.0;
    rows.push_back({frame, {table.count(1), pixel, relative_sigma}, table.line()});
  }
  const auto before = [](const auto& a, const auto& b) { return key(a) < key(b); };
  if (!std::is_sorted(rows.begin(), rows.end(), before)) {
    std::stable_sort(rows.begin(), rows.end(), before);
  }
  return rows;
}

}  // namespace

void read_observations(const std::filesystem::path& file, std::string_view text,
                       const Camera& camera, std::vector<Frame>& frames) {
  TextTable table(file, text);
  const std::vector<ObservationRow> rows = observation_rows(table, frames.size(), camera);
  for (size_t i = 0; i < rows.size(); ++i) {
    if (i > 0 && key(rows[i]) == key(rows[i - 1])) {
      throw InputError(file, rows[i].line,
                       fmt::format("track {} stands twice in frame {} (first in line {})",
                                   rows[i].observation.track, rows[i].frame, rows[i - 1].line));
    }
    frames[static_cast<size_t>(rows[i].frame)].observations.push_back(rows[i].observation);
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

}  // namespace slammot
