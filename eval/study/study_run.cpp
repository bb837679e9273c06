#include "eval/study/study_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <set>

#include "datasets/text/input_error.h"
#include "eval/configuration/setup.h"
#include "eval/output/in_force.h"
#include "eval/output/judged_frames.h"
#include "eval/output/metrics_json.h"
#include "eval/statistics/statistics.h"
#include "eval/study/study_figures.h"
#include "eval/study/study_sequence.h"

namespace slammot {
namespace {

Json counts(const ClassCounts& c) { return {c.right, c.wrong, c.undecided}; }

// Right, wrong and undecided of the landmarks of this class that were measured at least ten times,
// often enough for a decision to be fair.
Json counts_observed_ten_times(const RunResult& run, Label truth) {
  constexpr int kFewest = 10;  // measurements
  std::map<int, int> observations;
  for (const LandmarkRecord& l : run.landmarks) {
    observations[l.estimate.track] = l.estimate.observations;
  }
  ClassCounts c;
  for (const ClassificationRecord& r : run.classification) {
    if (r.truth == truth && observations[r.track] >= kFewest) c.add(r.label, truth);
  }
  return counts(c);
}

// The labels of objects that ever move, over the frames in which a measurement of theirs was used:
// of those in which they stood, or moved.
Json counts_by_frame(const std::vector<LandmarkSample>& samples, Label motion) {
  ClassCounts c;
  for (const LandmarkSample& s : samples) {
    if (s.truth == Label::kMoving && s.motion == motion) c.add(s.label, motion);
  }
  return counts(c);
}

bool depends_on_the_seed(const Metric& m) {
  return m.pooled == Pooled::kMean || m.pooled == Pooled::kRootMeanSquare;
}

bool depends_on_the_clock(const Metric& m) { return m.pooled == Pooled::kMedianTiming; }

// A window does not keep those of the cameras that left it.
bool has_covariances(const std::vector<PosePair>& pairs) {
  return !pairs.empty() && std::all_of(pairs.begin(), pairs.end(), [](const PosePair& p) {
    return p.estimate.covariance.allFinite();
  });
}

// Four digits: a box plot needs no more, and a run has thousands.
double rounded(double x) {
  if (!std::isfinite(x) || x == 0.0) return x;
  const double scale = std::pow(10.0, 3.0 - std::floor(std::log10(std::abs(x))));
  return std::round(x * scale) / scale;
}

// Without the landmarks known beforehand, which were given, not estimated.
std::vector<LandmarkSample> estimated_samples(const Sequence& sequence, const RunResult& run) {
  std::set<int> known;
  for (const KnownLandmark& k : sequence.known) known.insert(k.track);
  std::vector<LandmarkSample> samples;
  for (const LandmarkSample& s : run.samples) {
    if (!known.contains(s.track)) samples.push_back(s);
  }
  return samples;
}

// Mean and count of the NEES of the landmarks measured in each of `frames`.
void add_landmark_nees(const std::vector<LandmarkSample>& samples, const char* part,
                       double LandmarkSample::*nees_of, Json& frames) {
  struct Sum {
    double sum = 0.0, count = 0.0;
  };
  std::map<int, Sum> sums;
  for (const LandmarkSample& s : samples) {
    if (std::isnan(s.*nees_of)) continue;
    Sum& r = sums[s.frame];
    r = {r.sum + s.*nees_of, r.count + 1};
  }
  std::vector<double> means;
  std::vector<int> counts;
  for (const Json& frame : frames.at("frame")) {
    const Sum r = sums[frame.get<int>()];
    means.push_back(r.count > 0.0 ? r.sum / r.count : kUndefined);
    counts.push_back(static_cast<int>(r.count));
  }
  frames[std::string("nees_landmark_") + part] = means;
  frames[std::string("landmark_") + part + "_count"] = counts;
}

// Errors and NEES of the landmarks at the recorded ages.
Json landmarks_json(const std::vector<LandmarkSample>& samples) {
  struct Age {
    std::vector<double> statics, movings, velocities, position_nees, velocity_nees;
  };
  std::map<int, Age> ages;
  for (const LandmarkSample& s : samples) {
    const bool recorded = std::find(std::begin(kRecordedAges), std::end(kRecordedAges),
                                    s.observations) != std::end(kRecordedAges);
    if (!recorded) continue;
    Age& age = ages[s.observations];
    const bool moves = s.truth == Label::kMoving;
    if (std::isfinite(s.position_error)) {
      (moves ? age.movings : age.statics).push_back(rounded(s.position_error));
    }
    if (moves && std::isfinite(s.velocity_error))
      age.velocities.push_back(rounded(s.velocity_error));
    if (!std::isnan(s.position_nees)) age.position_nees.push_back(s.position_nees);
    if (!std::isnan(s.velocity_nees)) age.velocity_nees.push_back(s.velocity_nees);
  }
  Json json = Json::array();
  for (const auto& [observations, age] : ages) {
    json.push_back({{"observations", observations},
                    {"static_position_m", age.statics},
                    {"moving_position_m", age.movings},
                    {"moving_velocity_m_s", age.velocities},
                    {"nees_position_mean", mean(age.position_nees)},
                    {"nees_position_count", age.position_nees.size()},
                    {"nees_velocity_mean", mean(age.velocity_nees)},
                    {"nees_velocity_count", age.velocity_nees.size()}});
  }
  return json;
}

Json tracks_json(const Study& study, const Sequence& sequence, const RunResult& run) {
  Json json = Json::array();
  for (const int track : study.tracks) {
    Json one = {{"track", track},
                {"frame", Json::array()},
                {"velocity", Json::array()},
                {"sigma", Json::array()},
                {"truth", Json::array()}};
    for (const LandmarkRecord& record : run.every_frame) {
      const LandmarkEstimate& l = record.estimate;
      if (l.track != track || !l.velocity.allFinite()) continue;
      const auto truth = sequence.landmarks.find(track);
      const TruePoint* point =
          truth == sequence.landmarks.end() ? nullptr : truth->second.at(record.frame);
      const Eigen::Vector3d s = l.velocity_covariance.diagonal().cwiseSqrt();
      one["frame"].push_back(record.frame);
      one["velocity"].push_back({l.velocity.x(), l.velocity.y(), l.velocity.z()});
      one["sigma"].push_back({s.x(), s.y(), s.z()});
      one["truth"].push_back(
          point == nullptr ? Json()
                           : Json({point->velocity.x(), point->velocity.y(), point->velocity.z()}));
    }
    json.push_back(one);
  }
  return json;
}

// The pose error and its standard deviation, axis by axis, [dr (W), dtheta (C)].
Json axes_json(const std::vector<PosePair>& pairs) {
  Json json = {{"frame", Json::array()}, {"error", Json::array()}, {"sigma", Json::array()}};
  for (const PosePair& pair : pairs) {
    const Vector12d error = boxminus(pair.truth, pair.estimate.state);
    const Vector12d sigma = pair.estimate.covariance.diagonal().cwiseSqrt();
    json["frame"].push_back(pair.frame);
    json["error"].push_back(std::vector<double>(error.begin(), error.begin() + 6));
    json["sigma"].push_back(std::vector<double>(sigma.begin(), sigma.begin() + 6));
  }
  return json;
}

Json result_json(const Study& study, std::uint64_t seed, const Sequence& sequence,
                 const RunResult& run, const RunMetrics& metrics) {
  const std::vector<PosePair> pairs = pair_with_truth(sequence, run.filtered);
  Json json;
  json["diverged"] = json_of(run.diverged);
  json["lost_at"] = metrics.failed ? Json(*metrics.failed) : Json();
  json["warnings"] = json_of(metrics.warnings);
  if (metrics.in_force) json["in_force"] = json_of(*metrics.in_force);
  json["filtered"] = values_json(metrics.filtered.values, depends_on_the_seed);
  json["smoothed"] =
      metrics.smoothed ? values_json(metrics.smoothed->values, depends_on_the_seed) : Json();
  if (metrics.last_scale) {
    json["last_scale"] = values_json(metrics.last_scale->values, depends_on_the_seed);
  }
  json.update(values_json(metrics.values, depends_on_the_seed));
  json["static"] = counts(metrics.classification.statics);
  json["moving"] = counts(metrics.classification.movings);
  json["static_often_seen"] = counts_observed_ten_times(run, Label::kStatic);
  json["moving_often_seen"] = counts_observed_ten_times(run, Label::kMoving);
  json["coverage"] = json_of(metrics.measurements);
  const std::vector<LandmarkSample> samples = estimated_samples(sequence, run);
  json["standing_by_frame"] = counts_by_frame(samples, Label::kStatic);
  json["moving_by_frame"] = counts_by_frame(samples, Label::kMoving);
  json["aligned"] = !sequence.exact_truth;
  json["frames"] = judged_frames(sequence, pairs);
  add_landmark_nees(samples, "position", &LandmarkSample::position_nees, json["frames"]);
  add_landmark_nees(samples, "velocity", &LandmarkSample::velocity_nees, json["frames"]);
  const std::vector<PosePair> smoothed = pair_with_truth(sequence, run.smoothed);
  if (has_covariances(smoothed)) json["smoothed_frames"] = judged_frames(sequence, smoothed);
  json["landmarks"] = landmarks_json(samples);
  json["tracks"] = tracks_json(study, sequence, run);
  const bool first = seed == study.first_seed;
  if (first && sequence.exact_truth && records_axes(study)) {
    json["axes"] = axes_json(run.batch ? smoothed : pairs);
  }
  return json;
}

Json timing_json(const RunMetrics& metrics) {
  Json stages = Json::object();
  for (const StageCost& s : metrics.runtime.stages) stages[s.stage] = s.total_ms;
  Json json = values_json(metrics.values, depends_on_the_clock);
  json["stages_ms"] = stages;
  return json;
}

// As it was when the study began: a run of another recording is another run.
Sequence sequence_of_run(const Study& study, const StudyCell& cell, std::uint64_t seed) {
  Sequence sequence = study_sequence(cell, seed);
  if (!cell.sequence.empty() && sequence.sha256 != study.recordings.at(cell.sequence.string())) {
    throw InputError(cell.sequence, 0, "has changed since the study began");
  }
  return selected(std::move(sequence), cell.configuration.frames);
}

}  // namespace

StudyRun run_study_cell(const Study& study, int cell, int run, DriveOptions options) {
  const StudyCell& c = study.cells[static_cast<std::size_t>(cell)];
  const auto start = std::chrono::steady_clock::now();
  StudyRun made;
  made.result = {{"cell", cell}, {"seed", study.seed(run)}};
  made.timing = {{"cell", cell}, {"seed", study.seed(run)}};
  const Sequence sequence = sequence_of_run(study, c, study.seed(run));
  try {
    options.landmarks_every_frame = !study.tracks.empty();
    const EvaluatedRun done =
        run_and_evaluate(sequence, c.configuration, c.estimator, options, study.metrics);
    made.result.update(result_json(study, study.seed(run), sequence, done.run, done.metrics));
    made.timing.update(timing_json(done.metrics));
  } catch (const std::bad_alloc&) {
    throw;  // of this machine, not of the estimator
  } catch (const InputError&) {
    throw;                                        // of what it was given
  } catch (const std::invalid_argument& error) {  // of the configuration
    throw std::invalid_argument(
        fmt::format("{}, {}, seed {}: {}", c.group, c.label, study.seed(run), error.what()));
  } catch (const std::exception& error) {
    made.result["diverged"] = {{"frame", nullptr}, {"reason", error.what()}};
  }
  made.timing["seconds"] =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return made;
}

}  // namespace slammot
