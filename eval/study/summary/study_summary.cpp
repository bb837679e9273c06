#include "eval/study/summary/study_summary.h"

#include <cmath>
#include <fstream>

#include "datasets/output/output_files.h"
#include "eval/configuration/registry.h"
#include "eval/output/metrics_json.h"
#include "eval/pooling/estimate_json.h"
#include "eval/pooling/paired_errors.h"
#include "eval/statistics/statistics.h"
#include "eval/study/study_sequence.h"
#include "eval/study/summary/study_cell.h"

namespace slammot {
namespace {

// The lines of a file that belong to one cell after another: both files are sorted by cell.
class CellLines {
 public:
  explicit CellLines(const std::filesystem::path& file) : file_(file), in_(file, std::ios::binary) {
    if (!in_) throw InputError(file, 0, "cannot be read: is the study complete?");
    try {
      advance();
    } catch (const Json::exception&) {
      refuse();
    }
  }

  void visit(std::size_t cell, const std::function<void(const Json&)>& visitor) try {
    for (; !next_.is_null() && next_.at("cell").get<std::size_t>() == cell; advance()) {
      visitor(next_);
    }
  } catch (const Json::exception&) {
    refuse();
  }

 private:
  void advance() {
    std::string line;
    ++line_;
    next_ = std::getline(in_, line) ? Json::parse(line) : Json();
  }
  [[noreturn]] void refuse() const {
    throw InputError(file_, line_, "is not the line of a finished run");
  }

  std::filesystem::path file_;
  std::ifstream in_;
  int line_ = 0;
  Json next_;
};

// What is kept of a cell while its group is summarised.
struct Finished {
  Json json;
  EstimatorKind kind;
  std::map<std::uint64_t, double> position_rmse, stated_sigma, pose_nees;  // by seed
};

Finished summarise_cell(const Study& study, std::size_t index, CellLines& results,
                        CellLines& timing) {
  const StudyCell& cell = study.cells[index];
  CellSummary summary(cell, study.metrics);
  results.visit(index, [&](const Json& run) { summary.add(run); });
  timing.visit(index, [&](const Json& run) { summary.add_timing(run); });
  return {summary.json(), find_estimator(cell.estimator).kind, summary.position_rmse(),
          summary.stated_sigma(), summary.pose_nees()};
}

// Position RMSE of a - b by seed, where both finished; a diverged run loses.
Json pair_json(const Finished& a, const Finished& b) {
  PairedErrors errors;
  for (const auto& [seed, error] : a.position_rmse) {
    const auto other = b.position_rmse.find(seed);
    if (other != b.position_rmse.end()) errors.add(error, other->second);
  }
  return {
      {"a", a.json.at("label")},   {"b", b.json.at("label")},
      {"pairs", errors.pairs()},   {"wins_a", errors.wins_a()},
      {"wins_b", errors.wins_b()}, {"position_rmse_difference_m", json_of(errors.difference())}};
}

double median_of(const std::vector<double>& samples) { return median(samples); }

// The RMSE of each run over the ideal sigma for its seed. A few failed runs can dominate the RMSE
// of all runs; the median describes a typical one.
Json over_ideal(const Finished& cell, const Finished& ideal) {
  std::vector<double> ratios, errors, sigmas;
  Json runs = Json::array();
  for (const auto& [seed, rmse] : cell.position_rmse) {
    const auto sigma = ideal.stated_sigma.find(seed);
    if (sigma == ideal.stated_sigma.end() || !std::isfinite(rmse)) continue;
    const auto nees = cell.pose_nees.find(seed);
    ratios.push_back(rmse / sigma->second);
    errors.push_back(rmse);
    sigmas.push_back(sigma->second);
    runs.push_back({{"seed", seed},
                    {"position_rmse_m", rmse},
                    {"ideal_sigma_m", sigma->second},
                    {"nees_pose", nees == cell.pose_nees.end() ? kUndefined : nees->second}});
  }
  return {{"runs", runs},
          {"position", root_mean_square(errors) / root_mean_square(sigmas)},
          {"median", json_of(bootstrap(ratios, median_of))}};
}

bool is_ideal(const Finished& cell) { return cell.kind == EstimatorKind::kIdealCovariance; }

void add_ideal(std::vector<Finished>& cells) {
  for (const Finished& ideal : cells) {
    if (!is_ideal(ideal) || !ideal.json.contains("per_frame")) continue;
    for (Finished& cell : cells) {
      // Not a batch's, which has smoothed: this covariance is a filter's.
      const bool filters = cell.kind != EstimatorKind::kBatch;
      if (is_ideal(cell) || !cell.json.contains("per_frame") || !filters) continue;
      cell.json["rmse_over_ideal"] = over_ideal(cell, ideal);
    }
  }
}

Json group_json(const StudyCell& first, std::vector<Finished> cells) {
  const bool single = is_single_run(first);
  Json group = {{"name", first.group},
                {"scenario", first.scenario},
                {"sequence", first.sequence.empty() ? Json() : Json(first.sequence.string())},
                {"seeds", first.sequence.empty() ? "simulations"
                          : single               ? "one run"
                                                 : "noise"},
                {"scene", first.scene}};
  group["sweep"] = Json::object();
  for (const auto& [key, value] : first.sweep) group["sweep"][key] = value;
  add_ideal(cells);
  group["cells"] = Json::array();
  group["pairs"] = Json::array();
  for (std::size_t a = 0; a < cells.size(); ++a) {
    for (std::size_t b = a + 1; b < cells.size(); ++b) {
      if (is_ideal(cells[a]) || is_ideal(cells[b])) continue;
      group["pairs"].push_back(pair_json(cells[a], cells[b]));
    }
  }
  for (Finished& cell : cells) group["cells"].push_back(std::move(cell.json));
  return group;
}

Json latex_json(const std::optional<LatexTable>& latex) {
  if (!latex) return nullptr;
  return {{"columns", latex->columns}, {"labels", latex->labels}, {"caption", latex->caption}};
}

Json heading(const Study& study, const Provenance& made_by) {
  Json json = {{"format", "slammot-summary-2"},
               {"version", SLAMMOT_VERSION},
               {"provenance", json_of(made_by)},
               {"name", study.name},
               {"title", study.title},
               {"runs", study.runs},
               {"first_seed", study.first_seed},
               {"figures", study.figures},
               {"latex", latex_json(study.latex)},
               {"metrics", metric_table_json(study.metrics)},
               {"groups", Json::array()}};
  if (study.reference) {
    json["reference"] = {{"label", study.reference->label},
                         {"static", study.reference->statics},
                         {"moving", study.reference->movings}};
  }
  return json;
}

}  // namespace

Json summarise_study(const Study& study, const std::filesystem::path& folder,
                     const Provenance& made_by) {
  require_whole(folder);
  Json json = heading(study, made_by);
  CellLines results(folder / "results.jsonl"), timing(folder / "timing.jsonl");
  for (std::size_t i = 0; i < study.cells.size();) {
    const StudyCell& first = study.cells[i];
    std::vector<Finished> cells;
    for (; i < study.cells.size() && study.cells[i].group == first.group; ++i) {
      cells.push_back(summarise_cell(study, i, results, timing));
    }
    json["groups"].push_back(group_json(first, std::move(cells)));
  }
  return json;
}

}  // namespace slammot
