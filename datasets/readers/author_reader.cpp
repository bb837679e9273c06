#include "datasets/readers/author_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>

#include "datasets/native/native_settings.h"
#include "datasets/sequence/plausible.h"
#include "datasets/sequence/sha256.h"
#include "datasets/sequence/true_poses.h"
#include "datasets/text/text_table.h"

namespace slammot {
namespace {

constexpr double kRate = 30.0;  // [Hz]
constexpr std::string_view kFile = "groundTruth.txt";
constexpr std::string_view kBeginning = "numOfFrames:";

// The author's camera axes as ours: half a turn about z.
const Eigen::Quaterniond kAuthorToOurs(0.0, 0.0, 0.0, 1.0);

constexpr Camera kCamera{320, 240, 170.0, 170.0, 160.0, 120.0, PinholeLens{}};

bool starts(const TextTable& table, std::string_view word) { return table.field(0) == word; }

void expect(TextTable& table, std::string_view word, size_t count) {
  if (!table.next_blank_row() || !starts(table, word)) {
    table.refuse(fmt::format("expected '{}'", word));
  }
  table.check_count(count);
}

TimedPose read_pose(const TextTable& table) {
  const Eigen::Quaterniond wxyz(table.real(4), table.real(5), table.real(6), table.real(7));
  return {table.count(0) / kRate, vector_at(table, 1),
          unit_quaternion(table, wxyz) * kAuthorToOurs};
}

void read_cameras(TextTable& table, Sequence& sequence) {
  expect(table, "numOfFrames", 2);
  const int count = table.count(1);
  if (count == 0) table.refuse("there is no frame");
  expect(table, "Cam", 3);
  std::vector<TimedPose> poses;
  for (int i = 0; i < count; ++i) {
    if (!table.next_blank_row(8)) table.refuse(fmt::format("frame {} of {} is missing", i, count));
    if (table.count(0) != i) table.refuse(fmt::format("frame {} must stand here", i));
    poses.push_back(read_pose(table));
    sequence.frames.push_back({i, i / kRate, {}, {}});
  }
  sequence.truth = true_cameras(poses, sequence.frames);
}

// One line `k, (u, v)` or `k, (X, Y, Z), (u, v)`.
void read_projection(const TextTable& table, int track, Sequence& sequence, TrueLandmark& truth) {
  const bool moving = truth.label == Label::kMoving;
  table.check_count(moving ? 6 : 3);
  const int frame = table.count(0);
  if (static_cast<size_t>(frame) >= sequence.frames.size()) {
    table.refuse(fmt::format("frame {} does not exist", frame));
  }
  const Eigen::Vector2d pixel(table.real(moving ? 4 : 1), table.real(moving ? 5 : 2));
  if (pixel == Eigen::Vector2d(-1, -1)) return;  // not seen
  table.refuse_if(pixel_fault(sequence.camera, pixel));
  auto& observations = sequence.frames[static_cast<size_t>(frame)].observations;
  if (!observations.empty() && observations.back().track == track) {
    table.refuse(fmt::format("point {} stands twice in frame {}", track, frame));
  }
  observations.push_back({track, pixel});
  if (moving) truth.by_frame[frame] = {vector_at(table, 1), Eigen::Vector3d::Zero()};
}

// `Point I: Static|Moving` and, of a static one, `Position: (X, Y, Z)`.
TrueLandmark read_point_head(TextTable& table) {
  TrueLandmark truth;
  if (table.field(2) == "Moving") {
    truth.label = Label::kMoving;
  } else if (table.field(2) == "Static") {
    expect(table, "Position", 4);
    truth.by_frame[0] = {vector_at(table, 1), Eigen::Vector3d::Zero()};
  } else {
    table.refuse(fmt::format("unknown class '{}' (known: Static, Moving)", table.field(2)));
  }
  expect(table, "Projections", 1);
  return truth;
}

void read_points(TextTable& table, Sequence& sequence) {
  for (bool more = table.next_blank_row(); more;) {
    if (!starts(table, "Point")) table.refuse("expected 'Point'");
    table.check_count(3);
    const int track = table.count(1);
    if (sequence.landmarks.count(track) > 0) {
      table.refuse(fmt::format("point {} stands twice", track));
    }
    TrueLandmark& truth = sequence.landmarks[track] = read_point_head(table);
    while ((more = table.next_blank_row()) && !starts(table, "Point")) {
      read_projection(table, track, sequence, truth);
    }
  }
}

// Central differences where both neighbours are there, else one-sided, else zero.
void difference_positions(TrueLandmark& landmark) {
  for (auto& [frame, point] : landmark.by_frame) {
    const bool before = landmark.by_frame.count(frame - 1) > 0;
    const bool after = landmark.by_frame.count(frame + 1) > 0;
    const int from = before ? frame - 1 : frame;
    const int to = after ? frame + 1 : frame;
    if (from == to) continue;
    point.velocity = (landmark.by_frame.at(to).position - landmark.by_frame.at(from).position) *
                     (kRate / (to - from));
  }
}

void state_what_the_author_assumes(Sequence& sequence) {
  sequence.pixel_sigma = 2.0;
  sequence.motion = StatedMotion{6.0, 6.0};
  for (const Observation& z : sequence.frames.front().observations) {
    if (z.track < 9 || z.track > 12) continue;
    const TruePoint* point = sequence.landmarks.at(z.track).at(0);
    if (point) sequence.known.push_back({z.track, point->position, 1e-3});
  }
  InitialCamera initial;
  initial.state = *sequence.truth.front();
  initial.state.velocity = Eigen::Vector3d(0.0, 0.0, 0.6);
  initial.state.angular_velocity.setZero();
  initial.velocity_sigma = 0.1;
  initial.angular_velocity_sigma = 0.1;
  sequence.initial = initial;
}

}  // namespace

Sequence read_author(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / kFile;
  std::string text = read_text_file(file);
  Sequence sequence;
  sequence.folder = folder;
  sequence.name = std::filesystem::absolute(folder / "x").parent_path().filename().string();
  sequence.camera = kCamera;
  Sha256 hash;
  hash.add(text);
  sequence.sha256 = hash.hex();
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '(' || c == ')' || c == ',' || c == ':'; },
      ' ');
  TextTable table(file, text);
  read_cameras(table, sequence);
  read_points(table, sequence);
  for (auto& [track, landmark] : sequence.landmarks) {
    if (landmark.label == Label::kMoving) difference_positions(landmark);
  }
  for (Frame& frame : sequence.frames) {
    std::sort(frame.observations.begin(), frame.observations.end(),
              [](const auto& a, const auto& b) { return a.track < b.track; });
  }
  state_what_the_author_assumes(sequence);
  return sequence;
}

bool is_author(const std::filesystem::path& folder) {
  if (!std::filesystem::is_regular_file(folder / kFile)) return false;  // a pipe would block
  std::ifstream stream(folder / kFile);
  std::string line;
  return std::getline(stream, line) && without_byte_order_mark(line).starts_with(kBeginning);
}

}  // namespace slammot
