// What a batch needs to know of the landmarks that a window had: their pixels, and states from
// which to begin. The batch owns it; a window that is given one tells it what happens.
#pragma once

#include <map>
#include <span>
#include <vector>

#include "estimation/track_policy.h"
#include "smoothers/graph/landmark.h"

namespace slammot {

// From the first pixel of a landmark until it is pruned. Frames by WindowFrame::number.
struct TrackHistory {
  int first = 0;  // frame
  BirthPrior birth;
  Eigen::Vector3d born_at = Eigen::Vector3d::Zero();  // y
  std::vector<std::pair<int, Observation>> pixels;    // by frame, the first one included
  std::vector<LandmarkVector>
      states;  // (y, w) by frame from the first; of a static landmark its last
  TrackRecord record;

  // A batch knows no change of mind: what was ever taken for moving is free all the time.
  bool is_free() const { return record.was_moving || !rests(record); }
};

class TrackHistories {
 public:
  void begin(int track, int frame, const BirthPrior& birth, const Eigen::Vector3d& y);
  void measured(const Observation& z, int frame);
  void discard(int track,
               int frame);  // a measurement that turned out to be wrong
  // The next states of a free landmark, as they leave the window or it becomes static.
  void passed(int track, std::span<const LandmarkVector> states);
  // It was static up to the frame before `frame`, in this state (y, 0); what passed since is not
  // so.
  void rested_until(int track, int frame, const LandmarkVector& state);
  // The states still in the window, the newest last (of a static landmark only that), end it.
  void end(const TrackRecord& record, int frame, bool is_free,
           std::span<const LandmarkVector> states);

  const std::vector<TrackHistory>& ended() const { return ended_; }

 private:
  std::map<int, TrackHistory> open_;  // by track
  std::vector<TrackHistory> ended_;
};

}  // namespace slammot
