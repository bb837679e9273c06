#include "eval/run/run.h"

#include <algorithm>

#include "eval/configuration/registry.h"
#include "eval/configuration/setup.h"
#include "eval/run/landmark_history.h"
#include "eval/run/ray_spread.h"
#include "eval/run/self_check.h"
#include "eval/run/stage_clock.h"
#include "eval/trajectory/last_scale.h"

namespace slammot {
namespace {

// A camera farther away will overflow: its squares are no numbers any more.
constexpr double kNowhere = 1e9;  // [m]

void require_finite(const CameraState& x) {
  if (!x.position.allFinite() || !x.orientation.coeffs().allFinite() || !x.velocity.allFinite() ||
      !x.angular_velocity.allFinite()) {
    throw Diverged("the camera's state is not a number");
  }
  if (x.position.norm() > kNowhere) throw Diverged("the camera is a million kilometres away");
}

// Of the pose, and of the velocities: NaN throughout is a covariance that is not stated.
void require_finite_or_unknown(const Matrix12d& covariance) {
  for (const int part : {0, 6}) {
    const Matrix6d block = covariance.block<6, 6>(part, part);
    if (block.allFinite() || block.array().isNaN().all()) continue;
    throw Diverged("the camera's covariance is not a number");
  }
}

FrameCounts counts_of(const FrameReport& report) {
  return {.accepted = report.accepted,
          .accepted_static = report.accepted_static,
          .rejected = report.rejected,
          .out_of_view = report.out_of_view,
          .admitted = report.admitted,
          .pruned = static_cast<int>(report.retired.size()),
          .negative_inverse_depth = report.negative_inverse_depth,
          .state_size = report.state_size,
          .nis_sum = report.nis_sum,
          .joint_nis = report.joint_nis,
          .lasting_sums = report.lasting_sums,
          .lasting_nis = report.lasting_nis};
}

void add_to(FrameCounts& totals, const FrameCounts& counts) {
  totals.accepted += counts.accepted;
  totals.accepted_static += counts.accepted_static;
  totals.rejected += counts.rejected;
  totals.out_of_view += counts.out_of_view;
  totals.admitted += counts.admitted;
  totals.pruned += counts.pruned;
  totals.negative_inverse_depth += counts.negative_inverse_depth;
  totals.state_size = std::max(totals.state_size, counts.state_size);
  totals.nis_sum += counts.nis_sum;
  totals.joint_nis += counts.joint_nis;
  totals.lasting_sums += counts.lasting_sums;
  totals.lasting_nis += counts.lasting_nis;
}

void add_scale(double information, RunResult& result) {
  result.scale_information.push_back(information);
  ScaleInformation& scale = result.scale;
  if (result.frames.size() == 1) scale.stated = scale.largest = information;
  scale.largest = std::max(scale.largest, information);
  scale.last = information;
}

void add_timing(StageClock& clock, int frame, int state_size, RunResult& result) {
  for (auto& [stage, milliseconds] : clock.finish()) {
    result.timing.push_back({frame, std::move(stage), milliseconds, state_size});
  }
}

// What is no longer kept is left out. Not in the frame's time: nobody else asks.
void add_lagged(const Estimator& estimator, RunResult& result) {
  for (const int lag : kLags) {
    const auto pose = estimator.pose_before(lag);
    if (!pose) return;
    const auto before = result.filtered.size() - 1 - static_cast<std::size_t>(lag);
    CameraEstimate camera = result.filtered[before];
    camera.state.position = pose->position;
    camera.state.orientation = pose->orientation;
    camera.covariance.setConstant(kUndefined);
    camera.covariance.topLeftCorner<6, 6>() = pose->covariance;
    result.lagged[lag].push_back(camera);
  }
}

double sigma_of(const Sequence& sequence, const DriveOptions& options) {
  return options.pixel_sigma.value_or(sequence.pixel_sigma);
}

void drive_frame(const Sequence& sequence, const Frame& frame, Estimator& estimator,
                 const DriveOptions& options, LandmarkHistory& history, RunResult& result) {
  StageClock clock;
  const FrameReport report = estimator.process(frame, clock);
  const CameraEstimate camera = estimator.camera();  // its covariance is part of the frame's cost
  add_timing(clock, frame.index, report.state_size, result);
  require_finite(camera.state);
  require_finite_or_unknown(camera.covariance);
  result.frames.push_back(frame.index);
  result.filtered.push_back(camera);
  add_lagged(estimator, result);
  result.counts.push_back(counts_of(report));
  add_scale(report.scale_information, result);
  result.scale_changes.push_back(report.scale_change);
  add_to(result.totals, result.counts.back());
  for (const Prediction& prediction : report.predictions) {
    result.predictions.push_back({frame.index, prediction});
  }
  history.retire(frame.index, report.retired);  // before a track may begin anew
  const std::vector<LandmarkEstimate> measured = estimator.landmarks_measured(frame.index);
  result.ray_spread.push_back(
      ray_spread(sequence.camera, sigma_of(sequence, options), frame, measured));
  history.add(frame.index, measured);
  if (!options.landmarks_every_frame) return;
  for (const LandmarkEstimate& landmark : estimator.landmarks()) {
    result.every_frame.push_back({frame.index, landmark});
  }
}

// The final estimate of every landmark still in the state. A batch solves here, so that its
// landmarks are known better than after the last frame.
void smooth(Estimator& estimator, LandmarkHistory& history, RunResult& result) {
  StageClock clock;
  const std::vector<CameraEstimate> smoothed = estimator.smoothed(clock);
  result.smoothing_ms = clock.finish().back().second;
  // A covariance may be undefined here: a window knows none of the frames that have left it.
  for (const CameraEstimate& camera : smoothed) require_finite(camera.state);
  result.smoothed = smoothed;
  if (!result.frames.empty()) history.revise(result.frames.back(), estimator.landmarks());
}

}  // namespace

RunResult drive(const Sequence& sequence, Estimator& estimator, const DriveOptions& options) {
  RunResult result;
  result.batch = options.batch;
  result.frames_offered = static_cast<int>(sequence.frames.size());
  LandmarkHistory history(sequence);
  if (options.predictions) estimator.keep_predictions();
  int frame_index = 0;
  try {
    for (const Frame& frame : sequence.frames) {
      frame_index = frame.index;
      drive_frame(sequence, frame, estimator, options, history, result);
      const int done = static_cast<int>(result.frames.size());
      if (options.progress) options.progress(done, result.frames_offered);
    }
    smooth(estimator, history, result);
  } catch (const Diverged& diverged) {
    result.diverged = {frame_index, diverged.what()};
  }
  // A batch is judged by what it solves at once, in one scale.
  if (!options.batch) result.last_scale = in_last_scale(result.filtered, result.scale_changes);
  result.in_force = estimator.in_force();
  result.landmarks = history.latest();
  result.classification = history.classification();
  result.samples = history.samples();
  std::vector<RotationSpan> spans;
  if (options.check_rotation)
    spans = options.check_rotation(sequence, result.judged(), sigma_of(sequence, options));
  result.warnings = self_check(result, spans, options.scale);
  for (const std::string& hint : sequence.hints) {
    result.warnings.insert(result.warnings.begin(), {std::nullopt, hint});
  }
  return result;
}

namespace {

struct Prepared {
  Configuration configuration;
  std::optional<StatedScale> scale;
  std::unique_ptr<Estimator> estimator;
};

Prepared prepare(const Sequence& sequence, Configuration configuration, const std::string& name) {
  const EstimatorRow& row = find_estimator(name);
  row.adjust(configuration);
  const Setup setup = make_setup(sequence, configuration);
  configuration = resolved(sequence, setup, std::move(configuration));
  return {configuration, stated_scale(setup), row.make(setup, configuration)};
}

DriveOptions options_of(const Prepared& prepared, const std::string& estimator,
                        DriveOptions options) {
  options.batch = is_batch(estimator);
  options.pixel_sigma = prepared.configuration.pixel_sigma;
  options.scale = prepared.scale;
  return options;
}

}  // namespace

EvaluatedRun run_and_evaluate(const Sequence& sequence, const Configuration& configuration,
                              const std::string& estimator, const DriveOptions& options,
                              const MetricTable& table) {
  const Prepared prepared = prepare(sequence, configuration, estimator);
  EvaluatedRun done;
  done.configuration = prepared.configuration;
  done.from_sequence = differing_keys(configuration, prepared.configuration);
  done.run = drive(sequence, *prepared.estimator, options_of(prepared, estimator, options));
  done.metrics =
      compute_metrics(sequence, done.run, prepared.configuration.model.gate.probability, table);
  return done;
}

RunResult run_estimator(const Sequence& sequence, const Configuration& configuration,
                        const std::string& estimator, const DriveOptions& options) {
  const Prepared prepared = prepare(sequence, configuration, estimator);
  return drive(sequence, *prepared.estimator, options_of(prepared, estimator, options));
}

std::optional<std::string> warning_about(const Sequence& sequence,
                                         const Configuration& configuration,
                                         const std::string& estimator) {
  Configuration adjusted = configuration;
  find_estimator(estimator).adjust(adjusted);
  return warning_about(make_setup(sequence, adjusted), adjusted);
}

Configuration effective_configuration(const Sequence& sequence, const Configuration& configuration,
                                      const std::string& estimator) {
  Configuration effective = configuration;
  find_estimator(estimator).adjust(effective);
  return resolve(sequence, effective);
}

}  // namespace slammot
