#include "eval/output/in_force.h"

#include <fmt/format.h>

#include <algorithm>

#include "datasets/text/printable.h"

namespace slammot {
namespace {

bool is_without_effect(const Mechanism& m) { return !m.is_on && !m.because.empty(); }

// The names of all runs' mechanisms, each once, in their order.
std::vector<std::string> names_of(const std::vector<NamedMetrics>& results) {
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

std::string in_force_table(const std::vector<NamedMetrics>& results) {
  const std::vector<std::string> names = names_of(results);
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

std::string without_effect_lines(const std::vector<NamedMetrics>& results) {
  std::string text;
  for (const NamedMetrics& r : results) {
    std::vector<std::string> said;
    for (const Mechanism& m : r.metrics.in_force.value_or(InForce{})) {
      if (is_without_effect(m)) said.push_back(fmt::format("{} ({})", m.key, m.because));
    }
    if (said.empty()) continue;
    text += printable(fmt::format("{}: asked for, but without effect: {}", r.label,
                                  fmt::join(said, "; "))) +
            "\n";
  }
  return text;
}

}  // namespace slammot
