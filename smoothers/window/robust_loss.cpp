#include "smoothers/window/robust_loss.h"

namespace slammot {

std::unique_ptr<ceres::LossFunction> make_loss(Loss loss) {
  constexpr double kHuber = 1.345;
  return loss == Loss::kHuber ? std::make_unique<ceres::HuberLoss>(kHuber) : nullptr;
}

}  // namespace slammot
