// Which landmarks of the first frame are known beforehand, and as what.
#pragma once

#include "datasets/simulation/parameters/parameters.h"
#include "datasets/simulation/scene/recording.h"

namespace slammot {

struct KnownOptions {
  int count = 4;
  double sigma = 1e-3;  // [m]
};
Parameters parameters(KnownOptions& options);

// The static points of the first frame that lie nearest (twice as many as wanted), and among them
// one after the other the furthest in the image from those chosen. Each is stated where it is plus
// an error drawn from sigma.
std::vector<KnownLandmark> choose_known(const KnownOptions& options, const Sequence& sequence,
                                        std::uint64_t seed);

}  // namespace slammot
