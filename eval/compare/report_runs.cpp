#include "eval/compare/report_runs.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <stdexcept>

#include "datasets/output/output_files.h"
#include "datasets/output/output_folder.h"
#include "datasets/text/text_table.h"
#include "eval/compare/comparison_json.h"
#include "eval/configuration/registry.h"
#include "eval/output/metrics_json.h"
#include "eval/output/run_files.h"
#include "eval/output/run_writer.h"

namespace slammot {
namespace {

using Path = std::filesystem::path;

// The names of the runs; those that several have get the name of their folder before them, or a
// number.
std::vector<std::string> labels_of(const std::vector<JudgedRun>& runs) {
  std::vector<std::string> labels;
  std::map<std::string, int> uses;
  for (const JudgedRun& run : runs) ++uses[labels.emplace_back(run_name(run.path))];
  std::set<std::string> taken;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const std::string name = labels[i];
    if (uses[name] > 1) {
      labels[i] = run_name(std::filesystem::absolute(runs[i].path) / "..") + "-" + name;
    }
    const std::string base = labels[i];
    for (int n = 2; !taken.insert(labels[i]).second; ++n) {
      labels[i] = base + "-" + std::to_string(n);
    }
  }
  return labels;
}

// Without those that each sequence decides for itself, such as its priors.
std::map<std::string, std::string> settings_given(const StoredRun& run) {
  std::map<std::string, std::string> given = run.configuration;
  for (const std::string& key : run.from_sequence) given.erase(key);
  return given;
}

bool same_settings(const JudgedRun& a, const JudgedRun& b) {
  return settings_given(a.stored) == settings_given(b.stored);
}

// Runs of one estimator with the same configuration are pooled. A second configuration of an
// estimator is called after its first run.
std::vector<std::string> names_of(const std::vector<JudgedRun>& runs,
                                  const std::vector<std::string>& labels) {
  std::map<std::string, std::vector<std::size_t>> configurations;  // first run of each
  std::vector<std::size_t> first_of(runs.size());
  for (std::size_t i = 0; i < runs.size(); ++i) {
    std::vector<std::size_t>& known = configurations[runs[i].estimator];
    const auto same =
        std::ranges::find_if(known, [&](std::size_t k) { return same_settings(runs[k], runs[i]); });
    first_of[i] = same == known.end() ? known.emplace_back(i) : *same;
  }
  std::vector<std::string> names;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const bool several = configurations[runs[i].estimator].size() > 1;
    names.push_back(several ? runs[i].estimator + " " + labels[first_of[i]] : runs[i].estimator);
  }
  return names;
}

// To the last digit, of a path: one pose says nothing.
bool same_estimates(const RunResult& a, const RunResult& b) {
  if (a.judged().size() < 3) return false;
  return std::ranges::equal(a.judged(), b.judged(), [](const auto& x, const auto& y) {
    const auto P = x.covariance.array(), Q = y.covariance.array();
    return x.timestamp == y.timestamp && x.state.position == y.state.position &&
           x.state.orientation.coeffs() == y.state.orientation.coeffs() &&
           (P == Q || (P.isNaN() && Q.isNaN())).all();
  });
}

// A run that is pooled with itself would count as two.
void require_distinct(const std::vector<JudgedRun>& runs, const std::vector<std::string>& names) {
  for (std::size_t i = 0; i < runs.size(); ++i) {
    for (std::size_t k = i + 1; k < runs.size(); ++k) {
      const bool same = names[i] == names[k] &&
                        runs[i].sequence->sha256 == runs[k].sequence->sha256 &&
                        same_estimates(runs[i].stored.run, runs[k].stored.run);
      if (!same) continue;
      throw std::invalid_argument(fmt::format("{} and {} are the same run of {}: give it once",
                                              runs[i].path.string(), runs[k].path.string(),
                                              names[i]));
    }
  }
}

ComparedEntry entry_of(const JudgedRun& run, const std::string& label) {
  ComparedEntry entry{label, run.estimator, "foreign", false, run.stored.landmark, {}, {}};
  entry.configuration.assign(run.stored.configuration.begin(), run.stored.configuration.end());
  for (const EstimatorRow& row : estimator_table()) {
    if (!run.stored.own || row.name != run.estimator) continue;
    entry.kind = to_string(row.kind);
    entry.oracle = row.oracle;
  }
  return entry;
}

void require_room(const JudgedRun& run, const Path& folder) {
  std::error_code ignored;
  if (std::filesystem::equivalent(run.path, folder, ignored)) {
    throw std::invalid_argument("--output would write over the run " + run.path.string());
  }
}

void write_description(const JudgedRun& run, const Path& folder) {
  const Path file = folder / run_files::kDescription;
  if (run.stored.own) {
    write_file(file, read_text_file(run.path / run_files::kDescription));
    return;
  }
  // JSON is YAML, and quotes whatever a name may hold.
  const auto text = [&](std::ostream& out) {
    out << "format: " << run_files::kFormat << "\nestimator: " << Json(run.estimator).dump()
        << "\nsequence:\n  name: " << Json(run.sequence->name).dump()
        << "\n  path: " << Json(std::filesystem::absolute(run.sequence->folder).string()).dump()
        << "\n  sha256: " << Json(run.sequence->sha256).dump() << "\n";
  };
  write_file(file, text);
}

}  // namespace

void report_runs(const std::vector<JudgedRun>& runs, const Path& output,
                 const std::string& command) {
  const Sequence& first = *runs.front().sequence;
  const std::vector<std::string> labels = labels_of(runs), names = names_of(runs, labels);
  require_distinct(runs, names);
  std::set<std::string> sequences;  // SHA-256
  Json sequence_names = Json::array();
  for (const JudgedRun& run : runs) {
    for (const std::string& label : labels) require_room(run, output / label);
    const bool is_new = sequences.insert(run.sequence->sha256).second;
    if (is_new) sequence_names.push_back(run.sequence->name);
    if (run.sequence->exact_truth != first.exact_truth) {
      throw std::invalid_argument("the truth of some sequences is exact and of others is not");
    }
  }
  Json json = comparison_json(command, first, std::nullopt, metric_table());
  json["sequence"]["count"] = sequences.size();
  json["sequence"]["names"] = sequence_names;
  std::filesystem::create_directories(output);
  const Path mark = output / kComparisonOutput.mark;
  write_file(mark, json.dump(1) + '\n');  // first: by it the folder is known
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const JudgedRun& run = runs[i];
    write_results(output / labels[i], run.stored.run, run.metrics);
    write_description(run, output / labels[i]);
    json["runs"].push_back(
        run_json(*run.sequence, entry_of(run, labels[i]), run.stored.run, run.metrics));
    json["runs"].back()["pooled"] = names[i];
    json["runs"].back()["sequence"] = {{"name", run.sequence->name},
                                       {"sha256", run.sequence->sha256}};
  }
  write_file(mark, json.dump(1) + '\n');
}

}  // namespace slammot
