// EuRoC ASL: `mav0/cam0` (data.csv, sensor.yaml, data/) and the body's true states in
// `mav0/state_groundtruth_estimate0`, or in `mav0/mocap0` as TUM VI has it.
//
// Its truth is the pose of the body, T_RB at 200 Hz; with the camera's extrinsics T_BC (`T_BS` of
// cam0) the camera is T_RC = T_RB T_BC, in the same metric world. `mav0/cam1`, which is triggered
// with cam0, stands at T_BC0^-1 T_BC1.
#pragma once

#include "datasets/sequence/sequence.h"

namespace slammot {

bool is_euroc(const std::filesystem::path& folder);
Sequence read_euroc(const std::filesystem::path& folder);
void add_euroc_pair(Sequence& sequence);  // cam1, where its data.csv and sensor.yaml are there

}  // namespace slammot
