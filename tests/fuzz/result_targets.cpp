// The readers of configurations, studies, journals, runs, and trajectories of other programs.
#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <fstream>

#include "datasets/output/output_folder.h"
#include "eval/configuration/configuration.h"
#include "eval/journal/journal.h"
#include "eval/output/run_reader.h"
#include "eval/study/study_run.h"
#include "eval/study/study_store.h"
#include "eval/trajectory/trajectory_file.h"
#include "tests/fuzz/target.h"

namespace slammot::fuzz {
namespace {

using Path = std::filesystem::path;

void read_configuration(const Path& folder) {
  Configuration configuration;
  load_configuration(configuration, folder / "configuration.yaml");
}

void read_study_file(const Path& folder) { parse_study(folder / "study.yaml"); }

void read_journal(const Path& folder) {
  std::map<RunKey, RunPlace> places;
  add_journals(folder, {{"0.1.0", "p", "c"}, 4, false}, places);
}

// The runs of a study, merged.
void read_study_results(const Path& folder) {
  const Study study = parse_study(folder / "study.yaml");
  merge_runs(study, {folder}, folder, true);
}

void require_poses(const std::vector<CameraEstimate>& cameras) {
  for (const auto& [timestamp, state, covariance] : cameras) {
    require(state.position.allFinite() && state.orientation.coeffs().allFinite(), "a pose");
    require(std::isfinite(timestamp), "a time");
  }
}

void read_foreign_trajectory(const Path& folder) {
  std::vector<Frame> frames(2);
  frames[1].timestamp = 0.1;
  require_poses(read_trajectory(folder / "trajectory.txt", frames));
}

void read_run_folder(const Path& folder) {
  const StoredRun stored = read_run(folder);
  require(stored.gate_probability > 0.0 && stored.gate_probability <= 1.0, "the gate");
  require_poses(stored.run.filtered);
}

void read_predictions(const Path& folder) {
  for (const auto& [frame, p] : read_prediction_rows(folder / "predictions.csv")) {
    require(p.pixel.allFinite() && p.S.allFinite(), "a prediction");
  }
}

Files configuration() {
  return {{"configuration.yaml",
           "landmark: scaled_velocity\nwindow: {frames: 5, solver: own}\ngate.probability: 0.95\n"
           "classifier: {name: odds, static_threshold: 1.6}\nprior.inverse_depth: sequence\n"}};
}

Files study() {
  return {{"study.yaml",
           "format: slammot-study-1\nname: small\ntitle: \"A title\"\nruns: 4\nseed: 1\n"
           "scenarios:\n  - {scenario: helix, set: {frames: 24}}\n"
           "estimators:\n  - {estimator: window, label: window 3, set: {window.frames: 3}}\n"
           "configuration: {gate.probability: 0.95}\n"
           "sweep: {classifier.static_threshold: [0.8, 1.6], scenario.noise: [1, 2]}\n"
           "record: {tracks: [1, 2]}\nfigures: [camera_error]\n"
           "reference: {label: thesis, static: [1, 2, 3], moving: [1, 2, 3]}\n"}};
}

Files journal() {
  return {{"journal-1-of-1.jsonl",
           "{\"journal\":{\"format\":\"slammot-journal-1\",\"version\":\"0.1.0\",\"program\":"
           "\"p\",\"configuration\":\"c\"}}\n{\"result\":{\"cell\":0,\"seed\":1,\"diverged\":null},"
           "\"timing\":{\"cell\":0,\"seed\":1}}\n"}};
}

// Numbers with `digits`: the same text on every machine, so that a mutation that does harm does it
// everywhere.
nlohmann::ordered_json rounded(nlohmann::ordered_json json, int digits) {
  if (json.is_number_float()) return std::stod(fmt::format("{:.{}g}", json.get<double>(), digits));
  if (!json.is_structured()) return json;
  for (auto& element : json) element = rounded(element, digits);
  return json;
}

// Every duration as 1 ms or 1 s.
nlohmann::ordered_json without_clock(nlohmann::ordered_json timing) {
  if (timing.is_number_float()) return 1.0;
  if (!timing.is_structured()) return timing;
  for (auto& element : timing) element = without_clock(element);
  return timing;
}

// A study of one run, which is made here.
Files study_results() {
  static const Files files = [] {
    const Path folder = std::filesystem::temp_directory_path();
    const Path file = folder / fmt::format("slammot-fuzz-{}.yaml", ::getpid());
    const std::string text = std::string(kStudyOutput.begins) +
                             "format: slammot-study-1\nname: small\nruns: 1\n"
                             "scenarios:\n  - {scenario: circle, set: {frames: 4}}\n"
                             "estimators: [{estimator: ekf}]\n";
    std::ofstream(file) << text;
    const Study study = parse_study(file);
    std::filesystem::remove(file);
    const StudyRun run = run_study_cell(study, 0, 0, {});
    const nlohmann::ordered_json head = {
        {"journal",
         {{"version", ""}, {"program", ""}, {"configuration", identity_of(study).configuration}}}};
    const nlohmann::ordered_json line = {{"result", rounded(run.result, 5)},
                                         {"timing", without_clock(run.timing)}};
    return Files{{"study.yaml", text},
                 {"journal-1-of-1.jsonl", head.dump() + '\n' + line.dump() + '\n'}};
  }();
  return files;
}

Files kitti_trajectory() {
  return {{"trajectory.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0.5 0 1 0 0 0 0 1 2\n"}};
}

Files euroc_trajectory() {
  return {{"trajectory.txt",
           "#timestamp, p_RS_R_x [m]\n0,0,0,0,1,0,0,0\n100000000,1,0,0,0.8,0,0,0.6\n"}};
}

Files ov_eval_trajectory() {
  return {
      {"trajectory.txt",
       "# timestamp(s) tx ty tz qx qy qz qw Pr11 Pr12 Pr13 Pr22 Pr23 Pr33 Pt11 ..\n"
       "0 0 0 0 0 0 0 1 1 0 0 1 0 1 1 0 0 1 0 1\n0.1 1 0 0 0 0 0.6 0.8 1 0 0 1 0 1 1 0 0 1 0 1\n"}};
}

std::string zeros(int count) {
  std::string text;
  for (int i = 0; i < count; ++i) text += i % 7 == 0 ? ",1" : ",0";
  return text;
}

Files run() {
  return {{"run.yaml",
           "format: slammot-run-1\nestimator: ekf\nsequence: {name: a, path: /a, sha256: 0}\n"
           "configuration:\n  landmark: scaled_velocity\n  gate.probability: 0.95\n"
           "  pixel_sigma: 1\n"},
          {"trajectory.tum", "# camera\n0 0 0 0 0 0 0 1\n0.1 1 0 0 0 0 0.6 0.8\n"},
          {"pose_covariance.csv", "# c\ntimestamp,p11\n0" + zeros(21) + "\n0.1" + zeros(21) + "\n"},
          {"landmarks.csv", "track,frame\n3,1,static,1,2,3,0,0,0" + zeros(12) + "\n"},
          {"predictions.csv",
           "# p\nframe,track,u,v,s_uu,s_uv,s_vv,measured\n0,3,10,20.5,2,0.5,1,accepted\n"
           "1,3,11,20.5,2,-0.5,1,-\n1,4,11,2,2,0,1,rejected\n"},
          {"classification.csv", "track,truth\n3,static,static,1,2\n4,-,unknown,,7\n"},
          {"timing.csv", "frame,stage,milliseconds,state_size\n0,predict,0.1,13\n"},
          {"metrics.json",
           "{\"coverage\": {\"frames_offered\": 2, \"frames_done\": 2, \"measurements_offered\": "
           "4, \"accepted\": 3, \"rejected\": 1, \"out_of_view\": 0, \"landmarks_admitted\": 2, "
           "\"landmarks_lost\": 0, \"negative_inverse_depths\": 0}, \"nis\": {\"mean\": 1.9, "
           "\"joint_mean\": 2.0}, \"warnings\": [], "
           "\"runtime\": {\"smoothing_ms\": 0.5}, \"divergence\": {\"frame\": 1, \"reason\": "
           "\"not a number\"}}\n"}};
}

constexpr Target kTargets[] = {
    {"configuration", configuration, "configuration.yaml", read_configuration},
    {"study", study, "study.yaml", read_study_file},
    {"journal", journal, "journal-1-of-1.jsonl", read_journal},
    {"study_results", study_results, "journal-1-of-1.jsonl", read_study_results},
    {"kitti_trajectory", kitti_trajectory, "trajectory.txt", read_foreign_trajectory},
    {"euroc_trajectory", euroc_trajectory, "trajectory.txt", read_foreign_trajectory},
    {"ov_eval_trajectory", ov_eval_trajectory, "trajectory.txt", read_foreign_trajectory},
    {"run_description", run, "run.yaml", read_run_folder},
    {"run_trajectory", run, "trajectory.tum", read_run_folder},
    {"run_covariances", run, "pose_covariance.csv", read_run_folder},
    {"run_landmarks", run, "landmarks.csv", read_run_folder},
    {"run_predictions", run, "predictions.csv", read_predictions},
    {"run_classification", run, "classification.csv", read_run_folder},
    {"run_timing", run, "timing.csv", read_run_folder},
    {"run_metrics", run, "metrics.json", read_run_folder},
};

}  // namespace

std::span<const Target> result_targets() { return kTargets; }

}  // namespace slammot::fuzz
