#include "eval/compare/compare.h"

#include <fmt/format.h>

#include <set>
#include <stdexcept>

#include "datasets/output/output_files.h"
#include "datasets/output/output_folder.h"
#include "eval/compare/series.h"
#include "eval/configuration/registry.h"
#include "eval/output/metrics_json.h"

namespace slammot {
namespace {

Json sequence_json(const Sequence& sequence, const CompareOptions& options) {
  return {{"name", sequence.name},
          {"path", sequence.folder.string()},
          {"sha256", sequence.sha256},
          {"seed", options.seed ? Json(*options.seed) : Json()},
          {"frames", sequence.frames.size()},
          {"exact_truth", sequence.exact_truth},
          {"width", sequence.camera.width},
          {"height", sequence.camera.height},
          {"pixel_sigma", sequence.pixel_sigma}};
}

void erase_series(Json& trajectory) {
  if (trajectory.is_object() && trajectory["nees"].is_object()) trajectory["nees"].erase("series");
}

Json run_json(const Sequence& sequence, const ComparedRun& row, const EvaluatedRun& done) {
  const auto& [configuration, run, metrics] = done;
  const EstimatorRow& estimator = find_estimator(row.estimator);
  Json json = {{"label", row.label},
               {"estimator", row.estimator},
               {"kind", to_string(estimator.kind)},
               {"oracle", is_oracle(estimator, configuration)},
               {"landmark", configuration.model.landmark},
               {"folder", row.label}};
  json["overrides"] = Json::object();
  for (const Assignment& a : row.overrides) json["overrides"][a.key] = a.value;
  json["configuration"] = Json::object();
  for (const auto& [key, value] : key_values(configuration)) json["configuration"][key] = value;
  json["metrics"] = metrics_json(metrics);
  erase_series(json["metrics"]["filtered"]);
  erase_series(json["metrics"]["smoothed"]);
  json["series"] = filtered_series(sequence, run, metrics.filtered);
  json["smoothed_series"] =
      metrics.smoothed ? smoothed_series(sequence, run, *metrics.smoothed) : Json();
  return json;
}

Configuration with_overrides(Configuration configuration, const ComparedRun& row) {
  for (const Assignment& a : row.overrides) assign(configuration, a);
  return configuration;
}

// Mistakes are found before the first run, not after an hour.
void check(const Configuration& configuration, const std::vector<ComparedRun>& runs) {
  std::set<std::string> labels;
  for (const ComparedRun& row : runs) {
    with_overrides(configuration, row);
    find_estimator(row.estimator);
    if (!labels.insert(row.label).second) {
      throw std::invalid_argument("'" + row.label + "' would be compared with itself");
    }
  }
}

// Runs one row, writes its folder, and adds it to the JSON.
NamedMetrics compare_one(const Sequence& sequence, const Configuration& base,
                         const ComparedRun& row, const CompareOptions& options, Json& runs) {
  DriveOptions drive_options;
  drive_options.landmarks_every_frame = options.landmarks_every_frame;
  if (options.progress) {
    drive_options.progress = [&](int done, int total) { options.progress(row.label, done, total); };
  }
  const EvaluatedRun done = run_and_evaluate(sequence, with_overrides(base, row), row.estimator,
                                             drive_options, options.metrics);
  write_run(options.output / row.label,
            {options.command, row.estimator, sequence.folder, sequence.name, sequence.sha256,
             options.seed, done.configuration},
            done.run, done.metrics);
  runs.push_back(run_json(sequence, row, done));
  return {row.label, row.estimator, done.configuration.model.landmark, done.metrics};
}

}  // namespace

std::vector<ComparedRun> crossed(const std::vector<std::string>& estimators,
                                 const std::vector<std::string>& landmarks) {
  std::vector<ComparedRun> runs;
  for (const std::string& estimator : estimators) {
    for (const std::string& landmark : landmarks) {
      runs.push_back(
          {fmt::format("{}-{}", estimator, landmark), estimator, {{"landmark", landmark, 0}}});
    }
  }
  return runs;
}

std::vector<NamedMetrics> compare(const Sequence& sequence, const Configuration& configuration,
                                  const std::vector<ComparedRun>& runs,
                                  const CompareOptions& options) {
  check(configuration, runs);
  std::filesystem::create_directories(options.output);
  Json json = {{"format", "slammot-compare-1"}, {"version", SLAMMOT_VERSION},
               {"command", options.command},    {"sequence", sequence_json(sequence, options)},
               {"truth", truth_json(sequence)}, {"metrics", metric_table_json(options.metrics)},
               {"runs", Json::array()}};
  std::vector<NamedMetrics> results;
  for (const ComparedRun& row : runs) {
    results.push_back(compare_one(sequence, configuration, row, options, json["runs"]));
    // Written after every run, so that what was computed is never lost.
    write_file(options.output / kComparisonOutput.mark, json.dump(1) + '\n');
  }
  return results;
}

}  // namespace slammot
