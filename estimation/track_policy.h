// What is remembered of each landmark, when one may be initialised and when it is pruned.
#pragma once

#include <map>
#include <vector>

#include "estimation/estimator.h"
#include "estimation/options.h"

namespace slammot {

struct TrackRecord {
  int track = 0;
  Label label = Label::kUnknown;
  bool by_rule = false;  // static because it was in the first frame (modules/births.h)
  bool known = false;    // beforehand: its label is a statement
  bool is_held =
      false;  // unknown, and at rest until evidence says that it moves (modules/births.h)
  bool was_moving = false;  // has ever been taken for moving
  int first_frame = 0;
  int last_frame = 0;
  std::optional<int> decision_frame;
  int observations = 0;
  int unused_frames = 0;       // frames since the newest accepted measurement
  int rejected_in_row = 0;     // frames since then whose measurement was rejected or out of view
  int missed = 0;              // frames since then in which it was predicted in view
  LandmarkPrior prior;         // what was stated of it at its birth
  bool is_remembered = false;  // static, and its motion is remembered (modules/label_revision.h)
  bool rests_beyond_doubt = false;  // and says that it rests
  int remembered_frames = 0;        // for so long
  bool is_behind =
      false;  // static, and then it would be behind the camera (modules/label_revision.h)
  bool cannot_rest = false;  // it once was, so that it is not static again
  std::vector<double>
      static_nis;  // of its latest measurements while static (modules/label_revision.h)
  std::vector<double> classifier_memory;  // see ClassifierMemory (classification.h)
};

// Whether the belief has it at rest.
inline bool rests(const TrackRecord& record) {
  return record.label == Label::kStatic || record.is_held;
}

using TrackRecords = std::map<int, TrackRecord>;  // by track

// The record of a landmark at its first pixel.
TrackRecord initialised(int track, int frame, Label label, const LandmarkPrior& prior);
void note_accepted(TrackRecord& record, int frame);
void note_rejected(TrackRecord& record);
// After a frame that did not use the landmark: whether it was predicted to be in view.
void note_unused(TrackRecord& record, bool in_view);
void note_decision(TrackRecord& record, Label label, int frame);

// Whether a landmark is pruned after a frame. A landmark that is measured but keeps failing the
// gate is pruned whatever its label: its track then starts anew as an unknown landmark. So is a
// static one that should be in view and is not measured any more: a moving point frozen by a wrong
// label, or one that the front end no longer finds. Without this rule such ghosts fill the map.
bool is_pruned(const TrackRecord& record, const TrackPolicy& policy);

// How many landmarks may be initialised in a frame that measures `visible` of them.
std::size_t births_wanted(int visible, const TrackPolicy& policy);

// Where the state is full, those static landmarks leave that were unseen longest: `result`, so many
// that `births` find room, as far as there are any that this frame has not used.
void make_room(const TrackRecords& records, std::size_t births, const TrackPolicy& policy,
               std::vector<int>& result);

// The record as it is reported; landmark_estimate() adds position and velocity.
LandmarkEstimate report(const TrackRecord& record);

}  // namespace slammot
