#include "eval/study/study_cross.h"

#include <fmt/format.h>

#include <map>

#include "eval/configuration/registry.h"

namespace slammot {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kScenarioPrefix = "scenario.";

// All combinations of the swept values, the last key fastest.
std::vector<Settings> combinations(const std::vector<SweptKey>& sweep) {
  constexpr std::size_t kMost = 100000;
  std::vector<Settings> result{{}};
  for (const SweptKey& key : sweep) {
    if (result.size() > kMost / key.values.size()) {
      throw std::invalid_argument(fmt::format("'sweep' has more than {} combinations", kMost));
    }
    std::vector<Settings> longer;
    for (const Settings& so_far : result) {
      for (const std::string& value : key.values) {
        longer.push_back(so_far);
        longer.back().emplace_back(key.key, value);
      }
    }
    result = std::move(longer);
  }
  return result;
}

StudyCell cell_of(const NamedSettings& scenario, const Settings& values,
                  const NamedSettings& estimator, const Settings& all) {
  StudyCell cell;
  cell.group = scenario.label;
  cell.label = estimator.label;
  cell.line = scenario.line;
  if (scenario.recorded) {
    cell.sequence = scenario.name;
  } else {
    cell.scenario = scenario.name;
  }
  cell.estimator = estimator.name;
  cell.sweep = values;
  find_estimator(cell.estimator);
  for (const auto& [key, value] : scenario.settings) cell.scene[key] = value;
  for (const auto& [key, value] : all) assign(cell.configuration, {key, value});
  for (const auto& [key, value] : values) {
    cell.group += fmt::format(", {} = {}", key, value);
    if (is_of_scenario(key)) {
      cell.scene[key.substr(kScenarioPrefix.size())] = value;
    } else {
      assign(cell.configuration, {key, value});
    }
  }
  for (const auto& [key, value] : estimator.settings) assign(cell.configuration, {key, value});
  return cell;
}

// What the runs of a cell depend on beside the seed.
std::string computation(const StudyCell& cell) {
  const std::string_view unread = find_estimator(cell.estimator).unread;
  Json configuration = Json::object();
  const Json all = configuration_json(cell);
  for (const auto& [key, value] : all.items()) {
    if (unread.empty() || !key.starts_with(unread)) configuration[key] = value;
  }
  return Json{cell.scenario, cell.sequence, cell.scene, cell.estimator, configuration}.dump();
}

}  // namespace

nlohmann::ordered_json configuration_json(const StudyCell& cell) {
  Configuration configuration = cell.configuration;
  find_estimator(cell.estimator).adjust(configuration);
  Json json = Json::object();
  for (const auto& [key, value] : key_values(configuration)) json[key] = value;
  return json;
}

bool is_of_scenario(std::string_view key) { return key.starts_with(kScenarioPrefix); }

Settings settings_in(std::string_view text) {
  Settings result;
  for (size_t at = text.find(kSetLine); at != text.npos; at = text.find(kSetLine, at + 1)) {
    if (at > 0 && text[at - 1] != '\n') continue;
    const std::string_view line = text.substr(at, text.find('\n', at) - at);
    const Assignment assignment = parse_assignment(std::string(line.substr(kSetLine.size())));
    Configuration scratch;
    assign(scratch, assignment);
    result.emplace_back(assignment.key, assignment.value);
  }
  return result;
}

void require_free(const Settings& set, const std::vector<NamedSettings>& estimators,
                  const std::vector<SweptKey>& sweep) {
  for (const auto& [key, value] : set) {
    for (const SweptKey& swept : sweep) {
      if (swept.key == key) throw std::invalid_argument("--set " + key + ": the study sweeps it");
    }
    for (const NamedSettings& row : estimators) {
      for (const auto& [own, its] : row.settings) {
        if (own != key) continue;
        throw std::invalid_argument("--set " + key + ": the study sets it for '" + row.label + "'");
      }
    }
  }
}

std::vector<StudyCell> cross(const std::vector<NamedSettings>& scenarios,
                             const std::vector<SweptKey>& sweep,
                             const std::vector<NamedSettings>& estimators, const Settings& all) {
  std::vector<StudyCell> cells;
  std::map<std::string, int> computed;
  for (const NamedSettings& scenario : scenarios) {
    for (const Settings& values : combinations(sweep)) {
      for (const NamedSettings& estimator : estimators) {
        StudyCell& cell = cells.emplace_back(cell_of(scenario, values, estimator, all));
        const int index = static_cast<int>(cells.size()) - 1;
        cell.computed_by = computed.emplace(computation(cell), index).first->second;
      }
    }
  }
  return cells;
}

}  // namespace slammot
