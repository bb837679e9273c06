// Who may correct the camera (`policy.movers`).
//
// `joint`: every accepted measurement corrects the whole state, as in the thesis. `considered`:
// where enough rests, a measurement of a landmark labelled moving corrects its own landmark and
// nothing else; what it says of the camera is left unused, and its uncertainty is considered
// (Schmidt 1966). Depth and velocity of a mover stay uncertain for long, and move: what it says of
// the camera through Jacobians taken there is overconfident.
//
// The estimator `delayed`, the practice that the thesis argues against, is the same policy for
// landmarks whose label is open.
#pragma once

#include <span>
#include <vector>

#include "estimation/track_policy.h"
#include "models/measurement.h"

namespace slammot {

// So many accepted measurements of landmarks at rest, and movers need not help.
inline constexpr int kStaticEnough = 12;

// Of the accepted measurements, which are sorted by track, the tracks that are considered only.
void find_considered(std::span<const Observation> accepted, const TrackRecords& records,
                     const TrackPolicy& policy, std::vector<int>& result);

}  // namespace slammot
