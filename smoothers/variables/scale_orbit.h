// What a change of the world's scale does to a variable of the graph: x(t), where the world is e^t
// as large. Pixels do not change along it.
#pragma once

#include <Eigen/Core>

#include "models/points/point_functions.h"

namespace slammot {

inline constexpr int kMaxBlock = 12;  // numbers of a variable
using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxBlock, 1>;
using BlockMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxBlock, kMaxBlock>;

struct ScaleOrbit {
  enum class Kind {
    kNone,      // orientations, what is in units of the depth
    kPosition,  // centre + e^t (x - centre)
    kRates,     // (e^t v, omega)
    kLength,    // e^t x
    kInverse,   // e^-t x
    kPoint      // y of a landmark
  };
  Kind kind = Kind::kNone;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  const PointFunctions* point = nullptr;  // of y

  SmallVector at(const SmallVector& x, double t) const;
  // dx(t)/dx, and n(x) = dx/dt at t = 0.
  BlockMatrix jacobian(const SmallVector& x, double t) const;
  SmallVector direction(const SmallVector& x) const;

  int exponent() const;  // of the world's size; of a point: of its position in W

 private:
  SmallVector from_centre(const SmallVector& x) const;  // of what changes; else 0
};

}  // namespace slammot
