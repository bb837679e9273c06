// What the tests of datasets/ share: a small sequence in the native format, why something is
// refused, all numbers of a sequence, the pixel at which a landmark truly is, and how movers go
// from frame to frame.
#pragma once

#include <exception>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "datasets/sequence/sequence.h"
#include "tests/temporary_folder.h"

namespace slammot::test {

inline const std::map<std::string, std::string> kGood = {
    {"sequence.yaml",
     "format: slammot-sequence-1\n"
     "name: small\n"
     "camera: {model: radtan, width: 320, height: 240, fx: 170, fy: 171, cx: 160, cy: 120, "
     "distortion: [0.1, 0.2]}\n"
     "pixel_sigma: 1.5\n"
     "motion: {acceleration: 6, angular_acceleration: 5}\n"
     "prior: {inverse_depth: 0.3, inverse_depth_sigma: 0.15, max_speed: 2}\n"},
    {"frames.csv", "frame,timestamp\n0,0\n1,0.1\n2,0.2\n"},
    {"observations.csv", "frame,track,u,v\n0,5,1,2\n0,3,3.5,4\n2,3,5,6\n"},
    {"groundtruth.tum",
     "# timestamp tx ty tz qx qy qz qw\n"
     "0 0 0 0 0 0 0 1\n0.1 1 0 0 0 0 0 1\n0.26 3 0 0 0 0 0 1\n"},
    {"landmarks.csv",
     "track,frame,class,x,y,z,vx,vy,vz\n3,0,static,1,2,3,0,0,0\n"
     "5,0,moving,1,2,3,0,0,1\n5,1,moving,1,2,4,0,0,1\n"},
    {"known.csv", "track,x,y,z,sigma\n3,1,2,3,0.001\n"},
    {"priors.csv", "track,p_static\n3,0.9\n5,0\n"},
    {"initial.yaml",
     "position: [0, 0, 1]\nquaternion: [0, 0, 0, 1]\nvelocity: [0, 0, 0.5]\n"
     "angular_velocity: [0, 0.1, 0]\n"
     "sigma: {position: 1e-6, rotation: 1e-5, velocity: 0.1, angular_velocity: 0.2}\n"},
};

inline void write_good(const std::filesystem::path& folder) {
  for (const auto& [name, text] : kGood) write_text(folder / name, text);
}

template <typename Action>
std::string refusal_of(const Action& action) {
  try {
    action();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "accepted";
}

inline std::vector<double> numbers_of(const Sequence& s) {
  std::vector<double> numbers{s.prior->acceleration, s.prior->inverse_depth_sigma,
                              s.initial->state.velocity.x()};
  const auto add = [&](const Eigen::Vector3d& v) {
    numbers.insert(numbers.end(), {v.x(), v.y(), v.z()});
  };
  for (std::size_t i = 0; i < s.frames.size(); ++i) {
    for (const Observation& z : s.frames[i].observations) {
      add(Eigen::Vector3d(z.pixel.x(), z.pixel.y(), z.track));
    }
    add(s.truth[i]->position);
    add(s.truth[i]->velocity);
  }
  for (const auto& [track, landmark] : s.landmarks) {
    for (const auto& [frame, p] : landmark.by_frame) {
      add(p.position);
      add(p.velocity);
    }
  }
  for (const KnownLandmark& known : s.known) add(known.position);
  return numbers;
}

inline std::optional<Eigen::Vector2d> true_pixel(const Sequence& s, std::size_t frame, int track) {
  const TruePoint* point = s.landmarks.at(track).at(s.frames[frame].index);
  const CameraState& x = *s.truth[frame];
  const auto p = s.camera.project(x.orientation.conjugate() * (point->position - x.position));
  return p ? std::optional(p->pixel) : std::nullopt;
}

using OfFrames = std::function<void(const TruePoint&, const TruePoint&, const TruePoint&)>;

// Of all movers, three consecutive frames at a time.
inline void for_each_triple(const Sequence& s, const OfFrames& visit) {
  for (const auto& [track, landmark] : s.landmarks) {
    if (landmark.label == Label::kStatic) continue;
    for (const auto& [frame, before] : landmark.by_frame) {
      const TruePoint* now = landmark.at(frame + 1);
      const TruePoint* after = landmark.at(frame + 2);
      if (now != nullptr && after != nullptr) visit(before, *now, *after);
    }
  }
}

}  // namespace slammot::test
