#include "smoothers/variables/variable.h"

#include "models/so3.h"

namespace slammot {

SmallVector plus(bool is_orientation, const SmallVector& x, const SmallVector& d) {
  if (!is_orientation) return x + d;
  return (quaternion(x) * exp_so3(Eigen::Vector3d(d))).normalized().coeffs();
}

SmallVector minus(bool is_orientation, const SmallVector& y, const SmallVector& x) {
  if (!is_orientation) return y - x;
  return log_so3(Eigen::Quaterniond(quaternion(x).conjugate() * quaternion(y)));
}

Eigen::Matrix3d transport(const SmallVector& x, const SmallVector& x0) {
  return inverse_right_jacobian_so3(minus(true, x, x0));
}

Variable& Variables::add(const SmallVector& value, bool is_orientation, bool is_private) {
  VariableId id = static_cast<VariableId>(slots_.size());
  if (vacant_.empty()) {
    slots_.emplace_back();
  } else {
    id = vacant_.back();
    vacant_.pop_back();
  }
  Variable& variable = (*this)[id];
  variable = Variable();
  variable.id = id;
  variable.value = value;
  variable.is_orientation = is_orientation;
  variable.is_private = is_private;
  return variable;
}

void Variables::remove(VariableId id) {
  (*this)[id].is_alive = false;
  vacant_.push_back(id);
}

}  // namespace slammot
