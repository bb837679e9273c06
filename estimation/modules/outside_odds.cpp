#include "estimation/modules/outside_odds.h"

#include <algorithm>
#include <cmath>

namespace slammot {

// Nothing from outside is so sure that some ten pixels could not contradict it.
constexpr double kSurest = 0.99;

OutsideOdds::OutsideOdds(const std::map<int, double>& p_static, double prior_odds)
    : log_prior_odds_(std::log(prior_odds)) {
  for (const auto& [track, stated] : p_static) {
    const double p = std::clamp(stated, 1.0 - kSurest, kSurest);
    evidence_[track] = std::log(p / (1.0 - p)) - log_prior_odds_;
  }
}

double OutsideOdds::evidence(int track) const {
  const auto said = evidence_.find(track);
  return said == evidence_.end() ? 0.0 : said->second;
}

Births OutsideOdds::births(int track, Births births) const {
  const bool moves = speaks_of(track) && evidence(track) + log_prior_odds_ < 0.0;
  return moves ? Births::kFree : births;
}

}  // namespace slammot
