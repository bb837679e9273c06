// A sequence in memory: what the camera measured, what its maker states, and the truth where known.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "datasets/text/input_error.h"
#include "models/measurement.h"
#include "models/rig.h"
#include "models/truth.h"

namespace slammot {

// sequence.yaml `motion`: sigmas of the camera's motion noise.
struct StatedMotion {
  double acceleration = 0.0;          // [m/s^2]
  double angular_acceleration = 0.0;  // [rad/s^2]
};

struct Sequence {
  std::string name;
  Camera camera;
  std::vector<MountedCamera> other_cameras;  // of a rig
  bool camera_assumed = false;  // nobody states it: a reader of images took a usual one
  double pixel_sigma = 1.0;     // [px]
  std::optional<StatedMotion> motion;
  std::optional<LandmarkPrior> prior;
  std::optional<int> points;  // that the front end looked for in an image
  std::vector<Frame> frames;
  std::vector<std::string>
      images;  // as `frames`, relative to the folder; empty when there are none
  std::vector<std::vector<std::string>> other_images;  // as `other_cameras`: as `images`, but ""
                                                       // where a frame has none
  std::vector<std::string>
      depth_images;         // of camera 0, likewise: 16 bits, 0 where nothing is known
  double depth_unit = 0.0;  // of their values [m]
  std::vector<std::optional<CameraState>> truth;  // as `frames`: pose from groundtruth; velocities
                                                  // are central differences, exact when simulated
  std::map<int, TrueLandmark> landmarks;          // by track
  std::vector<KnownLandmark> known;
  std::map<int, double> p_static;  // priors.csv: probability of rest from outside, by track
  std::optional<InitialCamera> initial;
  bool exact_truth = false;        // true for simulated data, where NEES means something
  std::vector<std::string> hints;  // what its reader found hardly meant, see sequence_hints.h
  std::filesystem::path folder;
  std::string sha256;  // of the files read, in the order of FORMATS
};

// Whether another camera, or depths, say how large the world is.
bool measures_scale(const Sequence& sequence);

// Every `step`-th frame from `first` to `last` (indices in `frames`, last included, negative: to
// the end), with Frame::index as it was. What is stated of the camera before the first frame is
// moved to `first` by the truth, or dropped where there is none. Throws std::invalid_argument if
// step < 1.
Sequence select_frames(Sequence sequence, int first, int last, int step);

}  // namespace slammot
