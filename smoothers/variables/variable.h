// A variable of the graph, the arithmetic of its tangent space, and the slots that hold them all.
#pragma once

#include <Eigen/Geometry>
#include <deque>
#include <optional>
#include <vector>

#include "smoothers/variables/scale_orbit.h"

namespace slammot {

using VariableId = int;  // its slot

struct Variable {
  VariableId id = 0;
  SmallVector value;            // of an orientation x, y, z, w
  bool is_orientation = false;  // else Euclidean
  bool is_private = false;      // of one landmark, eliminated with it; not once the prior holds it
  bool is_active = true;        // false: in the conditional map
  bool is_constrained = false;  // to its value: it has columns in the prior, but no step is taken
  bool is_considered = false;   // a considered landmark's: not in the core, though in the prior
  bool is_alive = true;         // false: the slot is vacant
  ScaleOrbit orbit;             // what a change of the world's scale does to it
  bool tells_scale = false;     // y of a static landmark
  std::optional<SmallVector> linearisation_point;  // set: Jacobians are taken there, not at value

  // Of the solver: the correction last computed, the value it leads to, and the first row in the
  // core of the normal equations (-1: none).
  SmallVector step, candidate;
  Eigen::Matrix3d turn =
      Eigen::Matrix3d::Identity();  // of an orientation: the transport that goes with the step
  int core = -1;
  int column = -1;  // of a marginalisation; none: -1

  int dim() const { return is_orientation ? 3 : static_cast<int>(value.size()); }
  const SmallVector& point() const { return linearisation_point ? *linearisation_point : value; }
  // The first estimate, for a variable that a prior now holds.
  void keep_point() {
    if (!linearisation_point) linearisation_point = value;
  }
};

// Of an orientation as stored.
inline Eigen::Quaterniond quaternion(const SmallVector& x) {
  return Eigen::Quaterniond(Eigen::Vector4d(x));
}

// x [+] d and y [-] x: x and y as stored, d in the tangent space at x.
SmallVector plus(bool is_orientation, const SmallVector& x, const SmallVector& d);
SmallVector minus(bool is_orientation, const SmallVector& y, const SmallVector& x);

// d(x [-] x0)/dx at an orientation x, 3x3: the inverse right Jacobian of SO(3).
Eigen::Matrix3d transport(const SmallVector& x, const SmallVector& x0);

// Variables stay at their address; a slot that falls vacant is used again.
class Variables {
 public:
  Variable& add(const SmallVector& value, bool is_orientation, bool is_private);
  void remove(VariableId id);

  Variable& operator[](VariableId id) { return slots_[static_cast<std::size_t>(id)]; }
  const Variable& operator[](VariableId id) const { return slots_[static_cast<std::size_t>(id)]; }

  std::size_t size() const { return slots_.size(); }  // slots

  // Of every active variable, by slot.
  template <typename Function>
  void for_each(Function&& function) {
    for (Variable& v : slots_) {
      if (v.is_alive && v.is_active) function(v);
    }
  }
  template <typename Function>
  void for_each(Function&& function) const {
    for (const Variable& v : slots_) {
      if (v.is_alive && v.is_active) function(v);
    }
  }

 private:
  std::deque<Variable> slots_;
  std::vector<VariableId> vacant_;
};

}  // namespace slammot
