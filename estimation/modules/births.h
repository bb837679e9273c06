// What is believed of a landmark whose label is open (`labels.births`), where the classifier is
// given no label.
//
// `free`: it may move (thesis 3.1.3). Then most of what is measured says little of the camera,
// where tracks are short, and in the first frame nothing holds it. `static_first`: those of the
// first frame are static, as in the thesis's experiment (figure 4.5); later ones are free.
//
// `held`: most of a scene rests, so each rests until evidence says otherwise. What its motion would
// be is remembered from its first pixel, and the classifier is asked about that as about a free
// one's (label_revision.h). Its label is unknown meanwhile; it is released once its measurements do
// not speak for rest, and what its rest has done is undone. Where no motion can be remembered
// `held` is `static_first`.
#pragma once

#include "estimation/options.h"
#include "estimation/track_policy.h"

namespace slammot {

// As it acts. `memory`: motion_memory().
inline Births births_in_force(Births births, int memory) {
  return births == Births::kHeld && memory == 0 ? Births::kStaticFirst : births;
}

// The record of a landmark at its first pixel; `given`: the classifier's label at birth.
TrackRecord record_at_birth(int track, int frame, bool is_first_frame, Label given, Births births,
                            const LandmarkPrior& prior);

}  // namespace slammot
