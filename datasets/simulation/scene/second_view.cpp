#include "datasets/simulation/scene/second_view.h"

#include <set>

#include "datasets/simulation/random/random_stream.h"

namespace slammot {

namespace {

// Of a point, in the first camera's frame.
Eigen::Vector3d seen_from(const CameraState& camera, const Eigen::Vector3d& point) {
  return camera.orientation.conjugate() * (point - camera.position);
}

const Eigen::Vector3d& true_position(const Sequence& sequence, const Frame& frame, int track) {
  return sequence.landmarks.at(track).at(frame.index)->position;
}

}  // namespace

MountedCamera camera_to_the_right(const Camera& first, double baseline) {
  return {first, Eigen::Quaterniond::Identity(), {baseline, 0.0, 0.0}};
}

void add_second_view(const RecordingOptions& options, std::uint64_t seed, Sequence& sequence) {
  if (options.stereo == 0.0) return;
  const MountedCamera right = camera_to_the_right(sequence.camera, options.stereo);
  sequence.other_cameras = {right};
  RandomStream noise(seed, "pixels of camera 1");
  for (std::size_t i = 0; i < sequence.frames.size(); ++i) {
    Frame& frame = sequence.frames[i];
    for (const Observation& z : frame.observations) {
      const Eigen::Vector2d error = options.noise * noise.normals<2>();
      const Eigen::Vector3d point =
          seen_from(*sequence.truth[i], true_position(sequence, frame, z.track));
      const auto h = right.lens.project(right.ray(point, 1.0));
      if (!h || !right.lens.in_image(h->pixel)) continue;
      frame.other_views.push_back({z.track, h->pixel + error, 1.0, 1});
    }
  }
}

void add_depths(const RecordingOptions& options, std::uint64_t seed, Sequence& sequence) {
  if (options.depth_sigma == 0.0) return;
  constexpr double kNearest = 0.1;  // [m] the least depth that is written
  RandomStream noise(seed, "depths");
  std::set<int> seen;
  for (std::size_t i = 0; i < sequence.frames.size(); ++i) {
    Frame& frame = sequence.frames[i];
    for (Observation& z : frame.observations) {
      if (!seen.insert(z.track).second) continue;
      const double error = options.depth_sigma * noise.normal();
      const double depth =
          seen_from(*sequence.truth[i], true_position(sequence, frame, z.track)).z() + error;
      if (depth < kNearest) continue;
      z.depth = depth;
      z.depth_sigma = options.depth_sigma;
    }
  }
}

}  // namespace slammot
