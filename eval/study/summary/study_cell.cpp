#include "eval/study/summary/study_cell.h"

#include <algorithm>
#include <cmath>

#include "eval/configuration/registry.h"
#include "eval/output/in_force.h"
#include "eval/output/metrics_json.h"
#include "eval/pooling/estimate_json.h"
#include "eval/statistics/statistics.h"

namespace slammot {

namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kCounts[] = {
    "static",         "moving", "static_often_seen", "moving_often_seen", "standing_by_frame",
    "moving_by_frame"};

constexpr int kPoseDof = 6;
constexpr std::size_t kWorst = 3;  // runs that are named

std::vector<double> numbers(const Json& array) {
  std::vector<double> values;
  for (const Json& value : array) values.push_back(number(value));
  return values;
}

}  // namespace

void CellSummary::add(const Json& run) {
  ++runs_;
  const auto seed = run.at("seed").get<std::uint64_t>();
  const Json& diverged = run.at("diverged");
  position_rmse_[seed] = INFINITY;
  if (!diverged.is_null()) {
    diverged_.push_back({{"seed", seed},
                         {"frame", diverged.value("frame", Json())},
                         {"reason", diverged.at("reason")}});
  }
  if (!run.contains("frames")) return;  // it never began
  add_statements(seed, run);
  const bool batch = is_batch(cell_.estimator);  // see RunResult
  const char* judged = batch ? "smoothed" : "filtered";
  const char* frames = batch ? "smoothed_frames" : "frames";
  if (run.contains(frames)) add_frames(seed, run[frames]);
  add_counts(run);
  add_values(Scope::kRun, run, "");
  if (!diverged.is_null()) return;
  aligned_ = run.value("aligned", false);
  if (!run.at(judged).is_object()) return;  // a batch that was not solved
  position_rmse_[seed] = number(run[judged].at(aligned_ ? kAteSim3 : kPositionRmse));
  for (const std::string which : {"filtered", "smoothed"}) {
    add_values(Scope::kTrajectory, run.at(which), which + "_");
  }
}

// What the run says of itself, and where it was lost.
void CellSummary::add_statements(std::uint64_t seed, const Json& run) {
  if (!run.at("lost_at").is_null()) failed_.push_back({{"seed", seed}, {"frame", run["lost_at"]}});
  const std::vector<RunWarning> warnings = warnings_of(run.value("warnings", Json::array()));
  if (!warnings.empty()) {
    warnings_.push_back({{"seed", seed}, {"warnings", json_of(warnings)}});
  }
  if (run.contains("in_force")) add_in_force(run["in_force"]);
}

void CellSummary::add_counts(const Json& run) {
  if (run.contains("axes")) axes_ = run["axes"];
  ages_.add(run.at("landmarks"));
  tracks_.add(run.at("tracks"));
  for (const char* what : kCounts) {
    for (std::size_t i = 0; i < 3; ++i) counts_[what][i] += count_of(run.at(what).at(i));
  }
  for (const auto& [key, value] : run.at("coverage").items()) coverage_[key] += number(value);
}

void CellSummary::add_in_force(const Json& mechanisms) {
  ++stating_;
  for (const Mechanism& m : in_force_of(mechanisms)) {
    auto known = std::ranges::find(in_force_, m.name, &std::pair<std::string, Acting>::first);
    if (known == in_force_.end()) known = in_force_.insert(known, {m.name, {m.key, "", 0, 0}});
    Acting& acting = known->second;
    if (!m.because.empty()) acting.because = m.because;
    acting.on += m.is_on ? 1 : 0;
    acting.acted += m.acted;
  }
}

// A seed may decide, as where the sequence states what a mechanism asks for.
Json CellSummary::in_force() const {
  Json json = Json::array();
  for (const auto& [name, m] : in_force_) {
    json.push_back({{"name", name},
                    {"key", m.key},
                    {"on", m.on},
                    {"runs", stating_},
                    {"because", m.because},
                    {"acted", m.acted}});
  }
  return json;
}

