// All settings of a run. One table of keys serves YAML files, `--set key=value`, `run.yaml` and
// `--help`; adding an option is one field and one row of that table (configuration_keys.cpp).
//
// Fields that override what the sequence states are optional: unset (text `sequence`) takes the
// sequence's statement, or the model's default where it states nothing; see setup.h.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "estimation/options.h"
#include "filters/ekf_options.h"
#include "models/camera_motion.h"
#include "smoothers/window/window_options.h"

namespace slammot {

struct MotionConfiguration {
  std::optional<double> acceleration;          // [m/s^2]
  std::optional<double> angular_acceleration;  // [rad/s^2]
  NoiseDiscretisation discretisation = NoiseDiscretisation::kWhiteNoise;
};

// sigma_rho of a landmark's prior as its mean is corrected: the same, or in proportion to the mean.
// Auto: in proportion where neither sequence nor user states depths, or the sequence a mean_sigma.
enum class PriorSpread { kAuto, kFixed, kRelative };
inline constexpr Choice<PriorSpread> kPriorSpreads[] = {{"auto", PriorSpread::kAuto},
                                                        {"fixed", PriorSpread::kFixed},
                                                        {"relative", PriorSpread::kRelative}};

struct PriorConfiguration {
  std::optional<double> inverse_depth;        // [1/m]
  std::optional<double> inverse_depth_sigma;  // [1/m]
  std::optional<double> mean_sigma;           // [1/m]
  std::optional<double> max_speed;            // [m/s]
  std::optional<double> acceleration;         // [m/s^2]
  std::optional<double> jerk;                 // [m/s^3]
  std::optional<double> steady_time;          // [s]
  PriorSpread spread = PriorSpread::kAuto;
};

// Frames of the sequence by their number, both ends included; last = -1 is the last one.
struct FrameSelection {
  int first = 0;
  int last = -1;
};

struct Configuration {
  std::string preset = "default";  // preset.h
  ModelOptions model;
  EkfOptions ekf;
  WindowOptions window;
  MotionConfiguration motion;
  PriorConfiguration prior;
  std::optional<double> pixel_sigma;  // [px]
  FrameSelection frames;
  std::string python_options = "{}";  // keyword arguments of a Python estimator, as JSON
  std::set<std::string> given = {};   // keys that assign() was given: no preset changes them
};

struct ConfigurationKey {
  std::string name;
  std::string help;
  std::function<void(Configuration&, const std::string&)> set;  // std::invalid_argument: the reason
  std::function<std::string(const Configuration&)> get;         // text that `set` takes back
};

const std::vector<ConfigurationKey>& configuration_keys();

struct Assignment {
  std::string key;
  std::string value;
  int line = 0;  // in a file; 0 on the command line
};

// `key=value`; throws std::invalid_argument where there is no `=`.
Assignment parse_assignment(const std::string& text);

// Throws std::invalid_argument for a key or value that is gone, and says what to use instead.
void refuse_gone(const Assignment& assignment);

// Throws std::invalid_argument: an unknown key (naming the nearest known ones) or a bad value.
void assign(Configuration& configuration, const Assignment& assignment);

// The assignments of a YAML file: nested maps are joined by dots, and `x: {name: y}` is `x: y`. Of
// a `run.yaml` it is its `configuration`, so that a run can be repeated from it. Throws InputError.
std::vector<Assignment> read_assignments(const std::filesystem::path& file);

// Reads and assigns; throws InputError with file and line. Returns what was assigned.
std::vector<Assignment> load_configuration(Configuration& configuration,
                                           const std::filesystem::path& file);

// All keys with their values, in the order of the table.
std::vector<std::pair<std::string, std::string>> key_values(const Configuration& configuration);

// The keys whose values differ, in the same order.
std::vector<std::string> differing_keys(const Configuration& a, const Configuration& b);

}  // namespace slammot
