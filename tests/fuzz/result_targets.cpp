// The readers of configurations, studies, journals and runs.
#include <cmath>
#include <stdexcept>

#include "eval/configuration/configuration.h"
#include "eval/journal/journal.h"
#include "eval/output/run_reader.h"
#include "eval/study/study.h"
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

void read_run_folder(const Path& folder) {
  const StoredRun stored = read_run(folder);
  if (!(stored.gate_probability > 0.0 && stored.gate_probability <= 1.0)) {
    throw std::logic_error("the gate's probability");
  }
  for (const CameraEstimate& camera : stored.run.filtered) {
    if (!camera.state.position.allFinite() || !std::isfinite(camera.timestamp)) {
      throw std::logic_error("a pose");
    }
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
           "\"p\",\"configuration\":\"c\"}}\n{\"result\":{\"cell\":0,\"seed\":1},\"timing\":"
           "{\"cell\":0,\"seed\":1}}\n"}};
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
    {"run_description", run, "run.yaml", read_run_folder},
    {"run_trajectory", run, "trajectory.tum", read_run_folder},
    {"run_covariances", run, "pose_covariance.csv", read_run_folder},
    {"run_landmarks", run, "landmarks.csv", read_run_folder},
    {"run_classification", run, "classification.csv", read_run_folder},
    {"run_timing", run, "timing.csv", read_run_folder},
    {"run_metrics", run, "metrics.json", read_run_folder},
};

}  // namespace

std::span<const Target> result_targets() { return kTargets; }

}  // namespace slammot::fuzz
