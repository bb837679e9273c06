// The robust loss of a pixel's normalised residual.
#pragma once

#include <ceres/loss_function.h>

#include <memory>
#include <string>

namespace slammot {

// `none` (null: squared) or `huber` at 1.345 sigma, 95% efficient under Gaussian noise (Huber
// 1981). Throws std::invalid_argument for another name.
std::unique_ptr<ceres::LossFunction> make_loss(const std::string& name);

}  // namespace slammot
