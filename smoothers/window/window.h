// The sliding-window smoother on the thesis's models: the last N cameras, the landmarks they see,
// and a prior that keeps what has left the window.
//
// Per frame, in the order of the EKF: predict (and marginalise the frame that leaves), gate,
// optimise, classify, manage. With one frame and one iteration it is the EKF: test_equivalence.
#pragma once

#include <memory>

#include "estimation/estimator.h"
#include "estimation/options.h"
#include "smoothers/window/window_options.h"

namespace slammot {

// Throws std::invalid_argument for an unknown landmark model, classifier, linearisation or loss;
// process() throws it at the second frame for a singular camera noise.
std::unique_ptr<Estimator> make_window(const Setup& setup, const ModelOptions& models,
                                       const WindowOptions& options);

}  // namespace slammot
