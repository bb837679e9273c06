#include "eval/study/study_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <stdexcept>

#include "datasets/text/nearest_names.h"
#include "datasets/text/number.h"
#include "eval/configuration/registry.h"

namespace slammot {
namespace {

constexpr std::string_view kFigures[] = {"ranking",
                                         "camera_error",
                                         "landmark_error",
                                         "classification",
                                         "classification_against_sweep",
                                         "velocity",
                                         "trade_off",
                                         "anees",
                                         "landmark_anees",
                                         "anees_by_age",
                                         "error_axes",
                                         "lag"};
constexpr std::string_view kAgainstSweep = "against_sweep:";
constexpr std::string_view kAnees[] = {"anees_pose", "anees_position", "anees_rotation"};

bool wants(const Study& study, std::string_view figure) {
  return std::ranges::any_of(study.figures,
                             [&](const std::string& name) { return name.starts_with(figure); });
}

void require_numeric_sweep(const Study& study, const std::string& figure) {
  if (study.cells.front().sweep.size() != 1) {
    throw std::invalid_argument("figure '" + figure + "' needs one swept key");
  }
  for (const StudyCell& cell : study.cells) {
    const std::string& value = cell.sweep.front().second;
    if (!parse_number<double>(value)) {
      throw std::invalid_argument(fmt::format("figure '{}': '{}' is no number", figure, value));
    }
  }
}

void require_ideal_covariance(const Study& study) {
  std::set<std::string> groups, with_ideal;
  for (const StudyCell& cell : study.cells) {
    groups.insert(cell.group);
    const EstimatorKind kind = find_estimator(cell.estimator).kind;
    if (kind == EstimatorKind::kIdealCovariance) with_ideal.insert(cell.group);
  }
  if (groups == with_ideal) return;
  throw std::invalid_argument(
      "figure 'ranking' compares with the ideal sigma: add {estimator: ideal_covariance} to the "
      "estimators");
}

}  // namespace

void require_number(const std::string& key) {
  if (std::ranges::find(kAnees, key) != std::end(kAnees)) return;
  std::vector<std::string> known(std::begin(kAnees), std::end(kAnees));
  for (const Metric& metric : metric_table()) {
    if (metric.pooled == Pooled::kNot) continue;
    if (metric.key == key) return;
    known.push_back(metric.key);
  }
  throw std::invalid_argument(
      fmt::format("unknown number '{}', the nearest are {}", key, nearest_names(key, known)));
}

void require_figure(const std::string& figure) {
  if (figure.starts_with(kAgainstSweep)) return require_number(figure.substr(kAgainstSweep.size()));
  if (std::ranges::find(kFigures, figure) != std::end(kFigures)) return;
  throw std::invalid_argument(fmt::format("unknown figure '{}' (known: {}, {}NUMBER)", figure,
                                          fmt::join(kFigures, ", "), kAgainstSweep));
}

void check_figures(const Study& study) {
  if (wants(study, "velocity") && study.tracks.empty()) {
    throw std::invalid_argument("figure 'velocity' needs `record: {tracks: ..}`");
  }
  if (wants(study, "ranking")) require_ideal_covariance(study);
  for (const std::string& figure : study.figures) {
    if (figure == "classification_against_sweep" || figure.starts_with(kAgainstSweep)) {
      require_numeric_sweep(study, figure);
    }
  }
}

bool records_axes(const Study& study) { return wants(study, "error_axes"); }

}  // namespace slammot
