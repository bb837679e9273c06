#include "eval/study/study_cell.h"

#include <fmt/format.h>

#include <cmath>

#include "eval/statistics/statistics.h"
#include "eval/study/study_json.h"

namespace slammot {

namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kCounts[] = {
    "static",         "moving", "static_often_seen", "moving_often_seen", "standing_by_frame",
    "moving_by_frame"};

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
  if (!run.at("lost_at").is_null()) lost_.push_back({{"seed", seed}, {"frame", run["lost_at"]}});
  frames_.add(run.at("frames"));
  if (run.contains("smoothed_frames")) smoothed_.add(run["smoothed_frames"]);
  stated_sigma_[seed] = root_mean_square(numbers(run["frames"].at("position_sigma_m")));
  pose_nees_[seed] = mean(numbers(run["frames"].at("nees_pose")));
  ages_.add(run.at("landmarks"));
  tracks_.add(run.at("tracks"));
  for (const char* what : kCounts) {
    for (std::size_t i = 0; i < 3; ++i) counts_[what][i] += run.at(what)[i].get<long>();
  }
  for (const auto& [key, value] : run.at("coverage").items()) coverage_[key] += number(value);
  for (const char* what : {"nis_mean", "nis_expected", "median_frames_to_decision"}) {
    add_scalar(what, run.at(what));
  }
  if (!diverged.is_null()) return;
  // A batch is judged by what it is for: its filtered trajectory is its front window's.
  const char* judged = run.contains("smoothed_frames") ? "smoothed" : "filtered";
  position_rmse_[seed] = number(run.at(judged).at("position_rmse_m"));
  add_accuracy(run);
}

// One that is not defined (no landmark was ever decided) is no sample.
void CellSummary::add_scalar(const std::string& key, const Json& value) {
  if (value.is_number()) scalars_[key].push_back(value.get<double>());
}

void CellSummary::add_accuracy(const Json& run) {
  for (const std::string which : {"filtered", "smoothed"}) {
    if (run.at(which).is_null()) continue;
    for (const auto& [key, value] : run[which].items()) {
      add_scalar(fmt::format("{}_{}", which, key), value);
    }
  }
}

void CellSummary::add_timing(const Json& timing) {
  for (const char* what : {"seconds", "frame_median_ms", "frames_per_second", "smoothing_ms"}) {
    if (timing.contains(what)) timing_[what].push_back(number(timing[what]));
  }
  if (!timing.contains("stages_ms")) return;
  for (const auto& [stage, ms] : timing["stages_ms"].items()) stages_[stage] += number(ms);
}

Json CellSummary::json() const {
  Json json = {{"label", cell_.label},
               {"estimator", cell_.estimator},
               {"runs", runs_},
               {"diverged", diverged_},
               {"lost", lost_}};
  json["configuration"] = Json::object();
  for (const auto& [key, value] : key_values(cell_.configuration)) {
    json["configuration"][key] = value;
  }
  if (frames_.empty()) return json;  // no run began
  for (const auto& [key, samples] : scalars_) {
    const bool is_rmse = key.find("rmse") != std::string::npos;
    json[key] = json_of(bootstrap(samples, is_rmse ? root_mean_square : mean));
  }
  json["anees"] = frames_.anees();
  if (!smoothed_.empty()) json["smoothed_anees"] = smoothed_.anees();
  for (const auto& [what, counts] : counts_) json[what] = counts;
  json["coverage"] = coverage_;
  json["timing"] = Json::object();
  for (const auto& [key, samples] : timing_) json["timing"][key] = median(samples);
  json["timing"]["stages_ms"] = stages_;
  json["per_frame"] = frames_.per_frame();
  if (!smoothed_.empty()) json["smoothed_per_frame"] = smoothed_.per_frame();
  json["by_age"] = ages_.json();
  json["tracks"] = tracks_.json();
  return json;
}

}  // namespace slammot
