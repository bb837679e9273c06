#include "datasets/simulation/manoeuvres.h"

namespace slammot {

Parameters parameters(ManoeuvresOptions& o) { return parameters(o.circle); }

Sequence simulate_manoeuvres(const ManoeuvresOptions& options, std::uint64_t seed) {
  return simulate_circle(options.circle, seed);
}

}  // namespace slammot
