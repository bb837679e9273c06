#include "datasets/simulation/scene/known_landmarks.h"

#include <algorithm>
#include <limits>

#include "datasets/simulation/random/random_stream.h"

namespace slammot {

Parameters parameters(KnownOptions& o) {
  return {{"known", "static points of the first frame known beforehand", &o.count, 0},
          {"known_sigma", "of each axis [m]", &o.sigma, kAbove0}};
}

namespace {

struct Candidate {
  int track;
  Eigen::Vector2d pixel;
  Eigen::Vector3d position;
  double distance;  // from the camera [m]
};

std::vector<Candidate> nearest_static(const Sequence& sequence, size_t count) {
  std::vector<Candidate> candidates;
  for (const Observation& z : sequence.frames.front().observations) {
    const TrueLandmark& landmark = sequence.landmarks.at(z.track);
    if (landmark.label != Label::kStatic) continue;
    const Eigen::Vector3d position = landmark.at(0)->position;
    candidates.push_back(
        {z.track, z.pixel, position, (position - sequence.truth.front()->position).norm()});
  }
  std::sort(candidates.begin(), candidates.end(),
            [](const auto& a, const auto& b) { return a.distance < b.distance; });
  if (candidates.size() > count) candidates.resize(count);
  return candidates;
}

// Moves the candidate furthest from those in front of `end` (from the middle of the image, when
// there are none) to `end`.
void bring_furthest(std::vector<Candidate>& candidates, size_t end, const Camera& camera) {
  const Eigen::Vector2d middle(camera.cx, camera.cy);
  const auto isolation = [&](const Candidate& c) {
    if (end == 0) return (c.pixel - middle).norm();
    double least = std::numeric_limits<double>::infinity();
    for (size_t i = 0; i < end; ++i) {
      least = std::min(least, (c.pixel - candidates[i].pixel).norm());
    }
    return least;
  };
  const auto begin = candidates.begin() + static_cast<std::ptrdiff_t>(end);
  std::iter_swap(begin, std::max_element(begin, candidates.end(), [&](auto& a, auto& b) {
                   return isolation(a) < isolation(b);
                 }));
}

}  // namespace

std::vector<KnownLandmark> choose_known(const KnownOptions& options, const Sequence& sequence,
                                        std::uint64_t seed) {
  const auto wanted = static_cast<size_t>(options.count);
  std::vector<Candidate> candidates = nearest_static(sequence, 2 * wanted);
  const size_t count = std::min(wanted, candidates.size());
  for (size_t i = 0; i < count; ++i) bring_furthest(candidates, i, sequence.camera);
  candidates.resize(count);
  std::sort(candidates.begin(), candidates.end(),
            [](const auto& a, const auto& b) { return a.track < b.track; });
  RandomStream random(seed, "known");
  std::vector<KnownLandmark> known;
  for (const Candidate& c : candidates) {
    known.push_back({c.track, c.position + options.sigma * random.normals<3>(), options.sigma});
  }
  return known;
}

}  // namespace slammot
