// How a key of the configuration is read from text and written as text: numbers, choices, flags.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "datasets/text/number.h"
#include "eval/configuration/configuration.h"
#include "eval/configuration/model_names.h"

namespace slammot {

// What a number may be. The text follows "must be".
struct Range {
  bool (*holds)(double);
  const char* text;
};
inline constexpr Range kPositive{[](double x) { return x > 0.0; }, "greater than 0"};
inline constexpr Range kNotNegative{[](double x) { return x >= 0.0; }, "at least 0"};
inline constexpr Range kAboveOne{[](double x) { return x > 1.0; }, "greater than 1"};
inline constexpr Range kFromMinusOne{[](double x) { return x >= -1.0; }, "at least -1"};
inline constexpr Range kFinite{[](double) { return true; }, "a finite number"};
// Each past pose is six rows of the covariance.
inline constexpr Range kPastPoses{[](double x) { return x >= 0.0 && x <= 500.0; }, "from 0 to 500"};
inline constexpr Range kUpToThousand{[](double x) { return x >= 1.0 && x <= 1000.0; },
                                     "from 1 to 1000"};
inline constexpr Range kUpToOne{[](double x) { return x > 0.0 && x <= 1.0; },
                                "above 0 and at most 1"};

template <typename T>
T parse_finite(const std::string& text) {
  const std::optional<T> value = parse_number<T>(text);
  if (!value || !std::isfinite(static_cast<double>(*value))) {
    const bool whole = std::is_integral_v<T>;
    throw std::invalid_argument(
        fmt::format("'{}' is not {}", text, whole ? "a whole number" : "a finite number"));
  }
  return *value;
}

template <typename T>
T parse_in(const std::string& text, const Range& range) {
  const T value = parse_finite<T>(text);
  if (!range.holds(static_cast<double>(value))) {
    throw std::invalid_argument(fmt::format("'{}' must be {}", text, range.text));
  }
  return value;
}

inline std::string to_text(double value) {
  return fmt::format("{}", value);
}  // shortest that reads back
inline std::string to_text(int value) { return std::to_string(value); }
template <typename T>
std::string to_text(const std::optional<T>& value) {
  return value ? to_text(*value) : "sequence";
}

inline void read(double& field, const std::string& text, const Range& range) {
  field = parse_in<double>(text, range);
}
inline void read(int& field, const std::string& text, const Range& range) {
  field = parse_in<int>(text, range);
}
template <typename T>
void read(std::optional<T>& field, const std::string& text, const Range& range) {
  field.reset();
  if (text != "sequence") field = parse_in<T>(text, range);
}

// `field` maps a configuration, const or not, to a reference to one of its numbers.
template <typename Field>
ConfigurationKey number(std::string name, std::string help, Range range, Field field) {
  return {std::move(name), std::move(help),
          [=](Configuration& c, const std::string& text) { read(field(c), text, range); },
          [=](const Configuration& c) -> std::string { return to_text(field(c)); }};
}

// One of a closed list of choices (estimation/options.h).
template <typename Enum, typename Field>
ConfigurationKey option(std::string name, const std::string& help,
                        std::vector<Choice<Enum>> choices, Field field) {
  std::vector<std::string> names;
  for (const auto& c : choices) names.emplace_back(c.name);
  const std::string all = fmt::format("{}", fmt::join(names, ", "));
  auto set = [=](Configuration& c, const std::string& text) {
    const auto found = std::find(names.begin(), names.end(), text);
    if (found == names.end()) {
      throw std::invalid_argument(fmt::format("'{}' is not one of {}", text, all));
    }
    field(c) = choices[static_cast<size_t>(found - names.begin())].value;
  };
  auto get = [=](const Configuration& c) -> std::string {
    for (const auto& choice : choices) {
      if (choice.value == field(c)) return std::string(choice.name);
    }
    throw std::logic_error("a choice without a name");
  };
  return {std::move(name), fmt::format("{}: {}", help, all), set, get};
}

// One of a list of names, which may grow with the tables of models.
template <typename Field>
ConfigurationKey choice(std::string name, const std::string& help, std::vector<std::string> names,
                        Field field) {
  const std::string all = fmt::format("{}", fmt::join(names, ", "));
  auto set = [=](Configuration& c, const std::string& text) {
    if (std::find(names.begin(), names.end(), text) == names.end()) {
      throw std::invalid_argument(fmt::format("'{}' is not one of {}", text, all));
    }
    field(c) = text;
  };
  return {std::move(name), fmt::format("{}: {}", help, all), set,
          [=](const Configuration& c) -> std::string { return field(c); }};
}

template <typename Field>
ConfigurationKey flag(std::string name, const std::string& help, Field field) {
  auto set = [=](Configuration& c, const std::string& text) {
    if (text != "true" && text != "false") {
      throw std::invalid_argument(fmt::format("'{}' is not one of true, false", text));
    }
    field(c) = text == "true";
  };
  return {std::move(name), help + ": true, false", set,
          [=](const Configuration& c) -> std::string { return field(c) ? "true" : "false"; }};
}

template <typename Enum, std::size_t N>
std::vector<Choice<Enum>> listed(const Choice<Enum> (&choices)[N]) {
  return {std::begin(choices), std::end(choices)};
}

}  // namespace slammot
