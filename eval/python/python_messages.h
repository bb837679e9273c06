// What is said between this program and the process of a Python estimator: one JSON object a line,
// numbers that read back to the same double, null where a number is not defined.
//
//   -> {"setup": .., "options": ..}   <- {}
//   -> {"frame": .., "tracks": .., ..} <- {"camera": .., "report": .., "landmarks": [those
//   measured]}
//   -> {"ask": "landmarks"}           <- {"landmarks": [..]}
//   -> {"ask": "smoothed"}            <- {"cameras": [..]}
//
// The first line comes from the process: {"kind", "description"}. Any answer may be {"error": ..},
// or {"diverged": ..}.
#pragma once

#include <nlohmann/json.hpp>

#include "estimation/estimator.h"

namespace slammot {

nlohmann::ordered_json setup_message(const Setup& setup);
nlohmann::ordered_json frame_message(const Frame& frame);

// They throw nlohmann::ordered_json::exception for what is not of this form.
CameraEstimate camera_from(const nlohmann::ordered_json& json);
LandmarkEstimate landmark_from(const nlohmann::ordered_json& json);
FrameReport report_from(const nlohmann::ordered_json& json);

}  // namespace slammot
