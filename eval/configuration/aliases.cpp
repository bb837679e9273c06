// Names of the configuration that changed. Old ones are read for one release, never written.
#include "eval/configuration/configuration.h"

namespace slammot {
namespace {

struct Renamed {
  std::string_view was, is;
};

constexpr Renamed kKeys[] = {
    {"policy.lost_after", "policy.prune_after"},
    {"policy.missed_after", "policy.prune_missed_after"},
};

// Values, with their key.
constexpr Renamed kSettings[] = {
    {"prior.source=stated", "fixed"},
    {"prior.source=map", "empirical"},
    {"policy.retain=window", "visible"},  // `window` is the smoother's
};

}  // namespace

Assignment with_present_names(Assignment assignment) {
  for (const Renamed& key : kKeys) {
    if (assignment.key == key.was) assignment.key = key.is;
  }
  const std::string setting = assignment.key + "=" + assignment.value;
  for (const Renamed& renamed : kSettings) {
    if (setting == renamed.was) assignment.value = renamed.is;
  }
  return assignment;
}

}  // namespace slammot
