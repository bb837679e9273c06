// The life of a landmark as all estimators keep it: what is remembered of each, when it is admitted
// and when it is given up.
#pragma once

#include <vector>

#include "estimation/estimator.h"
#include "estimation/options.h"

namespace slammot {

struct TrackRecord {
  int track = 0;
  Label label = Label::kUnknown;
  bool from_first_frame = false;
  bool known = false;       // beforehand: its label is a statement
  bool was_moving = false;  // has ever been taken for moving
  int first_frame = 0;
  int last_frame = 0;
  std::optional<int> decision_frame;
  int observations = 0;
  int unused_frames = 0;           // frames since the newest accepted measurement
  int rejected_in_row = 0;         // measurements rejected since then
  int missed = 0;                  // frames since then in which it was predicted in view
  LandmarkPrior prior;             // what was stated of it at its birth
  std::vector<double> static_nis;  // of its latest measurements while static (label_policy.h)
};

TrackRecord born(int track, int frame, Label label, bool first_frame, const LandmarkPrior& prior);
void note_accepted(TrackRecord& record, int frame);
void note_rejected(TrackRecord& record);
// After a frame that did not use the landmark: whether it was predicted to be in view.
void note_unused(TrackRecord& record, bool in_view);
void note_decision(TrackRecord& record, Label label, int frame);

// Whether a landmark is given up after a frame. A landmark that is measured but keeps failing the
// gate is given up whatever its label: its track then starts anew as an unknown landmark. A static
// one that should be in view and is not measured any more is no landmark either: a moving point
// frozen by a wrong label, or one that the front end no longer finds. Without this rule such ghosts
// fill the map.
bool is_lost(const TrackRecord& record, const TrackPolicy& policy);

// The measurements, of tracks that are in no state yet, that become landmarks in this frame: all
// that fit under the caps, in the order of their tracks.
std::vector<Observation> admit(const std::vector<Observation>& candidates, int landmarks,
                               int visible, const TrackPolicy& policy);

// The record as it is reported; the estimator adds positions and velocities.
LandmarkEstimate report(const TrackRecord& record);

}  // namespace slammot
