// Runs one estimator over one sequence, and evaluates the run.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "datasets/sequence/sequence.h"
#include "estimation/rotation_span.h"
#include "eval/configuration/configuration.h"
#include "eval/metrics/metrics.h"
#include "eval/result/run_result.h"
#include "eval/run/scale_check.h"

namespace slammot {

// The rotation of these cameras beside another estimate from the same tracks; a front end has one.
using CheckRotation = std::function<std::vector<RotationSpan>(
    const Sequence& sequence, const std::vector<CameraEstimate>& cameras, double pixel_sigma)>;

struct DriveOptions {
  std::function<void(int done, int total)> progress;  // after each frame; may be empty
  bool landmarks_every_frame = false;
  bool predictions = false;      // of every frame, see Estimator::keep_predictions()
  CheckRotation check_rotation;  // of what is judged; may be empty
  // Of the registry's estimators these are known.
  bool batch = false;                      // see RunResult
  std::optional<double> pixel_sigma = {};  // of the estimator; that of the sequence, if empty
  std::optional<StatedScale> scale = {};   // whose scale is asked about
};

// Gives all frames of the sequence to the estimator. Divergence ends the run, whether the estimator
// says so or a number of the camera is not finite, and what was finished before is kept.
RunResult drive(const Sequence& sequence, Estimator& estimator, const DriveOptions& options = {});

struct EvaluatedRun {
  Configuration configuration;             // as the estimator used it, every value resolved
  std::vector<std::string> from_sequence;  // keys whose value was not given
  RunResult run;
  RunMetrics metrics;
};

// The estimator of that name in the registry, as the configuration says: found, set up, run and
// evaluated. The sequence is taken as it is: `frames.*` are applied beforehand, by select_frames().
EvaluatedRun run_and_evaluate(const Sequence& sequence, const Configuration& configuration,
                              const std::string& estimator, const DriveOptions& options = {},
                              const MetricTable& table = metric_table());

// The run alone.
RunResult run_estimator(const Sequence& sequence, const Configuration& configuration,
                        const std::string& estimator, const DriveOptions& options = {});

// See warning_about(), of the estimator's setup.
std::optional<std::string> warning_about(const Sequence& sequence,
                                         const Configuration& configuration,
                                         const std::string& estimator);

// The configuration as this estimator uses it, every value resolved: what run.yaml states.
Configuration effective_configuration(const Sequence& sequence, const Configuration& configuration,
                                      const std::string& estimator);

}  // namespace slammot
