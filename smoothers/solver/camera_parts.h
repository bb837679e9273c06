// A camera's three variables, where they stand in its error state.
#pragma once

#include <array>

#include "smoothers/graph/graph.h"

namespace slammot {

struct CameraPart {
  VariableId variable = 0;
  int column = 0, dim = 0;  // in (position, rotation, velocity, angular velocity)
};

inline std::array<CameraPart, 3> parts(const GraphCamera& c) {
  return {CameraPart{c.position, kPosition, 3}, CameraPart{c.orientation, kRotation, 3},
          CameraPart{c.rates, kVelocity, 6}};
}

}  // namespace slammot
