#include "eval/output/run_reader.h"

#include <fmt/format.h>

#include <functional>
#include <map>

#include "datasets/sequence/plausible.h"
#include "datasets/text/yaml_map.h"
#include "eval/output/metrics_json.h"
#include "eval/output/run_files.h"

namespace slammot {
namespace {

using Path = std::filesystem::path;

template <int N>
Eigen::Matrix<double, N, N> from_upper_triangle(const TextTable& row, size_t first) {
  Eigen::Matrix<double, N, N> m;
  for (int i = 0; i < N; ++i) {
    for (int j = i; j < N; ++j) m(i, j) = m(j, i) = row.real_or_nan(first++);
  }
  return m;
}

Eigen::Vector3d vector_or_nan_at(const TextTable& row, size_t first) {
  return {row.real_or_nan(first), row.real_or_nan(first + 1), row.real_or_nan(first + 2)};
}

Label label_at(const TextTable& row, size_t field) {
  for (const Label label : {Label::kUnknown, Label::kStatic, Label::kMoving}) {
    if (row.field(field) == to_string(label)) return label;
  }
  row.refuse(fmt::format("'{}' is not a label", row.field(field)));
}

// The rows of a CSV file of a run, below its comments and its heading; none without the file.
void for_each_row(const Path& file, size_t columns,
                  const std::function<void(const TextTable& row)>& visit) {
  if (!std::filesystem::exists(file)) return;
  const std::string text = read_text_file(file);
  TextTable table(file, text);
  table.pass_comments();
  table.pass_line();
  for (table.pass_comments(); table.next_comma_row(columns); table.pass_comments()) visit(table);
}

std::vector<CameraEstimate> read_trajectory(const Path& file) {
  std::vector<CameraEstimate> cameras;
  const std::string text = read_text_file(file);
  for (TextTable row(file, text); row.next_blank_row(8);) {
    CameraEstimate camera;
    camera.timestamp = row.real(0);
    camera.state.position = vector_at(row, 1);
    const Eigen::Vector3d im = vector_at(row, 4);
    camera.state.orientation = Eigen::Quaterniond(row.real(7), im.x(), im.y(), im.z());
    row.refuse_if(quaternion_fault(camera.state.orientation));
    camera.state.orientation.normalize();
    camera.covariance.setConstant(kUndefined);
    row.refuse_if(cameras.empty() ? time_fault(camera.timestamp)
                                  : order_fault(cameras.back().timestamp, camera.timestamp));
    cameras.push_back(camera);
  }
  if (cameras.empty()) throw InputError(file, 0, "holds no pose");
  return cameras;
}

void read_covariances(const Path& file, std::vector<CameraEstimate>& cameras) {
  if (!std::filesystem::exists(file)) return;
  size_t count = 0;
  for_each_row(file, 22, [&](const TextTable& row) {
    if (count == cameras.size()) row.refuse("there are more rows than poses");
    CameraEstimate& camera = cameras[count++];
    if (std::abs(row.real(0) - camera.timestamp) > 1e-6) {
      row.refuse("the timestamp is not that of the pose");
    }
    camera.covariance.topLeftCorner<6, 6>() = from_upper_triangle<6>(row, 1);
  });
  if (count != cameras.size()) throw InputError(file, 0, "has not one row for each pose");
}

}  // namespace

std::vector<LandmarkRecord> read_landmark_rows(const Path& file) {
  std::vector<LandmarkRecord> records;
  for_each_row(file, 21, [&](const TextTable& row) {
    LandmarkRecord record;
    record.estimate.track = row.count(0);
    record.frame = row.count(1);
    record.estimate.label = label_at(row, 2);
    record.estimate.position = vector_or_nan_at(row, 3);
    record.estimate.velocity = vector_or_nan_at(row, 6);
    record.estimate.position_covariance = from_upper_triangle<3>(row, 9);
    record.estimate.velocity_covariance = from_upper_triangle<3>(row, 15);
    records.push_back(record);
  });
  return records;
}

namespace {

// Of several rows of a track (`--landmarks every-frame`) the last is its final state.
std::vector<LandmarkRecord> read_landmarks(const Path& file) {
  std::map<int, LandmarkRecord> last;
  for (const LandmarkRecord& record : read_landmark_rows(file)) {
    last[record.estimate.track] = record;
  }
  std::vector<LandmarkRecord> records;
  for (const auto& [track, record] : last) records.push_back(record);
  return records;
}

std::vector<ClassificationRecord> read_classification(const Path& file) {
  std::vector<ClassificationRecord> records;
  for_each_row(file, 5, [&](const TextTable& row) {
    ClassificationRecord record;
    record.track = row.count(0);
    if (row.field(1) != "-") record.truth = label_at(row, 1);
    record.label = label_at(row, 2);
    if (!row.field(3).empty()) record.decision_frame = row.count(3);
    record.observations = row.count(4);
    records.push_back(record);
  });
  return records;
}

std::vector<StageTime> read_timing(const Path& file) {
  std::vector<StageTime> timing;
  for_each_row(file, 4, [&](const TextTable& row) {
    timing.push_back({row.count(0), std::string(row.field(1)), row.real(2), row.count(3)});
  });
  return timing;
}

void read_metrics(const Path& file, RunResult& run) {
  if (!std::filesystem::exists(file)) return;
  const std::string text = read_text_file(file);
  try {
    restore_totals(nlohmann::ordered_json::parse(text), run);
  } catch (const nlohmann::json::exception& error) {
    throw InputError(file, 0, error.what());
  }
}

void read_description(const Path& file, StoredRun& stored) {
  if (!std::filesystem::exists(file)) return;
  try {
    const YAML::Node root = load_yaml_node(file, read_text_file(file));
    if (!root.IsMap()) throw InputError(file, 1, "must be a map of keys to values");
    stored.estimator = printable(root["estimator"].as<std::string>(""));
    const YAML::Node configuration = root["configuration"];
    stored.landmark = printable(configuration["landmark"].as<std::string>(""));
    const YAML::Node gate = configuration["gate.probability"];
    stored.gate_probability = gate.as<double>(0.95);
    if (!(stored.gate_probability > 0.0 && stored.gate_probability <= 1.0)) {
      throw InputError(file, gate.Mark().line + 1, "gate.probability is no probability above 0");
    }
    const double pixel_sigma = configuration["pixel_sigma"].as<double>(0.0);  // or "sequence"
    if (pixel_sigma > 0.0) stored.pixel_sigma = pixel_sigma;
    const std::string sequence = root["sequence"]["path"].as<std::string>("");
    if (!sequence.empty()) stored.sequence = sequence;
  } catch (const YAML::Exception& error) {
    throw InputError(file, error.mark.line + 1, error.msg);
  }
}

}  // namespace

StoredRun read_run(const Path& folder) {
  StoredRun stored;
  RunResult& run = stored.run;
  read_description(folder / run_files::kDescription, stored);
  run.filtered = read_trajectory(folder / run_files::kTrajectory);
  read_covariances(folder / run_files::kPoseCovariance, run.filtered);
  if (std::filesystem::exists(folder / run_files::kTrajectorySmoothed)) {
    run.smoothed = read_trajectory(folder / run_files::kTrajectorySmoothed);
    read_covariances(folder / run_files::kPoseCovarianceSmoothed, run.smoothed);
  }
  run.frames.resize(run.filtered.size(), -1);  // a trajectory knows times, not frame numbers
  run.frames_offered = static_cast<int>(run.filtered.size());
  run.landmarks = read_landmarks(folder / run_files::kLandmarks);
  run.classification = read_classification(folder / run_files::kClassification);
  run.timing = read_timing(folder / run_files::kTiming);
  read_metrics(folder / run_files::kMetrics, run);
  return stored;
}

}  // namespace slammot
