// Names of the configuration that changed. Old ones are read for one release, never written.
#include "eval/configuration/configuration.h"

namespace slammot {
namespace {

struct OldKey {
  std::string_view was, is;
};
constexpr OldKey kOldKeys[] = {
    {"policy.lost_after", "policy.prune_after"},
    {"policy.missed_after", "policy.prune_missed_after"},
    {"window.negligible", "window.cost_tolerance"},
};

struct OldValue {
  std::string_view key, was, is;
};
constexpr OldValue kOldValues[] = {
    {"prior.source", "stated", "fixed"},
    {"prior.source", "map", "empirical"},
};

}  // namespace

Assignment with_present_names(Assignment assignment) {
  for (const OldKey& old : kOldKeys) {
    if (assignment.key == old.was) assignment.key = old.is;
  }
  for (const OldValue& old : kOldValues) {
    if (assignment.key != old.key || assignment.value != old.was) continue;
    assignment.value = old.is;
    break;
  }
  return assignment;
}

}  // namespace slammot
