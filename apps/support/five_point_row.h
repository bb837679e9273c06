// The estimator that needs OpenCV: the program adds its row, so that eval/ is free of it.
#pragma once

#include "eval/configuration/registry.h"
#include "frontend/odometry/five_point.h"

namespace slammot {

inline EstimatorRow five_point_row() {
  return {"five_point",
          "visual odometry of pairs of images: the baseline",
          EstimatorKind::kFilter,
          false,
          [](Configuration&) {},
          [](const Setup& setup, const Configuration&) { return make_five_point(setup); },
          false};
}

}  // namespace slammot
