#include "models/landmarks/landmark_models.h"

#include "models/find_row.h"
#include "models/landmarks/constant_acceleration.h"
#include "models/landmarks/dynamic_inverse_depth.h"
#include "models/landmarks/scaled_velocity.h"

namespace slammot {
namespace {

// Static points only: a model whose landmarks never become free, so that any M serves.
constexpr LandmarkFunctions inverse_depth() {
  LandmarkFunctions functions =
      landmark_row<DynamicInverseDepth>("static points only, Civera et al. 2008");
  functions.name = "inverse_depth";
  functions.can_move = false;
  return functions;
}

constexpr LandmarkFunctions kTable[] = {
    inverse_depth(),
    landmark_row<DynamicInverseDepth>("the thesis: inverse depth and velocity in metres (2.3)"),
    landmark_row<ScaledVelocity>("velocity times inverse depth: modified polar coordinates"),
    landmark_row<ConstantAcceleration>("inverse depth, velocity and acceleration in metres"),
};

}  // namespace

std::span<const LandmarkFunctions> landmark_table() { return kTable; }

const LandmarkFunctions& find_landmark(const std::string& name) {
  return find_row(landmark_table(), name, "landmark model");
}

}  // namespace slammot
