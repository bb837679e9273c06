#include "eval/configuration/preset.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace slammot {
namespace {

constexpr const char* kThesisName = "thesis";

const std::vector<Assignment> kThesis = {
    {"landmark", "dynamic_inverse_depth"},
    {"collapse", "drop"},
    {"gate.given_others", "1"},
    {"classifier", "thesis"},
    {"labels", "one_way"},
    {"labels.sightings", "2"},
    {"labels.memory", "0"},  // one-way labels leave nothing to remember, whatever it says
    {"labels.births", "static_first"},
    {"policy.movers", "joint"},
    {"motion.adaptive", "false"},
    {"prior.source", "fixed"},
    {"prior.steady_time", "0"},
    {"gauge", "none"},
    {"ekf.second_order", "false"},
};

struct Preset {
  std::string name;
  std::vector<Assignment> settings;
};

const std::vector<Preset>& presets() {
  static const std::vector<Preset> all = {{"default", {}}, {kThesisName, kThesis}};
  return all;
}

struct LeftOpen {
  std::string_view key;
  std::string_view why;
};

constexpr LeftOpen kLeftOpen[] = {
    {"pixel_sigma", "as the sequence states its noise"},
    {"motion.acceleration", "as the sequence states the camera's noise"},
    {"motion.angular_acceleration", "as the sequence states the camera's noise"},
    {"motion.discretisation",
     "Q of full rank, which a factor graph can invert; the author's program has impulse"},
    {"prior.inverse_depth", "rho0: what the scenario shows at first sight, or a sequence states"},
    {"prior.inverse_depth_sigma", "its spread, likewise"},
    {"prior.max_speed", "|v|max: that of the scenario's movers, or as a sequence states it"},
    {"prior.acceleration", "noise of what may move: as the sequence states it"},
    {"gate.probability", "no gate is described, and wrong matches need one; 1: none"},
    {"policy.max_landmarks", "bounds the cost of a frame"},
    {"policy.max_visible", "births wait while so many are measured: bounds the cost of a frame"},
    {"policy.prune_after", "frames: a map without pruning keeps every wrong match"},
};

const ConfigurationKey& key_named(std::string_view name) {
  const auto& keys = configuration_keys();
  return *std::ranges::find_if(keys, [&](const auto& key) { return key.name == name; });
}

}  // namespace

std::vector<std::string> preset_names() {
  std::vector<std::string> names;
  for (const Preset& preset : presets()) names.push_back(preset.name);
  return names;
}

std::vector<Assignment> preset_settings(const std::string& name) {
  for (const Preset& preset : presets()) {
    if (preset.name == name) return preset.settings;
  }
  throw std::invalid_argument(
      fmt::format("'{}' is not one of {}", name, fmt::join(preset_names(), ", ")));
}

void take_preset(Configuration& configuration, const std::string& preset) {
  std::vector<Assignment> settings;
  const Configuration defaults;
  for (const Assignment& of_before : preset_settings(configuration.preset)) {
    settings.push_back({of_before.key, key_named(of_before.key).get(defaults)});
  }
  for (const Assignment& setting : preset_settings(preset)) settings.push_back(setting);
  for (const Assignment& setting : settings) {
    if (configuration.given.contains(setting.key)) continue;
    key_named(setting.key).set(configuration, setting.value);
  }
  configuration.preset = preset;
}

std::vector<std::pair<std::string, std::string>> left_open_by_the_thesis(
    const Configuration& resolved) {
  std::vector<std::pair<std::string, std::string>> all;
  if (resolved.preset != kThesisName) return all;
  all.emplace_back("scene",
                   "as the sequence has it: radius, rate and speeds of the thesis's "
                   "scenes are chosen by the scenario (docs/reproducing.md)");
  for (const LeftOpen& open : kLeftOpen) {
    all.emplace_back(open.key, fmt::format("{}, {}", key_named(open.key).get(resolved), open.why));
  }
  return all;
}

}  // namespace slammot
