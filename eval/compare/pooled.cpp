#include "eval/compare/pooled.h"

#include <algorithm>
#include <cmath>

#include "eval/pooling/estimate_json.h"
#include "eval/pooling/frame_statistics.h"
#include "eval/pooling/paired_errors.h"

namespace slammot {
namespace {

struct Part {
  const char* name;
  NeesSummary PoseConsistency::*summary;
};
constexpr Part kParts[] = {{"pose", &PoseConsistency::pose},
                           {"position", &PoseConsistency::position},
                           {"rotation", &PoseConsistency::rotation}};

bool has_nees(const RunMetrics& metrics, const Part& part) {
  const auto& consistency = metrics.judged().consistency.value;
  return consistency && (*consistency.*part.summary).used > 0;
}

// A run of a foreign trajectory and one of this program may know different metrics of a table.
Json values_of_all(const std::vector<const RunMetrics*>& runs) {
  std::map<std::string, std::vector<double>> samples;
  std::map<std::string, Pooled> how;
  const auto take = [&](const std::vector<MetricValue>& values) {
    for (const MetricValue& v : values) {
      const bool pools =
          v.metric.pooled == Pooled::kMean || v.metric.pooled == Pooled::kRootMeanSquare;
      if (!pools || std::isnan(v.value)) continue;
      samples[v.metric.key].push_back(v.value);
      how[v.metric.key] = v.metric.pooled;
    }
  };
  for (const RunMetrics* run : runs) {
    if (run->diverged) continue;
    take(run->judged().values);
    take(run->values);
  }
  Json json = Json::object();
  for (const auto& [key, of_runs] : samples) json[key] = json_of(pool(of_runs, how[key]));
  return json;
}

// Errors over some of the frames do not compare with errors over others.
bool over_other_frames(const RunMetrics& a, const RunMetrics& b) {
  constexpr double kApart = 0.1;
  if (a.diverged || b.diverged) return false;  // which loses
  const auto coverage = [](const RunMetrics& m) { return value_of(m.judged().values, "coverage"); };
  return std::abs(coverage(a) - coverage(b)) > kApart;
}

}  // namespace

void Pool::add(const std::string& name, const Sequence& sequence, const RunResult& run,
               const RunMetrics& metrics) {
  if (!runs_.contains(name)) names_.push_back(name);
  const std::vector<PosePair> pairs = pair_with_truth(sequence, run.judged());
  Run added{sequence.sha256, metrics, judged_frames(sequence, pairs), {}, INFINITY};
  for (const PosePair& pair : pairs) added.timestamps[pair.frame] = pair.estimate.timestamp;
  key_ = sequence.exact_truth ? kPositionRmse : kAteSim3;
  const double error = value_of(metrics.judged().values, key_);
  if (!metrics.diverged && !std::isnan(error)) added.error = error;
  runs_[name].push_back(std::move(added));
}

Json Pool::estimator_json(const std::string& name, const std::vector<Run>& runs) {
  FrameStatistics frames;
  std::vector<const RunMetrics*> metrics;
  for (const Run& run : runs) {
    metrics.push_back(&run.metrics);
    frames.add(run.frames);
  }
  const auto count = [&](const auto& is) { return std::ranges::count_if(metrics, is); };
  Json json = {{"name", name},
               {"runs", runs.size()},
               {"diverged", count([](auto m) { return m->diverged.has_value(); })},
               {"failed", count([](auto m) { return m->failed.has_value(); })},
               {"warned", count([](auto m) { return m->warned(); })},
               {"values", values_of_all(metrics)},
               {"anees", Json::object()},
               {"per_frame", Json()}};
  if (frames.empty()) return json;
  const Json anees = frames.anees();
  json["per_frame"] = frames.per_frame();
  for (const Part& part : kParts) {
    const bool judged = anees.contains(part.name) &&
                        std::ranges::all_of(metrics, [&](auto m) { return has_nees(*m, part); });
    if (!judged) {
      json["per_frame"].erase(std::string("anees_") + part.name);
      continue;
    }
    json["anees"][part.name] = anees.at(part.name);
  }
  json["per_frame"]["timestamp"] = Json::array();
  std::map<int, double> timestamps;
  for (const Run& run : runs) timestamps.insert(run.timestamps.begin(), run.timestamps.end());
  for (const Json& frame : json["per_frame"]["frame"]) {
    json["per_frame"]["timestamp"].push_back(timestamps.at(frame.get<int>()));
  }
  return json;
}

Json Pool::estimators() const {
  Json json = Json::array();
  for (const std::string& name : names_) json.push_back(estimator_json(name, runs_.at(name)));
  return json;
}

Json Pool::pair_json(const std::string& a, const std::string& b) const {
  std::map<std::string, std::vector<const Run*>> of_b;
  for (const Run& run : runs_.at(b)) of_b[run.sequence].push_back(&run);
  std::map<std::string, std::size_t> taken;
  PairedErrors errors;
  for (const Run& run : runs_.at(a)) {
    const std::size_t i = taken[run.sequence]++;
    if (i >= of_b[run.sequence].size()) continue;
    const Run& other = *of_b[run.sequence][i];
    if (over_other_frames(run.metrics, other.metrics)) continue;
    errors.add(run.error, other.error);
  }
  return {{"a", a},
          {"b", b},
          {"metric", key_},
          {"pairs", errors.pairs()},
          {"wins_a", errors.wins_a()},
          {"wins_b", errors.wins_b()},
          {"difference", json_of(errors.difference())}};
}

Json Pool::pairs() const {
  Json json = Json::array();
  for (std::size_t i = 0; i < names_.size(); ++i) {
    for (std::size_t k = i + 1; k < names_.size(); ++k) {
      json.push_back(pair_json(names_[i], names_[k]));
    }
  }
  return json;
}

}  // namespace slammot
