// Which landmarks of the first frame are static (`labels.first_frame`), where the classifier is
// given no label.
//
// `static` is the rule of the thesis's experiment (figure 4.5): all are. `unknown` asks the
// classifier as about any later landmark (3.1.3); but then nothing static holds the first cameras.
//
// `odds` decides about them together, before anything is frozen. In the first `start` frames they
// are unknown. Then those taken for moving, or no longer there, stay unknown and all others are
// static, since most of a scene is; and the frames so far are processed again with these labels.
// Until `start_over` frames have passed, the label that is most surely wrong is dropped and the
// frames are processed again, so that nothing a wrong label did to the camera stays. It is that of
// the landmark whose remembered motion (LabelOptions::memory) is the farthest from rest, if the
// classifier calls it moving or its innovations reject it; where no motion is remembered, the one
// that its innovations reject most clearly (label_policy.h). One at a time: a wrong label makes
// right ones look wrong. If most landmarks look moving, then the camera's motion is believed
// wrongly, and all count as static.
#pragma once

#include <set>
#include <span>
#include <vector>

#include "estimation/labels/label_policy.h"
#include "models/measurement.h"

namespace slammot {

class FirstFrame {
 public:
  explicit FirstFrame(const LabelOptions& options);

  // At birth in the first frame.
  Label label(int track);
  // Static by the thesis's rule, and not because of any measurement.
  bool is_rule() const { return options_.first_frame == FirstFrameLabels::kStatic; }
  // The frame that decided label(); by default `birth`.
  int decision_frame(int birth) const { return decided_.value_or(birth); }

  // What revise() takes back next, if anything: the label that is most surely wrong.
  void accuse(std::optional<int> track) { accused_ = track; }

  // Whether it is for revise() to take this label back.
  bool holds(const TrackRecord& record) const;

  // Before each frame.
  void begin(const Frame& frame);
  // After it. True when labels have changed, and frames() are to be processed again.
  bool revise(const TrackRecords& records);
  // The labels stand from now on, and are reverted as later ones are.
  void close() { is_open_ = false; }
  // All frames so far; empty once the labels stand.
  std::span<const Frame> frames() const { return frames_; }

 private:
  bool drop_accused();
  void decide(const TrackRecords& records);

  LabelOptions options_;
  bool is_open_;
  bool is_asked_ = false;
  std::optional<int> decided_;  // frame index
  std::optional<int> accused_;
  std::set<int> not_static_;
  std::vector<Frame> frames_;
};

}  // namespace slammot
