// Which landmarks of the first frame are static (`labels.first_frame`), where the classifier is
// given no label.
//
// `static` is the rule of the thesis's experiment (figure 4.5): all are. `unknown` asks the
// classifier as about any later landmark (3.1.3); but then nothing static holds the first cameras.
//
// `odds` begins as `static` does, since most of a scene rests. Until `start_over` frames have
// passed, a label that must be undone (label_revision.h) is dropped, and the frames so far are
// processed again without it, so that nothing a wrong label did to the camera stays. One at a time:
// a wrong label makes right ones look wrong.
#pragma once

#include <set>
#include <span>
#include <vector>

#include "estimation/options.h"
#include "estimation/track_policy.h"
#include "models/measurement.h"

namespace slammot {

class FirstFrame {
 public:
  explicit FirstFrame(const LabelOptions& options);

  // At birth in the first frame.
  Label label(int track);
  // Static by the thesis's rule, and not because of any measurement.
  bool is_rule() const { return options_.first_frame == FirstFrameLabels::kStatic; }

  // Whether undoing this label means to process the frames again without it.
  bool undoes_from_the_start(const TrackRecord& record) const;

  // Before each frame.
  void begin(const Frame& frame);
  // The landmark of this track is not static from the start.
  void drop(int track) { not_static_.insert(track); }
  long dropped() const { return std::ssize(not_static_); }
  // The labels stand from now on, and are undone as later ones are.
  void close();
  bool is_open() const { return is_open_; }
  // All frames so far; empty once the labels stand.
  std::span<const Frame> frames() const { return frames_; }

 private:
  LabelOptions options_;
  bool is_open_;
  std::set<int> asked_;  // tracks; of the others the classifier gave the label
  std::set<int> not_static_;
  std::vector<Frame> frames_;
};

}  // namespace slammot
