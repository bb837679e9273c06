#include "eval/study/study_sequence.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "datasets/readers/reader.h"
#include "datasets/simulation/random/random_stream.h"
#include "datasets/text/number.h"

namespace slammot {
namespace {

double noise_of(const StudyCell& cell) {
  double noise = 0.0;
  for (const auto& [key, value] : cell.scene) {
    if (key != "noise") {
      throw std::invalid_argument("a recorded sequence has no parameter '" + key +
                                  "' (known: noise)");
    }
    const auto number = parse_number<double>(value);
    if (!number || !std::isfinite(*number) || *number < 0.0) {
      throw std::invalid_argument("noise: '" + value + "' is not a number of pixels");
    }
    noise = *number;
  }
  return noise;
}

void add_noise(double sigma, std::uint64_t seed, Sequence& sequence) {
  RandomStream random(seed, "pixel noise of a recording");
  const double stated = sequence.pixel_sigma;
  sequence.pixel_sigma = std::hypot(stated, sigma);
  for (Frame& frame : sequence.frames) {
    for (Observation& z : frame.observations) {
      z.pixel += sigma * random.normals<2>();
      z.relative_sigma = std::hypot(z.relative_sigma * stated, sigma) / sequence.pixel_sigma;
    }
  }
}

}  // namespace

bool is_single_run(const StudyCell& cell) {
  return !cell.sequence.empty() && noise_of(cell) == 0.0;
}

Sequence study_sequence(const StudyCell& cell, std::uint64_t seed) {
  if (cell.sequence.empty()) return simulate(cell.scenario, cell.scene, seed);
  const double noise = noise_of(cell);
  Sequence sequence = read_sequence(cell.sequence);
  const bool known = std::ranges::any_of(sequence.truth, [](const auto& t) { return !!t; });
  if (!known) throw InputError(cell.sequence, 0, "has no true poses: a study could not judge it");
  if (noise > 0.0) add_noise(noise, seed, sequence);
  return sequence;
}

}  // namespace slammot
