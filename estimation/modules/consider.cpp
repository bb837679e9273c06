#include "estimation/modules/consider.h"

#include <algorithm>

namespace slammot {

void find_considered(std::span<const Observation> accepted, const TrackRecords& records,
                     const TrackPolicy& policy, std::vector<int>& result) {
  result.clear();
  const auto label = [&](const Observation& z) { return records.at(z.track).label; };
  const auto at_rest = [&](const Observation& z) { return rests(records.at(z.track)); };
  const bool enough_rest = std::ranges::count_if(accepted, at_rest) >= kStaticEnough;
  const bool movers = policy.movers == Movers::kConsidered && enough_rest;
  for (const Observation& z : accepted) {
    const bool is_considered =
        (movers && label(z) == Label::kMoving) || (policy.delayed && label(z) == Label::kUnknown);
    if (is_considered) result.push_back(z.track);
  }
}

}  // namespace slammot
