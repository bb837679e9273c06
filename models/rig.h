// A rig of cameras. The pose of an estimate is that of camera 0; camera c stands rigidly beside it,
//
//   x_C0 = t_c + R_c x_C.
//
// A point that camera 0 sees along g at inverse depth rho lies for camera c along
//
//   R_c' (g - rho t_c),
//
// which is regular at rho = 0: there both see the same direction. Each measurement stays a pixel of
// one camera.
#pragma once

#include <utility>
#include <vector>

#include "models/camera.h"
#include "models/so3.h"

namespace slammot {

struct MountedCamera {
  Camera lens;
  Eigen::Quaterniond R = Eigen::Quaterniond::Identity();  // C to C0
  Eigen::Vector3d t = Eigen::Vector3d::Zero();            // of C in C0 [m]
  bool is_first = true;                                   // R and t are none

  MountedCamera(const Camera& camera) : lens(camera) {}  // NOLINT(google-explicit-constructor)
  MountedCamera(const Camera& camera, const Eigen::Quaterniond& orientation,
                const Eigen::Vector3d& position)
      : lens(camera), R(orientation), t(position), is_first(false) {}

  // The ray of camera 0 at inverse depth `rho`, as this camera has it.
  Eigen::Vector3d ray(const Eigen::Vector3d& of_first, double rho) const {
    return is_first ? of_first : Eigen::Vector3d(R.conjugate() * (of_first - rho * t));
  }
};

class Rig {
 public:
  Rig(const Camera& first, const std::vector<MountedCamera>& others = {})  // NOLINT
      : cameras_{MountedCamera(first)} {
    cameras_.insert(cameras_.end(), others.begin(), others.end());
  }

  const MountedCamera& operator[](int camera) const {
    return cameras_[static_cast<std::size_t>(camera)];
  }
  const Camera& first() const { return cameras_.front().lens; }
  int size() const { return static_cast<int>(cameras_.size()); }

 private:
  std::vector<MountedCamera> cameras_;
};

}  // namespace slammot
