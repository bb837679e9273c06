// Whether a label may be taken back.
//
// `one_way` is the thesis's rule (3.1.3): what has been decided stands. With `reversible` a static
// landmark whose latest innovations reject it is unknown again, its motion's prior restored; and a
// moving one is asked again in every frame, so that one that has stopped becomes static. A moving
// point that is kept as static bends the whole map until it is pruned.
#pragma once

#include "estimation/depth_prior.h"
#include "estimation/options.h"
#include "estimation/track_policy.h"
#include "models/camera.h"
#include "models/landmarks/landmark_models.h"

namespace slammot {

// Whether the classifier is asked about this landmark in a frame that measured it. Not before its
// third sighting (LabelOptions::sightings): of two pixels one may be wrong, and nothing tells.
bool is_asked(const TrackRecord& record, const LabelOptions& options);

// The answer of the classifier. A moving landmark only ever hears that it is static.
void note_answer(TrackRecord& record, Label answer, int frame);

// Frames for which a belief remembers the motion of a landmark that has become static; 0: not. Only
// a motion that is a velocity, which prediction leaves as it is, and only when w = 0 was used.
int motion_memory(const ModelOptions& models, const LandmarkFunctions& landmark);

// Whether anything is made of note_innovation().
bool watches_innovations(const LabelOptions& options);

// The NIS of a measurement of a static landmark given all other measurements of its frame; of one
// that did not pass the gate, that of its innovation. One known beforehand stays static.
void note_innovation(TrackRecord& record, double nis, const LabelOptions& options);

// How far in the image a near moving point of the stated prior gets, one sigma, in the time since
// the last measurement of this landmark that was used, `dt` [s] a frame. What lies farther off is a
// wrong match, and says nothing of a label.
double moved_px(const TrackRecord& record, const Camera& camera, double dt);

// The logarithm of the probability that the latest innovations of a static landmark are as large
// as they are: each NIS is chi-square(2), and their sum over n frames chi-square(2n).
double log_tail(const TrackRecord& record);

// Of a static landmark, as believed now. What keeps pace with the camera looks like a point far
// away, or beyond infinity: a negative inverse depth, which nothing at rest has.
void note_depth(TrackRecord& record, const SeenDepth& depth, const LabelOptions& options);

// Whether innovations or depth reject that it is static.
bool is_rejected(const TrackRecord& record, const LabelOptions& options);

// Static no more: unknown, as at its birth.
void note_reverted(TrackRecord& record);

// log P(chi-square(2n) > x) = -x/2 + log sum_{k<n} (x/2)^k / k!, exact for even degrees of freedom.
double log_chi_square_tail(double x, int n);

}  // namespace slammot
