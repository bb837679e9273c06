// Reads a run folder back, also one made elsewhere: `trajectory.tum` is enough. `run.yaml` may hold
// no more than `estimator: NAME`.
//
// Without pose_covariance.csv the covariances are NaN (no NEES); without the other files there are
// no landmarks, classification or timing. Throws InputError with file, line and reason.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "datasets/sequence/sequence.h"
#include "eval/result/run_result.h"
#include "eval/trajectory/error_convention.h"

namespace slammot {

struct StoredRun {
  std::string estimator;                      // empty where run.yaml is missing
  std::string landmark;                       // its landmark model, likewise
  bool own = false;                           // run.yaml is in the format of this program
  std::optional<ErrorConvention> convention;  // that run.yaml states, as others' may
  std::map<std::string, std::string> configuration;
  std::vector<std::string> from_sequence;         // its keys whose value the sequence decided
  std::optional<std::filesystem::path> sequence;  // that it was made from
  std::string sequence_sha256;                    // its content, likewise
  double gate_probability = 0.95;
  std::optional<double> pixel_sigma;  // [px], that it was made with
  RunResult run;
};

StoredRun read_run(const std::filesystem::path& folder);

// All rows of a landmarks.csv, in their order; none if there is no such file.
std::vector<LandmarkRecord> read_landmark_rows(const std::filesystem::path& file);
// Of a predictions.csv likewise; read_run() leaves them, only pictures need them.
std::vector<PredictionRecord> read_prediction_rows(const std::filesystem::path& file);

}  // namespace slammot
