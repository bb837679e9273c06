// What can be named in a configuration, from the tables of models/: for checking and for listing.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "models/camera_motion.h"

namespace slammot {

struct NamedEntry {
  std::string name;
  std::string description;
};

struct MotionRow {
  std::string_view name;
  std::string_view description;
  NoiseDiscretisation discretisation;
};
std::span<const MotionRow> motion_table();

std::vector<NamedEntry> landmark_list();
std::vector<NamedEntry> point_list();
std::vector<NamedEntry> classifier_list();

std::vector<std::string> names_of(const std::vector<NamedEntry>& list);

}  // namespace slammot
