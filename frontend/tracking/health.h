// How well points are followed from image to image, for people.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "datasets/sequence/sequence.h"

namespace slammot {

struct TrackHealth {
  int most = 0;             // tracks followed from an image to the next, where they are most
  double followed = 0.0;    // the same, median over the images
  double life = 0.0;        // images of a track, median over the tracks
  double lost = 0.0;        // share of an image's tracks that the next one has no more
  std::optional<int> ends;  // the first frame that has tracks of which the next one has none
};

// Observations sorted by track.
TrackHealth track_health(const std::vector<Frame>& frames);

// Where fewer than ten are followed, or none between two images: that.
std::vector<std::string> health_faults(const TrackHealth& health);

// How many of the measurements have a match in each other camera, or a depth. `images` as it was
// tracked; nothing where it has no images but those of camera 0.
std::vector<std::string> beside_texts(const Sequence& images, const std::vector<Frame>& frames);

}  // namespace slammot
