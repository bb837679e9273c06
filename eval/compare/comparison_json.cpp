#include "eval/compare/comparison_json.h"

#include "eval/compare/series.h"
#include "eval/output/judged_frames.h"
#include "eval/provenance/provenance.h"

namespace slammot {
namespace {

void erase_series(Json& trajectory) {
  if (trajectory.is_object() && trajectory["nees"].is_object()) trajectory["nees"].erase("series");
}

Json frames_json(const Sequence& sequence, const RunResult& run) {
  const std::vector<PosePair> pairs = pair_with_truth(sequence, run.judged());
  Json json = judged_frames(sequence, pairs);
  json["timestamp"] = Json::array();
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    json["timestamp"].push_back(pairs[i].estimate.timestamp);
  }
  return json;
}

}  // namespace

Json sequence_json(const Sequence& sequence, std::optional<std::uint64_t> seed) {
  return {{"name", sequence.name},
          {"path", sequence.folder.string()},
          {"sha256", sequence.sha256},
          {"seed", seed ? Json(*seed) : Json()},
          {"frames", sequence.frames.size()},
          {"exact_truth", sequence.exact_truth},
          {"width", sequence.camera.width},
          {"height", sequence.camera.height},
          {"pixel_sigma", sequence.pixel_sigma}};
}

Json run_json(const Sequence& sequence, const ComparedEntry& entry, const RunResult& run,
              const RunMetrics& metrics) {
  Json json = {{"label", entry.label},   {"estimator", entry.estimator}, {"kind", entry.kind},
               {"oracle", entry.oracle}, {"landmark", entry.landmark},   {"folder", entry.label}};
  json["overrides"] = Json::object();
  for (const auto& [key, value] : entry.overrides) json["overrides"][key] = value;
  json["configuration"] = Json::object();
  for (const auto& [key, value] : entry.configuration) json["configuration"][key] = value;
  json["metrics"] = metrics_json(metrics);
  erase_series(json["metrics"]["filtered"]);
  erase_series(json["metrics"]["smoothed"]);
  json["series"] = run_series(sequence, run, metrics.judged());
  json["frames"] = frames_json(sequence, run);
  json["smoothed_series"] = metrics.smoothed && !metrics.batch
                                ? path_series(sequence, run.smoothed, *metrics.smoothed)
                                : Json();
  if (metrics.last_scale) {
    json["last_scale_series"] = path_series(sequence, run.last_scale, *metrics.last_scale);
  }
  return json;
}

Json comparison_json(const std::string& command, const Sequence& sequence,
                     std::optional<std::uint64_t> seed, const MetricTable& metrics) {
  return {{"format", "slammot-compare-1"},
          {"version", SLAMMOT_VERSION},
          {"command", command},
          {"provenance", json_of(provenance())},
          {"sequence", sequence_json(sequence, seed)},
          {"truth", truth_json(sequence)},
          {"metrics", metric_table_json(metrics)},
          {"runs", Json::array()}};
}

}  // namespace slammot
