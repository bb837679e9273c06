#include "estimation/modules/first_frame.h"

namespace slammot {

FirstFrame::FirstFrame(const LabelOptions& options)
    : options_(options), is_open_(options.first_frame == FirstFrameLabels::kOdds) {}

Label FirstFrame::label(int track) {
  asked_.insert(track);
  if (options_.first_frame == FirstFrameLabels::kUnknown || not_static_.contains(track)) {
    return Label::kUnknown;
  }
  return Label::kStatic;
}

bool FirstFrame::undoes_from_the_start(const TrackRecord& record) const {
  return is_open_ && asked_.contains(record.track) && record.label == Label::kStatic &&
         !record.known && record.first_frame == frames_.front().index &&
         !not_static_.contains(record.track);
}

void FirstFrame::begin(const Frame& frame) {
  const bool is_given = !frames_.empty() && asked_.empty();
  if (is_given || std::ssize(frames_) >= options_.start_over) close();
  if (is_open_) frames_.push_back(frame);
}

void FirstFrame::close() {
  is_open_ = false;
  frames_ = {};
}

}  // namespace slammot
