#include "eval/output/run_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <tuple>

#include "datasets/output/output_files.h"
#include "datasets/sequence/plausible.h"
#include "datasets/text/number.h"
#include "datasets/text/yaml_map.h"
#include "eval/output/metrics_json.h"
#include "eval/output/run_files.h"
#include "eval/trajectory/trajectory_file.h"

namespace slammot {
namespace {

using Path = std::filesystem::path;

Eigen::Vector3d vector_or_nan_at(const TextTable& row, size_t first) {
  return {row.real_or_nan(first), row.real_or_nan(first + 1), row.real_or_nan(first + 2)};
}

Label label_at(const TextTable& row, size_t field) {
  for (const Label label : {Label::kUnknown, Label::kStatic, Label::kMoving}) {
    if (row.field(field) == to_string(label)) return label;
  }
  row.refuse(fmt::format("'{}' is not a label", row.field(field)));
}

Measured measured_at(const TextTable& row, size_t field) {
  for (const Measured measured : {Measured::kNot, Measured::kAccepted, Measured::kRejected}) {
    if (row.field(field) == to_string(measured)) return measured;
  }
  row.refuse(fmt::format("'{}' is neither accepted, rejected nor -", row.field(field)));
}

// The first field of a heading is no number.
bool begins_with_heading(TextTable table) {
  if (!table.next_blank_row()) return false;
  const std::string_view line = table.field(0);
  return !parse_number<double>(line.substr(0, line.find(',')));
}

// The rows of a CSV file of a run, below its comments and its heading; none without the file.
void for_each_row(const Path& file, size_t columns,
                  const std::function<void(const TextTable& row)>& visit) {
  if (!is_there(file)) return;
  const std::string text = read_text_file(file);
  TextTable table(file, text);
  table.pass_comments();
  if (begins_with_heading(table)) table.pass_line();
  for (table.pass_comments(); table.next_comma_row(columns); table.pass_comments()) visit(table);
}

// This program writes `nan` where it knows no covariance; others have no reason to.
void require_numbers(const TextTable& row) {
  for (size_t i = 1; i < row.fields(); ++i) row.real(i);
}

// All 36 numbers by rows.
Matrix6d whole_at(const TextTable& row, size_t first) {
  constexpr double kRounding = 1e-6;  // as printed with seven digits
  Matrix6d P;
  for (int i = 0; i < 36; ++i) P(i / 6, i % 6) = row.real_or_nan(first++);
  const bool is_symmetric =
      (P - P.transpose()).cwiseAbs().maxCoeff() <= kRounding * P.diagonal().cwiseAbs().maxCoeff();
  if (!P.hasNaN() && !is_symmetric) row.refuse("the 36 numbers are no symmetric matrix");
  return P;
}

constexpr size_t kTriangle = 1 + 21, kWhole = 1 + 36;  // fields with a time before them

// How many fields between commas the first row has, if it has one of these numbers; else the first.
size_t fields_of(const Path& file, std::initializer_list<size_t> known) {
  if (!is_there(file)) return *known.begin();
  const std::string text = read_text_file(file);
  TextTable table(file, text);
  table.pass_comments();
  if (begins_with_heading(table)) table.pass_line();
  table.pass_comments();
  if (!table.next_blank_row()) return *known.begin();
  size_t fields = 1;
  for (size_t i = 0; i < table.fields(); ++i) {
    fields += static_cast<size_t>(std::ranges::count(table.field(i), ','));
  }
  return std::ranges::find(known, fields) == known.end() ? *known.begin() : fields;
}

void read_covariances(const Path& file, bool own, std::vector<CameraEstimate>& cameras) {
  if (!is_there(file)) return;
  size_t count = 0;
  const size_t fields = fields_of(file, {kTriangle, kWhole});
  for_each_row(file, fields, [&](const TextTable& row) {
    if (count == cameras.size()) row.refuse("there are more rows than poses");
    CameraEstimate& camera = cameras[count++];
    if (std::abs(row.real(0) - camera.timestamp) > 1e-6) {
      row.refuse("the timestamp is not that of the pose");
    }
    camera.covariance.topLeftCorner<6, 6>() =
        fields == kWhole ? whole_at(row, 1) : symmetric_at<6>(row, 1);
    if (!own) require_numbers(row);
  });
  if (count != cameras.size()) {
    throw InputError(file, 0, fmt::format("{} rows of {} poses", count, cameras.size()));
  }
}

}  // namespace

std::vector<LandmarkRecord> read_landmark_rows(const Path& file) {
  // Velocity (3) and both covariances (6 each) may be left out; what is not stated stays NaN.
  const size_t fields = fields_of(file, {21, 6, 9, 12, 15});
  const bool moves = fields != 6 && fields != 12;
  const size_t covariance = moves ? 9 : 6;
  std::vector<LandmarkRecord> records;
  for_each_row(file, fields, [&](const TextTable& row) {
    LandmarkRecord record;
    record.estimate.track = row.count(0);
    record.frame = row.count(1);
    record.estimate.label = label_at(row, 2);
    record.estimate.position = vector_or_nan_at(row, 3);
    if (moves) record.estimate.velocity = vector_or_nan_at(row, 6);
    if (fields > 9) record.estimate.position_covariance = symmetric_at<3>(row, covariance);
    if (fields > 15) record.estimate.velocity_covariance = symmetric_at<3>(row, 15);
    records.push_back(record);
  });
  return records;
}

std::vector<PredictionRecord> read_prediction_rows(const Path& file) {
  std::vector<PredictionRecord> records;
  const size_t fields = fields_of(file, {8, 9});
  for_each_row(file, fields, [&](const TextTable& row) {
    PredictionRecord record;
    Prediction& p = record.prediction;
    record.frame = row.count(0);
    p.track = row.count(1);
    p.pixel = {row.bounded(2), row.bounded(3)};
    const double s_uu = row.real(4), s_uv = row.real(5), s_vv = row.real(6);  // may throw
    p.S << s_uu, s_uv, s_uv, s_vv;
    p.measured = measured_at(row, 7);
    if (fields > 8) p.camera = row.count(8);
    if (!(p.S(0, 0) > 0.0 && std::abs(p.S(0, 1)) < std::sqrt(p.S(0, 0)) * std::sqrt(p.S(1, 1)))) {
      row.refuse("s_uu, s_uv, s_vv are no covariance");
    }
    const auto place = [](const PredictionRecord& r) {
      return std::tuple(r.frame, r.prediction.track, r.prediction.camera);
    };
    if (!records.empty() && place(record) <= place(records.back())) {
      row.refuse("rows are not by frame, track and camera");
    }
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
    timing.push_back({row.count(0), printable(row.field(1)), row.bounded(2), row.count(3)});
  });
  return timing;
}

// Its message, without the library's name for the kind of it.
std::string reason_of(const nlohmann::json::exception& error) {
  const std::string_view what = error.what();
  return std::string(what.substr(std::min(what.find("] ") + 2, what.size())));
}

void read_metrics(const Path& file, RunResult& run) {
  if (!is_there(file)) return;
  const std::string text = read_text_file(file);
  try {
    restore_totals(nlohmann::ordered_json::parse(text), run);
  } catch (const nlohmann::json::parse_error& error) {
    const std::size_t before = std::min(error.byte > 0 ? error.byte - 1 : 0, text.size());
    const auto end = text.begin() + static_cast<std::ptrdiff_t>(before);
    throw InputError(file, 1 + static_cast<int>(std::count(text.begin(), end, '\n')),
                     "no JSON from here on");
  } catch (const nlohmann::json::exception& error) {
    throw InputError(file, 0, reason_of(error));
  }
}

void read_configuration(const Path& file, const YAML::Node& configuration, StoredRun& stored) {
  for (const auto& pair : configuration) {
    stored.configuration[pair.first.Scalar()] = pair.second.Scalar();
  }
  stored.landmark = printable(configuration["landmark"].as<std::string>(""));
  const YAML::Node gate = configuration["gate.probability"];
  stored.gate_probability = gate.as<double>(0.95);
  if (!(stored.gate_probability > 0.0 && stored.gate_probability <= 1.0)) {
    throw InputError(file, gate.Mark().line + 1, "gate.probability is no probability above 0");
  }
  const double pixel_sigma = configuration["pixel_sigma"].as<double>(0.0);  // or "sequence"
  if (pixel_sigma > 0.0) stored.pixel_sigma = pixel_sigma;
}

std::string text_at(const YAML::Node& map, const char* key) {
  const YAML::Node node = map[key];
  return node ? node.as<std::string>() : "";
}

void read_description(const Path& file, StoredRun& stored) {
  if (!is_there(file)) return;
  try {
    const YAML::Node root = load_yaml_node(file, read_text_file(file));
    if (!root.IsMap()) throw InputError(file, 1, "must be a map of keys to values");
    stored.own = text_at(root, "format") == run_files::kFormat;
    stored.estimator = printable(text_at(root, "estimator"));
    if (const std::string words = text_at(root, "error_convention"); !words.empty()) {
      stored.convention = parse_error_convention(words);
    }
    if (const YAML::Node configuration = root["configuration"];
        configuration && configuration.IsMap()) {
      read_configuration(file, configuration, stored);
    }
    if (const YAML::Node keys = root["from_sequence"]; keys && keys.IsSequence()) {
      stored.from_sequence = keys.as<std::vector<std::string>>();
    }
    if (const YAML::Node sequence = root["sequence"]; sequence && sequence.IsMap()) {
      const std::string path = text_at(sequence, "path");
      if (!path.empty()) stored.sequence = path;
      stored.sequence_sha256 = text_at(sequence, "sha256");
    }
  } catch (const YAML::Exception& error) {
    throw InputError(file, error.mark.line + 1, error.msg);
  } catch (const std::invalid_argument& error) {
    throw InputError(file, 0, error.what());
  }
}

}  // namespace

StoredRun read_run(const Path& folder) {
  require_whole(folder);
  StoredRun stored;
  RunResult& run = stored.run;
  read_description(folder / run_files::kDescription, stored);
  run.filtered = read_tum(folder / run_files::kTrajectory);
  read_covariances(folder / run_files::kPoseCovariance, stored.own, run.filtered);
  if (is_there(folder / run_files::kTrajectorySmoothed)) {
    run.smoothed = read_tum(folder / run_files::kTrajectorySmoothed);
    read_covariances(folder / run_files::kPoseCovarianceSmoothed, stored.own, run.smoothed);
  }
  if (stored.own && is_there(folder / run_files::kTrajectoryLastScale)) {
    run.last_scale = read_tum(folder / run_files::kTrajectoryLastScale);
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
