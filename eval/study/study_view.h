// One run of each estimator of a study's first group to look at, for the report's 3D view:
// view.json. Beside a measured truth the estimate stands after similarity alignment.
//
//   runs[]  {label, seed, path[[x,y,z]], truth_path[[x,y,z]], steps[]}
//   steps[] {frame, timestamp, camera[x,y,z], truth[x,y,z], landmarks[]}, at most kViewSteps
//   landmarks[] [label (0 unknown, 1 static, 2 moving), x,y,z, a1(3), a2(3), a3(3)]: position [m]
//   in W
//           and the half axes of its 95% ellipsoid; those with a position and a covariance.
#pragma once

#include <nlohmann/json.hpp>

#include "eval/study/study.h"

namespace slammot {

inline constexpr int kViewSteps = 40;
inline constexpr int kViewRuns = 2;  // estimators shown

nlohmann::ordered_json study_view(const Study& study);

}  // namespace slammot
