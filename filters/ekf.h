// The EKF of the thesis: joint covariance of camera and all landmarks, undelayed initialisation.
//
// A belief of the frame loop (estimation/loop/frame_loop.h). Options: landmark model, classifier,
// collapse, iterations, deferred updates of what is out of view. Errors: Diverged when a covariance
// stops being one.
#pragma once

#include <memory>

#include "estimation/estimator.h"
#include "estimation/options.h"
#include "filters/ekf_options.h"

namespace slammot {

// Throws std::invalid_argument for an unknown landmark model or classifier, or options that exclude
// each other.
std::unique_ptr<Estimator> make_ekf(const Setup& setup, const ModelOptions& models,
                                    const EkfOptions& options);

}  // namespace slammot
