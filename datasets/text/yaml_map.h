// A YAML map whose every key must be known: take() each, then finish(). Refuses with file and line.
#pragma once

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <cmath>
#include <set>

#include "datasets/text/input_error.h"
#include "datasets/text/number.h"
#include "datasets/text/text_table.h"

namespace slammot {

class YamlMap {
 public:
  YamlMap(std::filesystem::path file, const YAML::Node& node, std::string name)
      : file_(std::move(file)), node_(node), name_(std::move(name)) {
    if (!node_.IsMap()) refuse(node_, fmt::format("{} must be a map of keys to values", name_));
    for (const auto& pair : node_) {
      const std::string& key = pair.first.Scalar();
      if (!present_.insert(key).second) refuse(pair.first, fmt::format("'{}' stands twice", key));
    }
  }

  bool has(const std::string& key) {
    asked_.insert(key);
    return present_.count(key) > 0;
  }

  YAML::Node take(const std::string& key) {
    if (!has(key)) refuse(node_, fmt::format("'{}' is missing in {}", key, name_));
    return static_cast<const YAML::Node&>(node_)[key];
  }

  YamlMap map(const std::string& key) { return {file_, take(key), fmt::format("'{}'", key)}; }

  // The maps of a list.
  std::vector<YamlMap> maps(const std::string& key) {
    const YAML::Node values = take(key);
    if (!values.IsSequence() || values.size() == 0) {
      refuse(values, fmt::format("'{}' must be a list of maps", key));
    }
    std::vector<YamlMap> result;
    for (const auto& value : values) {
      result.emplace_back(file_, value, fmt::format("entry {} of '{}'", result.size(), key));
    }
    return result;
  }

  std::string text(const std::string& key) {
    const YAML::Node value = take(key);
    if (!value.IsScalar()) refuse(value, fmt::format("'{}' must be one value", key));
    if (has_control_character(value.Scalar())) {
      refuse(value, fmt::format("'{}' contains a control character", key));
    }
    return value.Scalar();
  }

  double real(const std::string& key) { return real_of(take(key), key); }

  double positive(const std::string& key) {
    const double value = real(key);
    if (!(value > 0.0)) refuse(take(key), fmt::format("'{}' must be greater than zero", key));
    if (value < kSmallest) refuse(take(key), fmt::format("'{}' is not plausible", key));
    return value;
  }

  int positive_integer(const std::string& key) {
    const double value = positive(key);
    if (value != std::floor(value)) {
      refuse(take(key), fmt::format("'{}' must be a whole number", key));
    }
    return static_cast<int>(value);
  }

  // Whole numbers from zero on.
  std::vector<int> counts(const std::string& key) {
    std::vector<int> whole;
    for (const double value : list(key)) {
      if (value != std::floor(value) || value < 0.0) {
        refuse(take(key), fmt::format("'{}' must be whole numbers, none negative", key));
      }
      whole.push_back(static_cast<int>(value));
    }
    return whole;
  }

  std::vector<double> list(const std::string& key) {
    const YAML::Node values = take(key);
    if (!values.IsSequence()) refuse(values, fmt::format("'{}' must be a list of numbers", key));
    std::vector<double> numbers;
    for (const auto& value : values) numbers.push_back(real_of(value, key));
    return numbers;
  }

  template <int N>
  Eigen::Matrix<double, N, 1> vector(const std::string& key) {
    const std::vector<double> numbers = list(key);
    if (numbers.size() != N) {
      refuse(take(key), fmt::format("'{}' must have {} numbers, not {}", key, N, numbers.size()));
    }
    return Eigen::Map<const Eigen::Matrix<double, N, 1>>(numbers.data());
  }

  // After everything was taken: refuses the first key that nobody asked for.
  void finish() const {
    for (const auto& pair : node_) {
      const std::string& key = pair.first.Scalar();
      if (asked_.count(key) > 0) continue;
      refuse(pair.first, fmt::format("unknown key '{}' in {} (known: {})", key, name_,
                                     fmt::join(asked_, ", ")));
    }
  }

  [[noreturn]] void refuse(const YAML::Node& at, const std::string& reason) const {
    throw InputError(file_, at.Mark().line + 1, reason);
  }

 private:
  double real_of(const YAML::Node& value, const std::string& key) const {
    const std::string text = value.IsScalar() ? value.Scalar() : "";
    const auto number = parse_number<double>(text);
    if (!number) refuse(value, fmt::format("'{}' must be a number, not '{}'", key, text));
    if (!std::isfinite(*number)) refuse(value, fmt::format("'{}' must be a finite number", key));
    if (!(std::abs(*number) <= kLargest)) refuse(value, fmt::format("'{}' is not plausible", key));
    return *number;
  }

  std::filesystem::path file_;
  YAML::Node node_;
  std::string name_;
  std::set<std::string> present_;
  std::set<std::string> asked_;
};

// Lines that end in CR alone end in LF, as yaml-cpp knows them.
inline std::string with_line_feeds(std::string text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\r' && (i + 1 == text.size() || text[i + 1] != '\n')) text[i] = '\n';
  }
  return text;
}

// A YAML document; throws InputError with file and line for what is no YAML.
inline YAML::Node load_yaml_node(const std::filesystem::path& file, const std::string& text) {
  require_utf8(file, text);
  try {
    return YAML::Load(with_line_feeds(text));
  } catch (const YAML::Exception& error) {
    throw InputError(file, error.mark.line + 1, error.msg);
  }
}

inline YamlMap load_yaml(const std::filesystem::path& file, const std::string& text) {
  return {file, load_yaml_node(file, text), "the file"};
}

}  // namespace slammot
