// What labels are judged against: whether the object moved when it was last measured.
//
// For one that always moves or never does, that is its class. One that stops and goes on is judged
// as what it was in the last frame of the run that measured it: `static` is right of an object that
// stands there, and `moving` wrong. That frame is the sequence's and not the estimator's, which may
// have rejected the measurements that show that the object left.
#pragma once

#include <map>

#include "datasets/sequence/sequence.h"

namespace slammot {

// By track, of all landmarks whose truth is known; measurements after `last_frame` do not count.
std::map<int, Label> labels_when_last_measured(const Sequence& sequence, int last_frame);

}  // namespace slammot
