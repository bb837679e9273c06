// What a user states of images beside their pixels, into the sequence that is tracked.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "frontend/tracking/track_images.h"

namespace slammot {

struct TrackStatements {
  std::string initial_velocity;          // VX,VY,VZ (W) [m/s]; empty: none
  std::optional<double> velocity_sigma;  // [m/s]
  std::string known;                     // a file as known.csv; empty: none
  std::string masks;                     // a folder; empty: none
};

// Throws std::invalid_argument for a velocity that is none.
void require_velocity(const TrackStatements& stated);

// What an odometer would tell: it fixes the scale where no board does. The pose is that of the
// board, else of the truth, else the origin. Throws InputError where a true velocity is wanted and
// there is none.
void state_velocity(const TrackStatements& stated, Sequence& sequence);

// Beside what a board gives. Throws InputError for a track that was never measured: it would be
// ignored in silence.
void state_known(const std::filesystem::path& file, Sequence& sequence);

// Odds of rest by `masks` (frontend/masks/mask_odds.h), and a line about them, for people.
std::string state_odds(const std::vector<std::filesystem::path>& masks, const Sequence& images,
                       TrackedImages& tracked);

}  // namespace slammot
