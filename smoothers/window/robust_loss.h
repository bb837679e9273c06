// The robust loss of a pixel's normalised residual.
#pragma once

#include <ceres/loss_function.h>

#include <memory>

#include "smoothers/window/window_options.h"

namespace slammot {

// kNone: null, that is squared; kHuber at 1.345 sigma, 95% efficient under Gaussian noise (Huber
// 1981).
std::unique_ptr<ceres::LossFunction> make_loss(Loss loss);

}  // namespace slammot
