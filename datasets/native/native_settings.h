// The two YAML files of the native folder. An unknown key is an error.
#pragma once

#include "datasets/sequence/sequence.h"
#include "datasets/text/text_table.h"

namespace slammot {

// sequence.yaml: name, camera, pixel sigma, and what is stated of motion and scene.
void read_settings(const std::filesystem::path& file, const std::string& text, Sequence& sequence);

// initial.yaml.
InitialCamera read_initial(const std::filesystem::path& file, const std::string& text);

// A quaternion as it stands if its length is one to double precision, else normalised.
Eigen::Quaterniond unit_quaternion(const Eigen::Quaterniond& q);
// The same of a row, which is refused where it is no rotation.
Eigen::Quaterniond unit_quaternion(const TextTable& table, const Eigen::Quaterniond& q);

}  // namespace slammot
