#include "eval/output/metrics_json.h"
#include "eval/output/in_force.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "datasets/text/number.h"
#include "datasets/text/printable.h"

namespace slammot {
namespace {

// The object of a dotted name within `json`, made where it is missing.
Json& block_of(Json& json, const std::string& name) {
  Json* block = &json;
  for (size_t begin = 0; begin < name.size();) {
    const size_t end = std::min(name.find('.', begin), name.size());
    block = &(*block)[name.substr(begin, end - begin)];
    begin = end + 1;
  }
  return *block;
}

Json number_json(const MetricValue& v) {
  const bool whole = v.metric.form == Form::kCount && std::isfinite(v.value);
  return whole ? Json(static_cast<long>(v.value)) : Json(v.value);
}

void put_values(Json& json, const std::vector<MetricValue>& values) {
  for (const MetricValue& v : values) {
    block_of(json, v.metric.block)[v.metric.name_in_block()] = number_json(v);
  }
}

// A block that is not known is null beside the reason.
template <typename T>
void put_reason(Json& json, const std::string& name, const Known<T>& known) {
  if (known.value) return;
  json[name] = nullptr;
  json[name + "_reason"] = known.reason;
}

// Of one part of the error, with the reason where nothing of it was judged.
void put_interval(Json& nees, const char* part, const NeesSummary& s) {
  nees[part]["single_run_interval_95"] = {s.lower, s.upper};
  if (s.used == 0)
    nees[part]["reason"] = "no sample: no covariance, no true value, or no pose but the first";
}

void put_series(Json& nees, const PoseConsistency& c) {
  nees["error"] = "[dr (W), dtheta (C, right)]";
  nees["excluded"] = "the first judged pose";
  nees["note"] = "frames of one run are correlated: fraction_inside is descriptive";
  put_interval(nees, "pose", c.pose);
  put_interval(nees, "position", c.position);
  put_interval(nees, "rotation", c.rotation);
  nees["series_columns"] = {"frame", "timestamp", "pose", "position", "rotation"};
  nees["series"] = Json::array();
  for (const PoseNees& s : c.series) {
    nees["series"].push_back({s.frame, s.timestamp, s.pose, s.position, s.rotation});
  }
}

Json trajectory_json(const TrajectoryMetrics& t) {
  Json json = Json::object();
  put_values(json, t.values);
  put_reason(json, "accuracy", t.accuracy);
  if (t.accuracy.value && !t.accuracy.value->sim3_reason.empty()) {
    json["accuracy"]["ate_sim3_reason"] = t.accuracy.value->sim3_reason;
  }
  put_reason(json, "nees", t.consistency);
  if (t.consistency.value) put_series(json["nees"], *t.consistency.value);
  return json;
}

Json stages_json(const RuntimeMetrics& r) {
  Json stages = Json::array();
  for (const StageCost& s : r.stages) {
    stages.push_back({{"stage", s.stage},
                      {"median_ms", s.median_ms},
                      {"p95_ms", s.p95_ms},
                      {"total_ms", s.total_ms}});
  }
  return stages;
}

struct CountField {
  const char* key;
  int MeasurementCounts::*count;
};
constexpr CountField kCounts[] = {
    {"frames_offered", &MeasurementCounts::frames_offered},
    {"frames_done", &MeasurementCounts::frames_done},
    {"measurements_offered", &MeasurementCounts::offered},
    {"accepted", &MeasurementCounts::accepted},
    {"rejected", &MeasurementCounts::rejected},
    {"out_of_view", &MeasurementCounts::out_of_view},
    {"landmarks_admitted", &MeasurementCounts::initialised},
    {"landmarks_lost", &MeasurementCounts::pruned},
    {"negative_inverse_depths", &MeasurementCounts::negative_inverse_depth},
};

}  // namespace

Json json_of(const MeasurementCounts& counts) {
  Json json = Json::object();
  for (const CountField& field : kCounts) json[field.key] = counts.*field.count;
  return json;
}

MeasurementCounts measurement_counts_of(const Json& json) {
  MeasurementCounts counts;
  for (const CountField& field : kCounts) counts.*field.count = count_of(json.at(field.key));
  return counts;
}

int count_of(const Json& json) {
  if (json.is_number_integer()) {
    const auto value = json.get<std::int64_t>();
    if (value >= 0 && value <= std::numeric_limits<int>::max()) return static_cast<int>(value);
  }
  throw Json::other_error::create(501, "not a count: " + json.dump(), &json);
}

Json json_of(const std::optional<Divergence>& d) {
  return d ? Json{{"frame", d->frame}, {"reason", d->reason}} : Json();
}

namespace {

// Of a file that may be anybody's, for the terminal.
std::string reason_of(const Json& json) { return printable(json.at("reason").get<std::string>()); }

double plausible_number(const Json& json, double largest) {
  const double value = json.get<double>();
  if (std::abs(value) <= largest) return value;
  throw Json::other_error::create(501, "not plausible: " + json.dump(), &json);
}

// Of the accepted; zero where their mean is not known.
double nis_sum(const Json& mean, int accepted) {
  constexpr double kMostSigmas = kLargest / kSmallest;
  return mean.is_number() ? plausible_number(mean, kMostSigmas * kMostSigmas) * accepted : 0.0;
}

// Runs of before have none.
void restore_lasting(const Json& nis, FrameCounts& totals) {
  if (!nis.contains("lasting_mean") || nis["lasting_mean"].is_null()) return;
  totals.lasting_sums = count_of(nis.at("lasting_sums"));
  totals.lasting_nis = nis_sum(nis.at("lasting_mean"), totals.lasting_sums);
}

// Shares of what was stated are written.
void restore_scale(const Json& metrics, ScaleInformation& scale) {
  const auto number = [&](const char* leaf) {
    const Json& value = metrics.contains("scale") ? metrics["scale"].at(leaf) : Json();
    return value.is_number() ? plausible_number(value, kLargest) : kUndefined;
  };
  scale.stated = number("stated");
  scale.largest = scale.stated * number("largest");
  scale.last = scale.stated * number("last");
}

Json json_of(const RunAlignment& a) {
  const auto row = [&](int i) {
    return Json{a.rotation(i, 0), a.rotation(i, 1), a.rotation(i, 2)};
  };
  return {{"by", a.by},
          {"poses", a.poses},
          {"fitted", a.fitted},
          {"degrees_of_freedom_left", std::int64_t{6} * a.poses - a.fitted},
          {"verdict", a.verdict},
          {"note", a.note},
          {"scale", a.scale},
          {"rotation", {row(0), row(1), row(2)}},
          {"translation", {a.translation(0), a.translation(1), a.translation(2)}}};
}

RunAlignment alignment_of(const Json& json) {
  RunAlignment a;
  a.by = printable(json.at("by").get<std::string>());
  a.poses = count_of(json.at("poses"));
  a.fitted = count_of(json.at("fitted"));
  a.verdict = json.at("verdict").get<bool>();
  a.note = printable(json.at("note").get<std::string>());
  a.scale = json.at("scale").get<double>();
  for (int i = 0; i < 3; ++i) {
    const auto row = static_cast<std::size_t>(i);
    const auto rotation = json.at("rotation").at(row).get<std::array<double, 3>>();
    a.rotation.row(i) = Eigen::Map<const Eigen::RowVector3d>(rotation.data());
    a.translation(i) = json.at("translation").at(row).get<double>();
  }
  return a;
}

// The numbers are added up.
void require_countable(const MeasurementCounts& counts) {
  count_of(std::int64_t{counts.accepted} + counts.rejected + counts.out_of_view);
}

}  // namespace

std::optional<Divergence> divergence_of(const Json& json) {
  if (json.is_null()) return std::nullopt;
  return Divergence{count_of(json.at("frame")), reason_of(json)};
}

Json json_of(const std::vector<RunWarning>& warnings) {
  Json json = Json::array();
  for (const RunWarning& w : warnings) {
    json.push_back({{"frame", w.frame ? Json(*w.frame) : Json()}, {"reason", w.reason}});
  }
  return json;
}

std::vector<RunWarning> warnings_of(const Json& json) {
  std::vector<RunWarning> warnings;
  for (const Json& w : json) {
    const Json& frame = w.at("frame");
    warnings.push_back(
        {frame.is_null() ? std::nullopt : std::optional(count_of(frame)), reason_of(w)});
  }
  return warnings;
}

Json metrics_json(const RunMetrics& m) {
  Json json = Json::object();
  json["diverged"] = m.diverged.has_value();
  json["divergence"] = json_of(m.diverged);
  json["warnings"] = json_of(m.warnings);
  if (m.in_force) json["in_force"] = json_of(*m.in_force);
  if (m.alignment) json["alignment"] = json_of(*m.alignment);
  json["failed"] = m.failed.has_value();
  json["failed_at"] = m.failed ? Json(*m.failed) : Json();
  json["filtered"] = trajectory_json(m.filtered);
  json["smoothed"] = m.smoothed ? trajectory_json(*m.smoothed) : Json();
  if (m.last_scale) json["last_scale"] = trajectory_json(*m.last_scale);
  put_values(json, m.values);
  put_reason(json, "landmark_errors", m.landmark_errors);
  put_reason(json, "landmark_nees", m.landmark_consistency);
  if (m.landmark_consistency.value) {
    put_interval(json["landmark_nees"], "position", m.landmark_consistency.value->position);
    put_interval(json["landmark_nees"], "velocity", m.landmark_consistency.value->velocity);
  }
  json["coverage"] = json_of(m.measurements);
  json["runtime"]["stages"] = stages_json(m.runtime);
  return json;
}

void restore_totals(const Json& metrics, RunResult& run) {
  const MeasurementCounts counts = measurement_counts_of(metrics.at("coverage"));
  require_countable(counts);
  FrameCounts& totals = run.totals;
  run.frames_offered = counts.frames_offered;
  totals.accepted = counts.accepted;
  totals.rejected = counts.rejected;
  totals.out_of_view = counts.out_of_view;
  totals.admitted = counts.initialised;
  totals.pruned = counts.pruned;
  totals.negative_inverse_depth = counts.negative_inverse_depth;
  totals.nis_sum = nis_sum(metrics.at("nis").at("mean"), totals.accepted);
  totals.joint_nis = nis_sum(metrics.at("nis").at("joint_mean"), totals.accepted);
  restore_lasting(metrics.at("nis"), totals);
  restore_scale(metrics, run.scale);
  run.smoothing_ms = plausible_number(metrics.at("runtime").at("smoothing_ms"), kLargest);
  run.diverged = divergence_of(metrics.at("divergence"));
  run.warnings = warnings_of(metrics.at("warnings"));
  if (metrics.contains("in_force")) run.in_force = in_force_of(metrics["in_force"]);
  if (metrics.contains("alignment")) run.alignment = alignment_of(metrics["alignment"]);
}

Json values_json(const std::vector<MetricValue>& values,
                 const std::function<bool(const Metric&)>& wanted) {
  Json json = Json::object();
  for (const MetricValue& v : values) {
    if (wanted(v.metric)) json[v.metric.key] = v.value;
  }
  return json;
}

}  // namespace slammot
