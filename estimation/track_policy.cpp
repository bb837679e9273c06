#include "estimation/track_policy.h"

#include <algorithm>

namespace slammot {

TrackRecord initialised(int track, int frame, Label label, const LandmarkPrior& prior) {
  TrackRecord record;
  record.track = track;
  record.label = label;
  record.was_moving = label == Label::kMoving;
  record.first_frame = frame;
  record.last_frame = frame;
  record.observations = 1;
  record.prior = prior;
  if (label != Label::kUnknown) record.decision_frame = frame;
  return record;
}

void note_accepted(TrackRecord& record, int frame) {
  record.last_frame = frame;
  ++record.observations;
  record.unused_frames = 0;
  record.rejected_in_row = 0;
  record.missed = 0;
}

void note_unused(TrackRecord& record, bool in_view) { record.missed += in_view; }

void note_rejected(TrackRecord& record) { ++record.rejected_in_row; }

void note_decision(TrackRecord& record, Label label, int frame) {
  if (label == record.label) return;
  record.label = label;
  record.was_moving = record.was_moving || label == Label::kMoving;
  record.decision_frame = frame;
}

bool is_pruned(const TrackRecord& record, const TrackPolicy& policy) {
  if (record.rejected_in_row > policy.prune_after) return true;
  if (record.missed > kMissedByStatic * policy.prune_after) return true;
  return record.label != Label::kStatic && record.unused_frames > policy.prune_after;
}

std::size_t births_wanted(int visible, const TrackPolicy& policy) {
  const int room = policy.max_visible.value_or(kUsuallyVisible) - visible;
  return static_cast<std::size_t>(std::max(room, 0));
}

void make_room(const TrackRecords& records, std::size_t births, const TrackPolicy& policy,
               std::vector<int>& result) {
  result.clear();
  const auto most = static_cast<std::size_t>(policy.max_landmarks);
  if (records.size() + births <= most) return;
  for (const auto& [track, record] : records) {
    if (rests(record) && record.unused_frames > 0) result.push_back(track);
  }
  const std::size_t surplus = std::min(records.size() + births - most, result.size());
  const auto unseen = [&](int track) { return std::pair(-records.at(track).unused_frames, track); };
  std::ranges::partial_sort(result, result.begin() + static_cast<std::ptrdiff_t>(surplus), {},
                            unseen);
  result.resize(surplus);
  std::ranges::sort(result);
}

LandmarkEstimate report(const TrackRecord& record) {
  LandmarkEstimate estimate;
  estimate.track = record.track;
  estimate.label = record.label;
  estimate.by_rule = record.by_rule;
  estimate.first_frame = record.first_frame;
  estimate.last_frame = record.last_frame;
  estimate.decision_frame = record.decision_frame;
  estimate.observations = record.observations;
  return estimate;
}

}  // namespace slammot
