#include <algorithm>

#include "datasets/sequence/sequence.h"

namespace slammot {
namespace {

// What was stated before the first frame, stated at another frame with the same sigmas.
std::optional<InitialCamera> initial_at(const Sequence& sequence, size_t frame) {
  if (frame == 0 || !sequence.initial) return sequence.initial;
  if (frame >= sequence.truth.size() || !sequence.truth[frame]) return std::nullopt;
  InitialCamera initial = *sequence.initial;
  initial.state = *sequence.truth[frame];
  return initial;
}

template <typename T>
void keep(std::vector<T>& values, const std::vector<size_t>& chosen) {
  if (values.empty()) return;
  std::vector<T> kept;
  kept.reserve(chosen.size());
  for (const size_t i : chosen) kept.push_back(std::move(values[i]));
  values = std::move(kept);
}

}  // namespace

bool measures_scale(const Sequence& sequence) {
  return std::ranges::any_of(sequence.frames, [](const Frame& frame) {
    return !frame.other_views.empty() ||
           std::ranges::any_of(frame.observations, &Observation::has_depth);
  });
}

Sequence select_frames(Sequence sequence, int first, int last, int step) {
  if (step < 1) throw std::invalid_argument("the frame step must be at least 1");
  const size_t count = sequence.frames.size();
  const size_t end = last < 0 ? count : std::min(static_cast<size_t>(last) + 1, count);
  std::vector<size_t> chosen;
  for (auto i = static_cast<size_t>(std::max(first, 0)); i < end; i += static_cast<size_t>(step)) {
    chosen.push_back(i);
  }
  if (!chosen.empty()) sequence.initial = initial_at(sequence, chosen.front());
  keep(sequence.frames, chosen);
  keep(sequence.images, chosen);
  for (auto& images : sequence.other_images) keep(images, chosen);
  keep(sequence.depth_images, chosen);
  keep(sequence.truth, chosen);
  return sequence;
}

}  // namespace slammot
