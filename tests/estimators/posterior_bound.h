// The posterior Cramer-Rao bound (Van Trees 1968; Tichavsky, Muravchik & Nehorai 1998) of the last
// camera of a sequence whose landmarks are static, all born in frame 0 and measured in every frame.
//
// The information of the whole path and of all landmarks is that of prior, motion and pixels, each
// linearised at the truth, in *expectation* over prior, motion and noise. The bound is a block of
// its inverse; Tichavsky's recursion is the same inverse, eliminating one camera at a time.
#pragma once

#include "datasets/sequence/sequence.h"
#include "estimation/estimator.h"

namespace slammot::test {

// Of each camera 12 numbers (camera_state.h), then of each landmark 3 (inverse_depth.h), at the
// truth of one draw. The expectation is the mean over draws.
Eigen::MatrixXd path_information(const Sequence& sequence, const Setup& setup);

// The last camera's block of the inverse.
Matrix12d last_camera_bound(const Eigen::MatrixXd& information, std::size_t frames);

}  // namespace slammot::test
