#include "estimation/labels/first_frame.h"

#include <algorithm>

namespace slammot {

FirstFrame::FirstFrame(const LabelOptions& options)
    : options_(options), is_open_(options.first_frame == FirstFrameLabels::kOdds) {}

Label FirstFrame::label(int track) {
  is_asked_ = true;
  if (options_.first_frame == FirstFrameLabels::kStatic) return Label::kStatic;
  return decided_ && !not_static_.contains(track) ? Label::kStatic : Label::kUnknown;
}

bool FirstFrame::holds(const TrackRecord& record) const {
  return is_open_ && is_asked_ && decided_ && record.label == Label::kStatic && !record.known &&
         record.first_frame == frames_.front().index && !not_static_.contains(record.track);
}

void FirstFrame::begin(const Frame& frame) {
  if (!frames_.empty() && !is_asked_) is_open_ = false;
  if (std::ssize(frames_) >= std::max(options_.start, options_.start_over)) is_open_ = false;
  if (is_open_) {
    frames_.push_back(frame);
  } else {
    frames_ = {};
  }
}

bool FirstFrame::revise(const TrackRecords& records) {
  if (!is_open_) return false;
  if (decided_) return drop_accused();
  if (std::ssize(frames_) < options_.start) return false;
  decide(records);
  return true;
}

void FirstFrame::decide(const TrackRecords& records) {
  decided_ = frames_.back().index;
  std::size_t moving = 0, there = 0;
  for (const Observation& z : frames_.front().observations) {
    const auto record = records.find(z.track);
    if (record == records.end()) {
      not_static_.insert(z.track);
      continue;
    }
    ++there;
    if (record->second.label != Label::kMoving) continue;
    ++moving;
    not_static_.insert(z.track);
  }
  if (2 * moving > there) not_static_.clear();
}

bool FirstFrame::drop_accused() {
  if (!accused_) return false;
  not_static_.insert(*accused_);
  accused_.reset();
  return true;
}

}  // namespace slammot
