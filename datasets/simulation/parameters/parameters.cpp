#include "datasets/simulation/parameters/parameters.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>

#include "datasets/text/nearest_names.h"
#include "datasets/text/number.h"

namespace slammot {
namespace {

constexpr int kMostCounted = 100000;  // frames, points or pixels along a side; ends in minutes

template <typename T>
T parse(const Parameter& parameter, const std::string& text) {
  const std::optional<T> number = parse_number<T>(text);
  if (!number || !std::isfinite(static_cast<double>(*number))) {
    throw std::invalid_argument(
        fmt::format("{}: '{}' is not {}", parameter.name, text,
                    std::is_integral_v<T> ? "a whole number" : "a finite number"));
  }
  const T value = *number;
  if (static_cast<double>(value) < parameter.lowest) {
    const bool open = parameter.lowest == kAbove0;
    throw std::invalid_argument(
        open ? fmt::format("{}: must be greater than 0, not {}", parameter.name, text)
             : fmt::format("{}: must be at least {}, not {}", parameter.name, parameter.lowest,
                           text));
  }
  if (std::is_integral_v<T> && value > static_cast<T>(kMostCounted)) {
    throw std::invalid_argument(
        fmt::format("{}: must be at most {}, not {}", parameter.name, kMostCounted, text));
  }
  return value;
}

void set(const Parameter& parameter, const std::string& text) {
  struct Setter {
    const Parameter& parameter;
    const std::string& text;
    void operator()(double* value) const { *value = parse<double>(parameter, text); }
    void operator()(int* value) const { *value = parse<int>(parameter, text); }
    void operator()(std::optional<double>* value) const { *value = parse<double>(parameter, text); }
  };
  std::visit(Setter{parameter, text}, parameter.value);
}

struct ToText {
  std::string operator()(const double* value) const { return fmt::format("{}", *value); }
  std::string operator()(const int* value) const { return fmt::format("{}", *value); }
  std::string operator()(const std::optional<double>* value) const {
    return *value ? fmt::format("{}", **value) : "computed";
  }
};

std::vector<std::string> names(const Parameters& parameters) {
  std::vector<std::string> names;
  for (const Parameter& p : parameters) names.push_back(p.name);
  return names;
}

}  // namespace

Parameters joined(Parameters a, Parameters b) {
  std::move(b.begin(), b.end(), std::back_inserter(a));
  return a;
}

void apply(const ScenarioOverrides& overrides, std::string_view scenario,
           const Parameters& parameters) {
  const std::string prefix = std::string(scenario) + ".";
  for (const auto& [key, text] : overrides) {
    const std::string name = key.starts_with(prefix) ? key.substr(prefix.size()) : key;
    const auto found = std::find_if(parameters.begin(), parameters.end(),
                                    [&](const Parameter& p) { return p.name == name; });
    if (found == parameters.end()) {
      throw std::invalid_argument(fmt::format("unknown key '{}' of scenario {}, the nearest are {}",
                                              key, scenario,
                                              nearest_names(name, names(parameters))));
    }
    set(*found, text);
  }
}

std::vector<ScenarioParameter> describe(const Parameters& parameters) {
  std::vector<ScenarioParameter> described;
  for (const Parameter& p : parameters) {
    described.push_back({p.name, p.help, std::visit(ToText{}, p.value)});
  }
  return described;
}

}  // namespace slammot
