#include "datasets/simulation/scene/mover_sigmas.h"

#include <cmath>
#include <numbers>

namespace slammot {
namespace {

double mean_rate(const ManoeuvreOptions& options) {
  return 2.0 * std::numbers::pi / options.period;
}

// E cos^2 c for c uniform in [-limit, limit].
double horizontal_part(double limit) {
  return limit > 0.0 ? 0.5 + std::sin(2.0 * limit) / (4.0 * limit) : 1.0;
}

}  // namespace

MoverSigmas rms_of_movers(const VolumeOptions& options) {
  const ManoeuvreOptions& m = options.manoeuvres;
  const double horizontal = horizontal_part(options.max_climb_deg * std::numbers::pi / 180.0);
  const double square =
      m.share / 8.0 * (m.braking * m.braking * horizontal + m.lateral * m.lateral);
  const double rate = mean_rate(m) / std::sqrt(1.0 - kPeriodSpread * kPeriodSpread);
  return {std::sqrt(square), rate * std::sqrt(square)};
}

}  // namespace slammot
