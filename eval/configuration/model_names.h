// What can be named in a configuration, from the tables of models/: for checking and for listing.
#pragma once

#include <string>
#include <vector>

namespace slammot {

struct NamedEntry {
  std::string name;
  std::string description;
};

std::vector<NamedEntry> landmark_list();
std::vector<NamedEntry> classifier_list();
std::vector<NamedEntry> motion_list();

std::vector<std::string> names_of(const std::vector<NamedEntry>& list);

}  // namespace slammot
