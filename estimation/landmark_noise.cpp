#include "estimation/landmark_noise.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "estimation/label_policy.h"

namespace slammot {

namespace {

constexpr std::size_t kInnovations = 200;  // of all movers together
constexpr double kProbability = 1e-8;      // of rejecting movers that keep their velocity
constexpr double kLargestNis = 9.21;       // 99% of chi-square(2): one outlier decides nothing

}  // namespace

void LandmarkNoise::note_innovation(double nis) {
  if (!keeps_velocity_) return;
  latest_.reserve(kInnovations);
  if (latest_.size() == kInnovations) latest_.erase(latest_.begin());
  latest_.push_back(std::min(nis, kLargestNis));
  const double sum = std::accumulate(latest_.begin(), latest_.end(), 0.0);
  keeps_velocity_ =
      log_chi_square_tail(sum, static_cast<int>(latest_.size())) >= std::log(kProbability);
}

}  // namespace slammot
