// Cameras as they were calibrated: slammot's own form, and those of other programs.
#pragma once

#include "datasets/text/yaml_map.h"
#include "models/rig.h"

namespace slammot {

// slammot's own, as sequence.yaml has it under `camera`. An unknown key is an error.
Camera read_camera(YamlMap map);

// The cameras of a rig, as sequence.yaml has them under `cameras`: each as above, and but for the
// first with `T_C0_C: {position, quaternion}`. Of one size, and no two at one place.
std::vector<MountedCamera> read_rig(YamlMap& map, const std::string& key);

// `resolution`, `intrinsics`, `camera_model`, `distortion_model` and its coefficients: a camera of
// kalibr's, and EuRoC's sensor.yaml. Other keys are left alone, here and in what follows.
Camera read_listed_camera(YamlMap& map);

struct CameraFile {
  Camera camera;     // width and height 0 where the file does not tell them
  std::string form;  // whose file it is, for people
};

// A YAML file that holds nothing but a camera: of slammot; kalibr (the first of a camchain); EuRoC;
// OpenCV's FileStorage and ROS's camera_info; ORB-SLAM. Throws InputError with file and line.
CameraFile read_camera_file(const std::filesystem::path& file, const std::string& text);

}  // namespace slammot
