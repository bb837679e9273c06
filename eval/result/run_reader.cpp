#include "eval/result/run_reader.h"

#include <yaml-cpp/yaml.h>

#include <fstream>
#include <map>

#include "eval/metrics/metrics_json.h"
#include "eval/result/run_files.h"
#include "eval/result/table_file.h"

namespace slammot {
namespace {

using Path = std::filesystem::path;

template <int N>
Eigen::Matrix<double, N, N> from_upper_triangle(const Path& file, const TableRow& row,
                                                size_t first) {
  Eigen::Matrix<double, N, N> m;
  for (int i = 0; i < N; ++i) {
    for (int j = i; j < N; ++j) m(i, j) = m(j, i) = real_field(file, row, first++, true);
  }
  return m;
}

Eigen::Vector3d vector_at(const Path& file, const TableRow& row, size_t first, bool nan_allowed) {
  return {real_field(file, row, first, nan_allowed), real_field(file, row, first + 1, nan_allowed),
          real_field(file, row, first + 2, nan_allowed)};
}

Label label_at(const Path& file, const TableRow& row, size_t field) {
  for (const Label label : {Label::kUnknown, Label::kStatic, Label::kMoving}) {
    if (row.fields[field] == to_string(label)) return label;
  }
  throw InputError(file, row.line, "'" + row.fields[field] + "' is not a label");
}

std::vector<CameraEstimate> read_trajectory(const Path& file) {
  std::vector<CameraEstimate> cameras;
  for (const TableRow& row : read_table(file, ' ', 8, false)) {
    CameraEstimate camera;
    camera.timestamp = real_field(file, row, 0);
    camera.state.position = vector_at(file, row, 1, false);
    const Eigen::Vector3d im = vector_at(file, row, 4, false);
    camera.state.orientation = Eigen::Quaterniond(real_field(file, row, 7), im.x(), im.y(), im.z());
    const double norm = camera.state.orientation.norm();
    if (!(std::abs(norm - 1.0) < 1e-2)) {
      throw InputError(file, row.line, "the quaternion is not of unit length");
    }
    camera.state.orientation.normalize();
    camera.covariance.setConstant(kUndefined);
    if (!cameras.empty() && camera.timestamp <= cameras.back().timestamp) {
      throw InputError(file, row.line, "timestamps do not increase");
    }
    cameras.push_back(camera);
  }
  if (cameras.empty()) throw InputError(file, 0, "holds no pose");
  return cameras;
}

void read_covariances(const Path& file, std::vector<CameraEstimate>& cameras) {
  if (!std::filesystem::exists(file)) return;
  const std::vector<TableRow> rows = read_table(file, ',', 22, true);
  if (rows.size() != cameras.size()) throw InputError(file, 0, "has not one row for each pose");
  for (size_t i = 0; i < rows.size(); ++i) {
    if (std::abs(real_field(file, rows[i], 0) - cameras[i].timestamp) > 1e-6) {
      throw InputError(file, rows[i].line, "the timestamp is not that of the pose");
    }
    cameras[i].covariance.topLeftCorner<6, 6>() = from_upper_triangle<6>(file, rows[i], 1);
  }
}

}  // namespace

std::vector<LandmarkRecord> read_landmark_rows(const Path& file) {
  std::vector<LandmarkRecord> records;
  if (!std::filesystem::exists(file)) return records;
  for (const TableRow& row : read_table(file, ',', 21, true)) {
    LandmarkRecord record;
    record.estimate.track = integer_field(file, row, 0);
    record.frame = integer_field(file, row, 1);
    record.estimate.label = label_at(file, row, 2);
    record.estimate.position = vector_at(file, row, 3, true);
    record.estimate.velocity = vector_at(file, row, 6, true);
    record.estimate.position_covariance = from_upper_triangle<3>(file, row, 9);
    record.estimate.velocity_covariance = from_upper_triangle<3>(file, row, 15);
    records.push_back(record);
  }
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
  if (!std::filesystem::exists(file)) return records;
  for (const TableRow& row : read_table(file, ',', 5, true)) {
    ClassificationRecord record;
    record.track = integer_field(file, row, 0);
    if (row.fields[1] != "-") record.truth = label_at(file, row, 1);
    record.label = label_at(file, row, 2);
    if (!row.fields[3].empty()) record.decision_frame = integer_field(file, row, 3);
    record.observations = integer_field(file, row, 4);
    records.push_back(record);
  }
  return records;
}

std::vector<StageTime> read_timing(const Path& file) {
  std::vector<StageTime> timing;
  if (!std::filesystem::exists(file)) return timing;
  for (const TableRow& row : read_table(file, ',', 4, true)) {
    timing.push_back({integer_field(file, row, 0), row.fields[1], real_field(file, row, 2),
                      integer_field(file, row, 3)});
  }
  return timing;
}

void read_metrics(const Path& file, RunResult& run) {
  if (!std::filesystem::exists(file)) return;
  std::ifstream stream(file);
  try {
    restore_totals(nlohmann::ordered_json::parse(stream), run);
  } catch (const nlohmann::json::exception& error) {
    throw InputError(file, 0, error.what());
  }
}

void read_description(const Path& file, StoredRun& stored) {
  if (!std::filesystem::exists(file)) return;
  try {
    const YAML::Node root = YAML::LoadFile(file.string());
    stored.estimator = root["estimator"].as<std::string>("");
    const YAML::Node configuration = root["configuration"];
    stored.landmark = configuration["landmark"].as<std::string>("");
    stored.gate_probability = configuration["gate.probability"].as<double>(0.95);
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
