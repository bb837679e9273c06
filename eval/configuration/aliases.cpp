// Names of the configuration that changed. Old ones are read for one release, never written.
#include <fmt/format.h>

#include <stdexcept>

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

// Gone without a successor of the same meaning: what to write instead.
constexpr Renamed kGone[] = {
    {"classifier.static_factor", "classifier.decisive_odds"},
    {"classifier.moving_factor", "classifier.decisive_odds"},
    {"classifier=bayes_factor", "classifier=odds (which also asks classifier.hidden_speed)"},
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

void refuse_gone(const Assignment& assignment) {
  const std::string setting = assignment.key + "=" + assignment.value;
  for (const Renamed& gone : kGone) {
    if (assignment.key != gone.was && setting != gone.was) continue;
    throw std::invalid_argument(fmt::format("'{}' is gone: use {}", gone.was, gone.is));
  }
}

}  // namespace slammot
