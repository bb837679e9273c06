// The rows of a landmark model that is not in all_models.h, for add_landmarks().
#pragma once

#include <tuple>
#include <vector>

#include "models/landmarks/landmark_models.h"
#include "models/points/all_points.h"

namespace slammot {

// One for each parametrisation: landmark_rows<MyModel>() of `template <PointParametrisation P>
// struct MyModel`.
template <template <PointParametrisation> class Model>
std::vector<LandmarkFunctions> landmark_rows() {
  const auto rows = []<typename... P>(const std::tuple<P...>*) {
    static_assert((LandmarkModel<Model<P>> && ...));
    return std::vector<LandmarkFunctions>{landmark_row<Model<P>>()...};
  };
  return rows(static_cast<const PointParametrisations*>(nullptr));
}

}  // namespace slammot