void CellSummary::add_frames(std::uint64_t seed, const Json& frames) {
  frames_.add(frames);
  std::vector<double> sigmas = numbers(frames.at("position_sigma_m"));
  if (sigmas.empty()) return;
  sigmas.push_back(0.0);  // of the first frame, a pin: an RMSE counts it too
  stated_sigma_[seed] = root_mean_square(sigmas);
  if (!frames.contains("nees_pose")) return;
  std::vector<double> nees;
  for (const Json& value : frames["nees_pose"]) nees.push_back(nees_number(value));
  pose_nees_[seed] = mean(nees);
  const RunNees of_run = run_nees(nees, kPoseDof);
  run_nees_[seed] = {of_run, of_run.began ? frames.at("frame").at(*of_run.began) : Json()};
}

// One that is not defined (no landmark was ever decided) is no sample. Nor are poses at a lag of a
// run that diverged, whose RMSE is not counted either.
void CellSummary::add_values(Scope scope, const Json& values, const std::string& prefix) {
  for (const Metric& metric : metrics_) {
    const bool pools = metric.pooled == Pooled::kMean || metric.pooled == Pooled::kRootMeanSquare;
    if (metric.scope != scope || !pools || !values.is_object()) continue;
    if (metric.key.starts_with("lag.") && !values.at("diverged").is_null()) continue;
    const auto value = values.find(metric.key);
    if (value == values.end() || !value->is_number()) continue;
    Scalar& scalar = scalars_[prefix + metric.key];
    scalar.pooled = metric.pooled;
    scalar.samples.push_back(value->get<double>());
  }
}

// Of each run's mean pose NEES: quantiles, how many are more than chance allows, and the worst.
Json CellSummary::nees_by_run() const {
  std::vector<double> means;
  std::vector<std::pair<double, std::uint64_t>> exceeding;
  for (const auto& [seed, run] : run_nees_) {
    if (!std::isnan(run.first.mean)) means.push_back(run.first.mean);
    if (run.first.exceeds()) exceeding.push_back({-run.first.mean, seed});
  }
  std::ranges::sort(exceeding);
  Json worst = Json::array();
  for (std::size_t i = 0; i < std::min(kWorst, exceeding.size()); ++i) {
    const auto& [run, frame] = run_nees_.at(exceeding[i].second);
    worst.push_back({{"seed", exceeding[i].second}, {"mean", run.mean}, {"began", frame}});
  }
  return {{"runs", means.size()},
          {"exceeding", exceeding.size()},
          {"quantiles", {quantile(means, 0.1), quantile(means, 0.5), quantile(means, 0.9)}},
          {"worst", worst}};
}

void CellSummary::add_timing(const Json& timing) {
  timing_["seconds"].push_back(number(timing.at("seconds")));
  for (const Metric& metric : metrics_) {
    const bool timed = metric.pooled == Pooled::kMedianTiming && timing.contains(metric.key);
    if (timed) timing_[metric.key].push_back(number(timing[metric.key]));
  }
  if (!timing.contains("stages_ms")) return;
  for (const auto& [stage, ms] : timing["stages_ms"].items()) stages_[stage] += number(ms);
}

Json CellSummary::json() const {
  const EstimatorRow& estimator = find_estimator(cell_.estimator);
  Json json = {{"label", cell_.label},
               {"estimator", cell_.estimator},
               {"kind", to_string(estimator.kind)},
               {"oracle", is_oracle(estimator, cell_.configuration)},
               {"runs", runs_},
               {"aligned", aligned_},
               {"diverged", diverged_},
               {"lost", failed_},
               {"warnings", warnings_}};
  json["configuration"] = Json::object();
  Configuration configuration = cell_.configuration;
  estimator.adjust(configuration);
  for (const auto& [key, value] : key_values(configuration)) {
    json["configuration"][key] = value;
  }
  if (stating_ > 0) json["in_force"] = in_force();
  if (coverage_.empty()) return json;  // no run began
  for (const auto& [key, scalar] : scalars_) {
    json[key] = json_of(pool(scalar.samples, scalar.pooled));
  }
  if (!run_nees_.empty()) json["nees_by_run"] = nees_by_run();
  for (const auto& [what, counts] : counts_) json[what] = counts;
  json["coverage"] = coverage_;
  json["timing"] = Json::object();
  for (const auto& [key, samples] : timing_) json["timing"][key] = median(samples);
  json["timing"]["stages_ms"] = stages_;
  if (!frames_.empty()) {
    json["anees"] = frames_.anees();
    json["per_frame"] = frames_.per_frame();
  }
  if (!axes_.is_null()) json["axes"] = axes_;
  json["by_age"] = ages_.json();
  json["tracks"] = tracks_.json();
  return json;
}

}  // namespace slammot
