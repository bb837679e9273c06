// Tracks on probation (`policy.probation` = N > 1): a track becomes a landmark when it is measured
// in N frames in a row, and all these measurements count. What the front end loses at once never
// enters the state; what enters is triangulated, so that its first linearisation is a better one.
//
// The landmark enters with its N - 1 pixels of past frames, between the prediction and the gate of
// the N-th frame, whose pixel is then gated as that of any landmark. Tracks of the first frame are
// landmarks at once: there is nothing else to navigate by.
#pragma once

#include <deque>
#include <map>
#include <span>
#include <vector>

#include "models/label.h"
#include "models/measurement.h"

namespace slammot {

// A pixel of a frame that has passed.
struct Sighting {
  int frames_before = 0;  // the newest frame
  int frame = 0;          // Frame::index
  double to_next = 0.0;   // time to the frame after it [s]
  Observation z;
};

// A track whose probation ends.
struct Candidate {
  int track = 0;
  std::vector<Sighting> sightings;  // of frames in a row, oldest first, the last one frame before
  LandmarkPrior prior;
  Label label = Label::kUnknown;

  bool is_free() const { return label != Label::kStatic; }
};

class Probation {
 public:
  // Throws std::invalid_argument for less than one frame.
  explicit Probation(int frames);

  bool is_on() const { return frames_ > 1; }

  // Whether it has been measured in all of the last N - 1 frames; then these, seen from a new frame
  // at this time.
  bool is_passed(int track) const;
  std::vector<Sighting> sightings(int track, double timestamp) const;

  // At the end of a frame, its measurements of tracks that are not landmarks. A track that was not
  // measured begins anew.
  void note(const Frame& frame, std::span<const Observation> unmatched);

  // Its measurements so far are not of one point.
  void forget(int track) { seen_.erase(track); }

 private:
  int frames_;
  std::deque<std::pair<int, double>> past_;       // index and time of the last N - 1 frames
  std::map<int, std::vector<Observation>> seen_;  // of the last frames in a row, by track
};

}  // namespace slammot
