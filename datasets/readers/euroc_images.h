// EuRoC ASL: `mav0/cam0` (data.csv, sensor.yaml, data/) and the body's true states in
// `mav0/state_groundtruth_estimate0`, or in `mav0/mocap0` as TUM VI has it.
//
// Its truth is the pose of the body, T_RB at 200 Hz; with the camera's extrinsics T_BC (`T_BS` of
// cam0) the camera is T_RC = T_RB T_BC, in the same metric world.
#pragma once

#include "datasets/sequence/sequence.h"

namespace slammot {

bool is_euroc(const std::filesystem::path& folder);
Sequence read_euroc(const std::filesystem::path& folder);

}  // namespace slammot
