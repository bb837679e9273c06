#include "eval/configuration/configuration.h"

#include <algorithm>
#include <set>
#include <stdexcept>

#include "datasets/text/nearest_names.h"
#include "datasets/text/yaml_map.h"

namespace slammot {
namespace {

int line_of(const YAML::Node& node) { return node.Mark().line + 1; }

// The parent of `x.name` is the key itself where `x` is also the head of other keys.
std::string join(const std::string& prefix, const std::string& name) {
  if (prefix.empty()) return name;
  return name == "name" ? prefix : prefix + "." + name;
}

// `entries` counts all that are visited: an alias may name the map it stands in, or be one of many
// that name each other.
void flatten(const YAML::Node& node, const std::string& prefix, const std::filesystem::path& file,
             int& entries, std::vector<Assignment>& out) {
  constexpr int kMost = 1000;
  for (const auto& entry : node) {
    const int line = line_of(entry.first);
    if (++entries > kMost)
      throw InputError(file, line, "has too many keys, or a map within itself");
    if (!entry.first.IsScalar()) throw InputError(file, line, "a key must be one word");
    const std::string key = join(prefix, entry.first.Scalar());
    if (entry.second.IsMap()) {
      flatten(entry.second, key, file, entries, out);
    } else if (entry.second.IsScalar()) {
      out.push_back({key, entry.second.Scalar(), line});
    } else {
      throw InputError(file, line, "'" + key + "' must be one value");
    }
  }
}

void refuse_repeated(const std::vector<Assignment>& assignments,
                     const std::filesystem::path& file) {
  std::set<std::string> seen;
  for (const Assignment& a : assignments) {
    if (!seen.insert(a.key).second) throw InputError(file, a.line, "'" + a.key + "' stands twice");
  }
}

}  // namespace

Assignment parse_assignment(const std::string& text) {
  const size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) {
    throw std::invalid_argument("'" + text + "' is not of the form key=value");
  }
  return {text.substr(0, equals), text.substr(equals + 1), 0};
}

void assign(Configuration& configuration, const Assignment& assignment) {
  refuse_gone(assignment);
  const auto& keys = configuration_keys();
  const auto key = std::find_if(keys.begin(), keys.end(),
                                [&](const auto& k) { return k.name == assignment.key; });
  if (key == keys.end()) {
    std::vector<std::string> names;
    for (const ConfigurationKey& k : keys) names.push_back(k.name);
    throw std::invalid_argument("unknown key '" + assignment.key + "', the nearest are " +
                                nearest_names(assignment.key, names));
  }
  try {
    key->set(configuration, assignment.value);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(assignment.key + ": " + error.what());
  }
  configuration.given.insert(assignment.key);
}

std::vector<Assignment> read_assignments(const std::filesystem::path& file) {
  YAML::Node root = load_yaml_node(file, read_text_file(file));
  if (!root.IsDefined() || root.IsNull()) return {};
  if (!root.IsMap()) throw InputError(file, line_of(root), "must be a map of keys to values");
  if (root["format"] && root["configuration"]) root = root["configuration"];
  std::vector<Assignment> assignments;
  int entries = 0;
  flatten(root, "", file, entries, assignments);
  refuse_repeated(assignments, file);
  return assignments;
}

std::vector<Assignment> load_configuration(Configuration& configuration,
                                           const std::filesystem::path& file) {
  std::vector<Assignment> assignments = read_assignments(file);
  for (const Assignment& assignment : assignments) {
    try {
      assign(configuration, assignment);
    } catch (const std::invalid_argument& error) {
      throw InputError(file, assignment.line, error.what());
    }
  }
  return assignments;
}

std::vector<std::pair<std::string, std::string>> key_values(const Configuration& configuration) {
  std::vector<std::pair<std::string, std::string>> all;
  for (const ConfigurationKey& key : configuration_keys()) {
    all.emplace_back(key.name, key.get(configuration));
  }
  return all;
}

std::vector<std::string> differing_keys(const Configuration& a, const Configuration& b) {
  std::vector<std::string> keys;
  for (const ConfigurationKey& key : configuration_keys()) {
    if (key.get(a) != key.get(b)) keys.push_back(key.name);
  }
  return keys;
}

}  // namespace slammot
