// The batch: the whole sequence at once, the reference for accuracy and consistency.
//
// A sliding window runs in front: it gates, labels and gives first values. At the end every factor
// it ever had is solved together by Ceres; a landmark that ended as static is static from its
// birth, one that did not has a state in every frame. `camera()` is the window's, `smoothed()` the
// batch's.
#pragma once

#include <memory>

#include "estimation/estimator.h"
#include "estimation/options.h"
#include "smoothers/window/window_options.h"

namespace slammot {

std::unique_ptr<Estimator> make_batch(const Setup& setup, const ModelOptions& models,
                                      const WindowOptions& front);

}  // namespace slammot
