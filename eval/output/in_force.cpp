#include "eval/output/in_force.h"

#include <fmt/format.h>

#include <algorithm>

#include "datasets/text/printable.h"

namespace slammot {
namespace {

constexpr const char *kOn = "on", *kOff = "off";

bool is_without_effect(const Mechanism& m) { return !m.is_on && !m.because.empty(); }

// The names of all runs' mechanisms, each once, in their order.
std::vector<std::string> mechanisms_of(const std::vector<NamedMetrics>& results) {
  std::vector<std::string> names;
  for (const NamedMetrics& r : results) {
    for (const Mechanism& m : r.metrics.in_force.value_or(InForce{})) {
      if (std::ranges::find(names, m.name) == names.end()) names.push_back(m.name);
    }
  }
  return names;
}

std::string cell(const InForce& in_force, const std::string& name) {
  const auto m = std::ranges::find(in_force, name, &Mechanism::name);
  if (m == in_force.end()) return "-";
  if (m->is_on) return fmt::format("on, {}", m->acted);
  return is_without_effect(*m) ? "off*" : "off";
}

}  // namespace

Json json_of(const InForce& in_force) {
  Json json = Json::array();
  for (const Mechanism& m : in_force) {
    json.push_back({{"name", m.name},
                    {"key", m.key},
                    {"state", m.is_on ? kOn : kOff},
                    {"because", m.because},
                    {"acted", m.acted}});
  }
  return json;
}

InForce in_force_of(const Json& json) {
  InForce in_force;
  for (const Json& m : json) {
    const auto text = [&](const char* key) { return printable(m.at(key).get<std::string>()); };
    in_force.push_back({text("name"), text("key"), text("state") == kOn, text("because"),
                        count_of(m.at("acted"))});
  }
  return in_force;
}

std::string in_force_table(const std::vector<NamedMetrics>& results) {
  const std::vector<std::string> names = mechanisms_of(results);
  if (names.empty()) return "";
  std::vector<TextRow> rows = {{"in force"}};
  for (const std::string& name : names) rows.push_back({printable(name)});
  for (const NamedMetrics& r : results) {
    if (!r.metrics.in_force) continue;  // made elsewhere
    rows.front().push_back(printable(r.label));
    for (std::size_t i = 0; i < names.size(); ++i) {
      rows[i + 1].push_back(r.metrics.in_force->empty() ? "states nothing"
                                                        : cell(*r.metrics.in_force, names[i]));
    }
  }
  return aligned(rows, 1) + "on, N: it acted N times. off*: asked for, but without effect.\n";
}

namespace {

/// Another option took it away: the user set two that do not go together. What the run itself rules
/// out (landmarks known beforehand keep the scale) stands in the table and needs no line.
bool is_conflict(const Mechanism& m) {
  return is_without_effect(m) && m.because.find('=') != std::string::npos;
}

}  // namespace

std::string without_effect_lines(const std::vector<NamedMetrics>& results) {
  std::string text;
  for (const NamedMetrics& r : results) {
    std::vector<std::string> said;
    for (const Mechanism& m : r.metrics.in_force.value_or(InForce{})) {
      if (is_conflict(m)) said.push_back(fmt::format("{} ({})", m.key, m.because));
    }
    if (said.empty()) continue;
    text += printable(fmt::format("{}: asked for, but without effect: {}", r.label,
                                  fmt::join(said, "; "))) +
            "\n";
  }
  return text;
}

}  // namespace slammot
