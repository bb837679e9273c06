#include "smoothers/factors/robust_loss.h"

#include <stdexcept>

namespace slammot {

std::unique_ptr<ceres::LossFunction> make_loss(const std::string& name) {
  constexpr double kHuber = 1.345;
  if (name == "huber") return std::make_unique<ceres::HuberLoss>(kHuber);
  if (name == "none") return nullptr;
  throw std::invalid_argument("unknown loss '" + name + "'");
}

}  // namespace slammot
