// Whether a static label must be undone: the one rule of all estimators.
//
// `one_way` is the thesis's rule (3.1.3): what has been decided stands. With `reversible` two kinds
// of evidence are asked in every frame that measures a static landmark:
//
// - its innovations. Each NIS given all other measurements is chi-square(2), so that the sum of the
//   last n is chi-square(2n); and an inverse depth below zero is that of nothing at rest.
// - its motion, where it is remembered: the belief knows what w would be were it not constrained to
//   zero (Belief::constrained_motions). The classifier is asked about that w as about any other.
//
// A label that either rejects is undone. Where the motion is remembered the landmark is released as
// if it had never been static, the most significant first, and the others are asked again without
// it: what bends the map makes others look moving too. Else it is free from this frame on. Those
// that are held at birth (births.h) are released by the same rule, and as soon as their
// measurements do not speak for rest: no label is undone by that, and they are asked on. A moving
// landmark is asked again in every frame, so that one that has stopped becomes static.
//
// A motion is remembered for `labels.memory` frames, while the landmark is measured, and until the
// evidence that it rests is beyond doubt.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "estimation/classification.h"
#include "estimation/modules/depth_prior.h"
#include "estimation/options.h"
#include "estimation/remembered_motions.h"
#include "estimation/track_policy.h"
#include "models/camera.h"
#include "models/landmarks/landmark_models.h"

namespace slammot {

// Whether the classifier is asked about this landmark in a frame that measured it. Not before its
// third sighting (LabelOptions::sightings): of two pixels one may be wrong, and nothing tells.
bool is_asked(const TrackRecord& record, const LabelOptions& options);

// The answer of the classifier. A moving landmark only ever hears that it is static.
void note_answer(TrackRecord& record, Label answer, int frame);

// Why no motion is remembered; empty where it is. Only a motion that is a velocity, which
// prediction leaves as it is, and only when w = 0 was used.
std::string why_no_memory(const ModelOptions& models, const LandmarkFunctions& landmark);

// Frames for which a belief remembers the motion of a landmark that has become static; 0: not.
int motion_memory(const ModelOptions& models, const LandmarkFunctions& landmark);

// Of a remembered motion, before a frame is predicted: whether it is to be forgotten.
bool is_forgotten(const TrackRecord& record, int memory);

// Notes the evidence of a remembered motion: odds of rest beyond doubt.
void note_motion(TrackRecord& record, const MotionBelief& motion);

// Whether innovations are asked at all.
bool watches_innovations(const LabelOptions& options);

// The NIS of a static landmark's measurement given all other measurements of its frame; of one that
// did not pass the gate, that of its innovation. Of `pixels` of them together, 2 degrees of freedom
// each, the value of 2 that is as probable is noted. One known beforehand stays static.
void note_innovation(TrackRecord& record, double nis, const LabelOptions& options, int pixels = 1);

// How far in the image a near moving point of the stated prior gets, one sigma, in the time since
// the last measurement of this landmark that was used, `dt` [s] a frame. What lies farther off is a
// wrong match, and says nothing of a label.
double moved_px(const TrackRecord& record, const Camera& camera, double dt);

// The logarithm of the probability that the latest innovations of a static landmark are as large
// as they are.
double log_tail(const TrackRecord& record);

// Of a static landmark, as believed now. What keeps pace with the camera looks like a point far
// away, or beyond infinity.
void note_depth(TrackRecord& record, const SeenDepth& depth, const LabelOptions& options);

// Whether innovations or depth reject that it is static.
bool is_rejected(const TrackRecord& record);

// What a frame says of the landmarks at rest that it measured.
struct Undoing {
  std::vector<int> free;     // rejected, with no motion remembered, by track
  std::vector<int> release;  // of those whose motion is remembered, the most significant first
};

// The i-th remembered motion as it is now, and the classifier's answer on it; none where it is not
// determined.
struct MotionAnswer {
  MotionBelief motion;
  Label label = Label::kUnknown;
};
using AskMotion = std::function<std::optional<MotionAnswer>(std::size_t)>;

// The rule. `tracks`: the landmarks at rest that were measured; `motions`: of those that are
// remembered, marginalised one by one as they are released.
void find_undoing(const TrackRecords& records, std::span<const int> tracks,
                  RememberedMotions& motions, const AskMotion& ask, Undoing& result);

// Static no more: unknown, as at its birth.
void note_reverted(TrackRecord& record);

}  // namespace slammot
