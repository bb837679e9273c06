// A study: scenarios x swept values x estimators x seeds, read from a YAML file (docs/formats.md).
//
// Every estimator of a group (one scenario with one combination of swept values) sees the same
// measurements: those of its scenario's seed.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "datasets/simulation/scenario.h"
#include "eval/configuration/configuration.h"
#include "eval/metrics/metric.h"

namespace slammot {

// One estimator in one group.
struct StudyCell {
  std::string group;  // label of the scenario and of the swept values: its cells are paired
  std::string label;  // of the estimator
  std::string scenario;
  int line = 0;                    // of the scenario, in the study's file
  std::filesystem::path sequence;  // recorded, in the place of a scenario
  ScenarioOverrides scene;
  std::string estimator;
  Configuration configuration;
  std::vector<std::pair<std::string, std::string>> sweep;  // key, value
  // The first cell that is the same but for its labels and for keys that its estimator never
  // reads: the runs of both are computed there.
  int computed_by = 0;
};

// Labels that somebody published, shown beside ours: right, wrong, undecided.
struct ReferenceLabels {
  std::string label;
  std::array<int, 3> statics{}, movings{};
};

// A table for a paper: numbers of each cell, and what scenarios and estimators are called in it.
struct LatexTable {
  std::vector<std::string> columns;
  std::map<std::string, std::string> labels;
  std::string caption;
};

struct Study {
  std::string name;
  std::string title;
  std::string text;  // the file as it was read
  int runs = 50;
  std::uint64_t first_seed = 1;
  std::vector<StudyCell> cells;
  std::map<std::string, std::string>
      recordings;                    // SHA-256 of each recorded sequence, by its folder
  std::vector<int> tracks;           // landmarks whose velocity is recorded in every frame
  std::vector<std::string> figures;  // what the report draws
  std::optional<ReferenceLabels> reference;
  std::optional<LatexTable> latex;
  MetricTable metrics = metric_table();  // those pooled over the runs

  // Runs of all cells. Throws std::invalid_argument if they are too many to be counted.
  int tasks() const;
  // Of a recorded sequence to which no noise is added every seed is the same run: one is enough.
  int runs_of(std::size_t cell) const;
  bool has_task(int task) const;
  bool computes(int task) const;  // not those that another cell computes as well
  std::uint64_t seed(int run) const { return first_seed + static_cast<std::uint64_t>(run); }
};

// The file alone. `settings` (KEY=VALUE) hold for every cell and become lines `# --set KEY=VALUE`
// of the text, which are read again from there: a study is its text. Throws InputError,
// also for a setting that is none, or that the study sets or sweeps itself.
Study parse_study(const std::filesystem::path& file, const std::vector<std::string>& settings = {});

// Throws the same: everything is checked here, the scenarios by simulating each, before the first
// run.
Study read_study(const std::filesystem::path& file, const std::vector<std::string>& settings = {});

}  // namespace slammot
