#include "eval/compare/compare.h"

#include <fmt/format.h>

#include <set>
#include <stdexcept>

#include "datasets/output/output_files.h"
#include "datasets/output/output_folder.h"
#include "eval/compare/comparison_json.h"
#include "eval/configuration/registry.h"

namespace slammot {
namespace {

std::string landmark_of(const EstimatorRow& estimator, const Configuration& configuration) {
  return estimator.has_models ? configuration.model.landmark : "-";
}

ComparedEntry entry_of(const ComparedRun& row, const Configuration& configuration) {
  const EstimatorRow& estimator = find_estimator(row.estimator);
  ComparedEntry entry{row.label,
                      row.estimator,
                      std::string(to_string(estimator.kind)),
                      is_oracle(estimator, configuration),
                      landmark_of(estimator, configuration),
                      {},
                      key_values(configuration)};
  for (const Assignment& a : row.overrides) entry.overrides[a.key] = a.value;
  return entry;
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
                         const ComparedRun& row, const CompareOptions& options, Json& json) {
  DriveOptions drive_options;
  drive_options.landmarks_every_frame = drive_options.predictions = options.landmarks_every_frame;
  drive_options.check_rotation = options.check_rotation;
  if (options.progress) {
    drive_options.progress = [&, run = json["runs"].size()](int done, int total) {
      options.progress(row.label, run, done, total);
    };
  }
  const EvaluatedRun done = run_and_evaluate(sequence, with_overrides(base, row), row.estimator,
                                             drive_options, options.metrics);
  write_run(options.output / row.label,
            {options.command, row.estimator, sequence.folder, sequence.name, sequence.sha256,
             options.seed, done.configuration, done.from_sequence},
            done.run, done.metrics);
  json["runs"].push_back(
      run_json(sequence, entry_of(row, done.configuration), done.run, done.metrics));
  json["runs"].back()["pooled"] = row.label;
  return {row.label, estimator_label(row.estimator),
          landmark_of(find_estimator(row.estimator), done.configuration), done.metrics};
}

// Where `:KEY=VALUE,..` begins; the name of a Python estimator has colons too.
std::size_t settings_in(const std::string& text) {
  for (std::size_t colon = text.find(':'); colon != std::string::npos;
       colon = text.find(':', colon + 1)) {
    const std::size_t end = text.find_first_of(":/=", colon + 1);
    const bool nothing_follows = colon + 1 == text.size();
    if (nothing_follows || (end != std::string::npos && text[end] == '=')) return colon;
  }
  return std::string::npos;
}

}  // namespace

ComparedRun with_settings(const std::string& text) {
  const std::size_t colon = settings_in(text);
  const std::string estimator = text.substr(0, colon);
  ComparedRun run{estimator_label(estimator), estimator, {}};
  for (std::size_t begin = colon; begin != std::string::npos;) {
    const std::size_t end = text.find(',', begin + 1);
    const std::size_t length = end == std::string::npos ? end : end - begin - 1;
    run.overrides.push_back(parse_assignment(text.substr(begin + 1, length)));
    run.label += "-" + run.overrides.back().key + "=" + run.overrides.back().value;
    begin = end;
  }
  if (run.label.find('/') != std::string::npos) {
    throw std::invalid_argument("'" + run.label + "' names a folder and has no '/'");
  }
  return run;
}

std::vector<ComparedRun> crossed(const std::vector<std::string>& estimators,
                                 const std::vector<std::string>& landmarks) {
  std::vector<ComparedRun> runs;
  for (const std::string& estimator : estimators) {
    const ComparedRun alone = with_settings(estimator);
    if (!find_estimator(alone.estimator).has_models) {
      runs.push_back(alone);
      continue;
    }
    for (const std::string& landmark : landmarks) {
      ComparedRun run = alone;
      run.label += "-" + landmark;
      run.overrides.insert(run.overrides.begin(), {"landmark", landmark, 0});
      runs.push_back(run);
    }
  }
  return runs;
}

std::vector<NamedMetrics> compare(const Sequence& sequence, const Configuration& configuration,
                                  const std::vector<ComparedRun>& runs,
                                  const CompareOptions& options) {
  check(configuration, runs);
  std::filesystem::create_directories(options.output);
  Json json = comparison_json(options.command, sequence, options.seed, options.metrics);
  std::vector<NamedMetrics> results;
  for (const ComparedRun& row : runs) {
    results.push_back(compare_one(sequence, configuration, row, options, json));
    // Written after every run, so that what was computed is never lost.
    write_file(options.output / kComparisonOutput.mark, json.dump(1) + '\n');
  }
  return results;
}

}  // namespace slammot
