#include "eval/metrics/labels/label_truth.h"

namespace slammot {

std::map<int, Label> labels_when_last_measured(const Sequence& sequence, int last_frame) {
  std::map<int, Label> labels;
  for (const auto& [track, landmark] : sequence.landmarks) labels[track] = landmark.label;
  for (const Frame& frame : sequence.frames) {
    if (frame.index > last_frame) break;
    for (const Observation& z : frame.observations) {
      const auto truth = sequence.landmarks.find(z.track);
      if (truth != sequence.landmarks.end()) labels[z.track] = truth->second.label_at(frame.index);
    }
  }
  return labels;
}

}  // namespace slammot
