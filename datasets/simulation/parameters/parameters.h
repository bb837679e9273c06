// The settable parameters of a scenario: a row for each number, pointing into the scenario's
// options.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace slammot {

// Values by key; `radius` and `circle.radius` are the same key of the scenario `circle`.
using ScenarioOverrides = std::map<std::string, std::string>;

struct ScenarioParameter {
  std::string name;
  std::string help;
  std::string value;  // by default
};

inline constexpr double kAbove0 = 1e-9;  // the lowest value of what must be positive

struct Parameter {
  std::string name;
  std::string help;
  std::variant<double*, int*, std::optional<double>*> value;  // optional: computed when not set
  double lowest = 0.0;
};
using Parameters = std::vector<Parameter>;

// `a` followed by `b`.
Parameters joined(Parameters a, Parameters b);

// Sets what is overridden, by its name or as `scenario.name`. Throws std::invalid_argument for an
// unknown key (naming the nearest known ones) and for a value that is not allowed.
void apply(const ScenarioOverrides& overrides, std::string_view scenario,
           const Parameters& parameters);

// With the values as text.
std::vector<ScenarioParameter> describe(const Parameters& parameters);

}  // namespace slammot
