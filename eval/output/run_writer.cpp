#include "eval/output/run_writer.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>

#include "datasets/output/output_files.h"
#include "eval/configuration/preset.h"
#include "eval/configuration/registry.h"
#include "eval/output/in_force.h"
#include "eval/output/metrics_json.h"
#include "eval/output/run_files.h"

namespace slammot {
namespace {

using Path = std::filesystem::path;

// 17 significant digits read back to the same double; `nan` has no sign.
std::string text(double value) { return std::isnan(value) ? "nan" : fmt::format("{:.17g}", value); }

template <typename Vector>
std::string joined(const Vector& values, const char* separator) {
  std::string line;
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    if (i > 0) line += separator;
    line += text(values[i]);
  }
  return line;
}

template <typename Matrix>
std::string upper_triangle(const Matrix& m) {
  std::string line;
  for (Eigen::Index row = 0; row < m.rows(); ++row) {
    for (Eigen::Index col = row; col < m.cols(); ++col) {
      line += ',';
      line += text(m(row, col));
    }
  }
  return line;
}

std::string triangle_head(const std::string& prefix, int size) {
  std::string line;
  for (int row = 1; row <= size; ++row) {
    for (int col = row; col <= size; ++col) line += fmt::format(",{}{}{}", prefix, row, col);
  }
  return line;
}

void write_trajectory(std::ostream& out, const std::vector<CameraEstimate>& cameras,
                      const char* which) {
  out << "# " << which << " camera: timestamp tx ty tz qx qy qz qw, T_WC [s, m]\n";
  for (const CameraEstimate& camera : cameras) {
    const Eigen::Vector4d q = camera.state.orientation.coeffs();  // x y z w
    out << text(camera.timestamp) << ' ' << joined(camera.state.position, " ") << ' '
        << joined(q, " ") << '\n';
  }
}

void write_covariances(std::ostream& out, const std::vector<CameraEstimate>& cameras) {
  out << "# covariance of the error [dr (W) m, dtheta (C, right: R_true = R_est Exp(dtheta)) rad]\n"
      << "timestamp" << triangle_head("p", 6) << '\n';
  for (const CameraEstimate& camera : cameras) {
    out << text(camera.timestamp) << upper_triangle(camera.covariance.topLeftCorner<6, 6>())
        << '\n';
  }
}

void write_landmarks(std::ostream& out, const std::vector<LandmarkRecord>& landmarks) {
  out << "# estimates after `frame`, W [m, m/s]; covariances of true minus estimated; nan: not "
         "defined\n"
      << "track,frame,label,x,y,z,vx,vy,vz" << triangle_head("p", 3) << triangle_head("v", 3)
      << '\n';
  for (const LandmarkRecord& record : landmarks) {
    const LandmarkEstimate& e = record.estimate;
    out << e.track << ',' << record.frame << ',' << to_string(e.label) << ','
        << joined(e.position, ",") << ',' << joined(e.velocity, ",")
        << upper_triangle(e.position_covariance) << upper_triangle(e.velocity_covariance) << '\n';
  }
}

void write_predictions(std::ostream& out, const std::vector<PredictionRecord>& predictions) {
  const bool is_of_rig =
      std::ranges::any_of(predictions, [](const auto& p) { return p.prediction.camera > 0; });
  out << "# landmarks expected in the image before the measurements of `frame` were used [px], and "
         "the\n"
      << "# covariance of their innovation, the measurement's noise included [px^2]; measured: "
         "what "
         "the gate\n"
      << "# said, - without a measurement\n"
      << "frame,track,u,v,s_uu,s_uv,s_vv,measured" << (is_of_rig ? ",camera\n" : "\n");
  for (const auto& [frame, p] : predictions) {
    out << frame << ',' << p.track << ',' << joined(p.pixel, ",") << upper_triangle(p.S) << ','
        << to_string(p.measured);
    if (is_of_rig) out << ',' << p.camera;
    out << '\n';
  }
}

void write_classification(std::ostream& out, const std::vector<ClassificationRecord>& records) {
  out << "# landmarks that had to be classified: not those known beforehand or static by rule;\n"
      << "# observations: used until the decision, or in all where there is none\n"
      << "track,truth,label,frame,observations\n";
  for (const ClassificationRecord& r : records) {
    out << r.track << ',' << (r.truth ? to_string(*r.truth) : "-") << ',' << to_string(r.label)
        << ',' << (r.decision_frame ? std::to_string(*r.decision_frame) : "") << ','
        << r.observations << '\n';
  }
}

void write_timing(std::ostream& out, const std::vector<StageTime>& timing) {
  out << "frame,stage,milliseconds,state_size\n";
  for (const StageTime& t : timing) {
    out << t.frame << ',' << t.stage << ',' << text(t.milliseconds) << ',' << t.state_size << '\n';
  }
}

void write_provenance(YAML::Emitter& yaml, const Provenance& made_by) {
  yaml << YAML::Key << "provenance" << YAML::Value << YAML::BeginMap;
  const Json json = json_of(made_by);
  for (const auto& [key, value] : json.items()) {
    yaml << YAML::Key << key << YAML::Value
         << (value.is_string() ? value.get<std::string>() : value.dump());
  }
  yaml << YAML::EndMap;
}

void write_in_force(YAML::Emitter& yaml, const InForce& in_force) {
  yaml << YAML::Key << "in_force" << YAML::Value << YAML::BeginSeq;
  for (const Json& mechanism : json_of(in_force)) {
    yaml << YAML::Flow << YAML::BeginMap;
    for (const auto& [key, value] : mechanism.items()) {
      yaml << YAML::Key << key << YAML::Value
           << (value.is_string() ? value.get<std::string>() : value.dump());
    }
    yaml << YAML::EndMap;
  }
  yaml << YAML::EndSeq;
}

void write_left_open(YAML::Emitter& yaml, const Configuration& configuration) {
  const auto open = left_open_by_the_thesis(configuration);
  if (open.empty()) return;
  yaml << YAML::Key << "left_open_by_the_thesis" << YAML::Value << YAML::BeginMap;
  for (const auto& [key, how] : open) yaml << YAML::Key << key << YAML::Value << how;
  yaml << YAML::EndMap;
}

void write_description(std::ostream& out, const RunDescription& d,
                       const std::optional<InForce>& in_force) {
  const Path sequence = d.sequence.empty() ? d.sequence : std::filesystem::absolute(d.sequence);
  YAML::Emitter yaml;
  yaml << YAML::BeginMap << YAML::Key << "format" << YAML::Value << run_files::kFormat;
  yaml << YAML::Key << "version" << YAML::Value << SLAMMOT_VERSION;
  yaml << YAML::Key << "command" << YAML::Value << d.command;
  yaml << YAML::Key << "estimator" << YAML::Value << d.estimator;
  if (const std::string sha256 = estimator_sha256(d.estimator); !sha256.empty()) {
    yaml << YAML::Key << "estimator_sha256" << YAML::Value << sha256;
  }
  yaml << YAML::Key << "sequence" << YAML::Value << YAML::BeginMap;
  yaml << YAML::Key << "name" << YAML::Value << d.sequence_name;
  yaml << YAML::Key << "path" << YAML::Value << sequence.lexically_normal().string();
  yaml << YAML::Key << "sha256" << YAML::Value << d.sequence_sha256 << YAML::EndMap;
  if (d.seed) yaml << YAML::Key << "seed" << YAML::Value << *d.seed;
  write_provenance(yaml, d.made_by);
  yaml << YAML::Key << "configuration" << YAML::Value << YAML::BeginMap;
  for (const auto& [key, value] : key_values(d.configuration)) {
    yaml << YAML::Key << key << YAML::Value << value;
  }
  yaml << YAML::EndMap;
  yaml << YAML::Key << "from_sequence" << YAML::Value << YAML::Flow << d.from_sequence;
  write_left_open(yaml, d.configuration);
  if (in_force) write_in_force(yaml, *in_force);
  yaml << YAML::EndMap;
  out << yaml.c_str() << '\n';
}

void add_results(OutputFiles& files, const Path& folder, const RunResult& run,
                 const Json& metrics) {
  const auto write = [&](const char* name, const std::function<void(std::ostream&)>& content) {
    files.write(folder / name, content);
  };
  using Out = std::ostream&;
  write(run_files::kTrajectory, [&](Out out) { write_trajectory(out, run.filtered, "filtered"); });
  write(run_files::kPoseCovariance, [&](Out out) { write_covariances(out, run.filtered); });
  if (run.smoothed.empty()) {
    // A folder may hold an older run, of an estimator that smooths.
    files.leave_out(folder / run_files::kTrajectorySmoothed);
    files.leave_out(folder / run_files::kPoseCovarianceSmoothed);
  } else {
    write(run_files::kTrajectorySmoothed,
          [&](Out out) { write_trajectory(out, run.smoothed, "smoothed"); });
    write(run_files::kPoseCovarianceSmoothed,
          [&](Out out) { write_covariances(out, run.smoothed); });
  }
  if (run.last_scale.empty()) {
    files.leave_out(folder / run_files::kTrajectoryLastScale);
  } else {
    write(run_files::kTrajectoryLastScale,
          [&](Out out) { write_trajectory(out, run.last_scale, "in the last scale"); });
  }
  const auto& landmarks = run.every_frame.empty() ? run.landmarks : run.every_frame;
  write(run_files::kLandmarks, [&](Out out) { write_landmarks(out, landmarks); });
  if (run.predictions.empty()) {
    files.leave_out(folder / run_files::kPredictions);
  } else {
    write(run_files::kPredictions, [&](Out out) { write_predictions(out, run.predictions); });
  }
  write(run_files::kClassification,
        [&](Out out) { write_classification(out, run.classification); });
  write(run_files::kTiming, [&](Out out) { write_timing(out, run.timing); });
  write(run_files::kMetrics, [&](Out out) { out << metrics.dump(1) << '\n'; });
}

}  // namespace

void write_run(const Path& folder, const RunDescription& description, const RunResult& run,
               const RunMetrics& metrics) {
  std::filesystem::create_directories(folder);
  OutputFiles files;
  files.write(folder / run_files::kDescription,
              [&](std::ostream& out) { write_description(out, description, run.in_force); });
  Json json = metrics_json(metrics);
  json["provenance"] = json_of(description.made_by);
  add_results(files, folder, run, json);
  files.put_in_place();
}

void write_results(const Path& folder, const RunResult& run, const RunMetrics& metrics) {
  std::filesystem::create_directories(folder);
  OutputFiles files;
  add_results(files, folder, run, metrics_json(metrics));
  files.put_in_place();
}

}  // namespace slammot
