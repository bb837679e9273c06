// From a sequence and a configuration to what an estimator is given. Order of precedence: the
// configuration, then the sequence's statement, then the model's default.
//
// The first camera (FORMATS, initial.yaml): as stated; else the first ground-truth pose, which
// fixes the frame of reference; else the origin. Without a statement it is at rest with pose sigma
// 1e-6.
#pragma once

#include "datasets/sequence/sequence.h"
#include "estimation/estimator.h"
#include "eval/configuration/configuration.h"

namespace slammot {

// The frames that the configuration selects; throws std::invalid_argument if none is left.
Sequence selected(Sequence sequence, const FrameSelection& frames);

Setup make_setup(const Sequence& sequence, const Configuration& configuration);

// The configuration with every `sequence` replaced by the number that is used, for run.yaml.
Configuration resolved(const Sequence& sequence, const Setup& setup, Configuration configuration);

// A line about a setup that cannot work as it is meant to, naming the number and what to set; none
// if nothing is known against it.
std::optional<std::string> warning_about(const Setup& setup, const Configuration& configuration);

Configuration resolve(const Sequence& sequence, const Configuration& configuration);

}  // namespace slammot
