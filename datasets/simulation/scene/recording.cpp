#include "datasets/simulation/scene/recording.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "datasets/simulation/random/random_stream.h"
#include "datasets/simulation/scene/second_view.h"

namespace slammot {

Parameters parameters(RecordingOptions& o) {
  return {
      {"frames", "number of frames", &o.frames, 1},
      {"rate", "frames a second", &o.rate, kAbove0},
      {"width", "of the image [px]", &o.width, 1},
      {"height", "of the image [px]", &o.height, 1},
      {"field_of_view", "horizontal [deg]", &o.field_of_view_deg, kAbove0},
      {"noise", "sigma of the pixel noise simulated [px]", &o.noise, 0},
      {"stated_noise", "sigma of the pixel noise stated [px]; as noise", &o.stated_noise, kAbove0},
      {"min_depth", "nearest z at which a point is seen [m]", &o.min_depth, kAbove0},
      {"max_depth", "furthest z at which a point is seen [m]", &o.max_depth, kAbove0},
      {"stereo", "baseline of a second camera, to the right [m]; 0: none", &o.stereo, 0},
      {"depth_sigma", "of a depth measured at a point's first pixel [m]; 0: none", &o.depth_sigma,
       0},
  };
}

Camera simulated_camera(const RecordingOptions& options) {
  const double half_angle = options.field_of_view_deg / 2.0 * std::numbers::pi / 180.0;
  Camera camera;
  camera.width = options.width;
  camera.height = options.height;
  camera.fx = camera.fy = options.width / 2.0 / std::tan(half_angle);
  camera.cx = (options.width - 1) / 2.0;
  camera.cy = (options.height - 1) / 2.0;
  return camera;
}

std::optional<Eigen::Vector2d> view(const Camera& camera, const RecordingOptions& options,
                                    const CameraState& from, const Eigen::Vector3d& point) {
  const Eigen::Vector3d ray = from.orientation.conjugate() * (point - from.position);
  if (ray.z() < options.min_depth || ray.z() > options.max_depth) return std::nullopt;
  const auto projection = camera.project(ray);
  if (!projection || !camera.in_image(projection->pixel)) return std::nullopt;
  return projection->pixel;
}

Sequence blank_sequence(const RecordingOptions& options) {
  Sequence sequence;
  sequence.camera = simulated_camera(options);
  constexpr double kLeastStated = 1e-3;  // [px] a stated sigma is never zero
  sequence.pixel_sigma = options.stated_noise.value_or(std::max(options.noise, kLeastStated));
  sequence.exact_truth = true;
  return sequence;
}

namespace {

struct FrameRange {
  int begin;
  int end;
};

// The frames in which a point can be within `reach` of `centre`; saves looking at movers far away.
FrameRange within_reach(const ScenePoint& point, const Eigen::Vector3d& centre, double reach,
                        const RecordingOptions& options) {
  const FrameRange all{point.from_frame, options.frames};
  const double speed = point.velocity.norm();
  if (speed == 0.0 || point.schedule) return all;
  const Eigen::Vector3d along = point.velocity / speed;
  const Eigen::Vector3d from_centre = point.position - centre;
  if (point.manoeuvre) reach += point.manoeuvre->reach();  // off the line
  const double nearest = -along.dot(from_centre);
  const double squared_half = reach * reach - (from_centre + nearest * along).squaredNorm();
  if (squared_half <= 0.0) return {0, 0};
  const double half = std::sqrt(squared_half);
  const auto frame_at = [&](double distance) {
    return static_cast<int>(std::clamp(distance / speed * options.rate, 0.0, 1e9));
  };
  return {std::max(all.begin, frame_at(nearest - half)),
          std::min(all.end, frame_at(nearest + half) + 2)};
}

void record_point(const RecordingOptions& options, const ScenePoint& point, FrameRange range,
                  RandomStream& noise, Sequence& sequence) {
  const Label label = point.label();
  for (int i = range.begin; i < range.end; ++i) {
    const auto frame = static_cast<size_t>(i);
    const Eigen::Vector3d position = point.at(options.time(i));
    const auto pixel = view(sequence.camera, options, *sequence.truth[frame], position);
    if (!pixel) continue;
    const Eigen::Vector2d error = options.noise * noise.normals<2>();
    sequence.frames[frame].observations.push_back({point.track, *pixel + error});
    TrueLandmark& landmark = sequence.landmarks[point.track];
    landmark.label = label;
    if (label == Label::kMoving || landmark.by_frame.empty()) {
      landmark.by_frame[i] = {position, point.velocity_at(options.time(i))};
    }
  }
}

}  // namespace

Sequence record(const RecordingOptions& options, const std::vector<CameraState>& trajectory,
                const std::vector<ScenePoint>& points, std::uint64_t seed) {
  Sequence sequence = blank_sequence(options);
  Eigen::AlignedBox3d box;
  for (int i = 0; i < options.frames; ++i) {
    sequence.frames.push_back({i, options.time(i), {}, {}});
    sequence.truth.emplace_back(trajectory[static_cast<size_t>(i)]);
    box.extend(sequence.truth.back()->position);
  }
  const double corner =
      std::hypot(1.0, std::hypot(options.width, options.height) / 2.0 / sequence.camera.fx);
  const double reach = box.sizes().norm() / 2.0 + options.max_depth * corner;
  RandomStream noise(seed, "pixels");
  for (const ScenePoint& point : points) {
    const FrameRange range = within_reach(point, box.center(), reach, options);
    record_point(options, point, range, noise, sequence);
  }
  add_second_view(options, seed, sequence);
  add_depths(options, seed, sequence);
  return sequence;
}

}  // namespace slammot
