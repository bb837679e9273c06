// What made a result, beside configuration and seed: program, machine, date. None of it changes a
// result's numbers but the times; it is for finding out later.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace slammot {

struct Provenance {
  std::string version;   // of the release
  std::string commit;    // of the source tree; "unknown" outside of git
  bool modified = true;  // the tree had changes that are not in the commit
  std::string compiler;
  std::string cpu;
  int cores = 0;
  int jobs = 1;      // runs at a time
  std::string date;  // ISO 8601, UTC
};

// The source's commit is known to the program alone, which states it once, at its start: libraries
// that knew it would be linked anew after every commit.
void state_commit(const std::string& commit, bool modified);

// Of this program, here and now.
Provenance provenance(int jobs = 1);

// `slammot --version`, without the name.
std::string version_text();

nlohmann::ordered_json json_of(const Provenance& provenance);

}  // namespace slammot
