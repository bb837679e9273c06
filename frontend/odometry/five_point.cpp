#include "frontend/odometry/five_point.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "frontend/odometry/two_view.h"

namespace slammot {
namespace {

constexpr double kKeyParallax = 3.0 * std::numbers::pi / 180.0;     // median [rad]
constexpr double kLeastParallax = 0.25 * std::numbers::pi / 180.0;  // of a triangulated point
constexpr double kLeastShare = 0.6;      // of a key frame's tracks; fewer ask for a new one
constexpr std::size_t kLeastPoints = 4;  // that tell the length of a step

struct Point {
  Eigen::Vector3d position;  // W
  double parallax;           // with which it was triangulated [rad]
};

struct KeyFrame {
  Rays rays;
  double timestamp = 0.0;
  Eigen::Vector3d position;
  Eigen::Matrix3d R_world_camera;
};

struct Step {
  TwoView pose;
  TrackMatches matches;
};

// The value at which half of the weight is reached.
double weighted_median(std::vector<std::pair<double, double>> value_and_weight) {
  std::ranges::sort(value_and_weight);
  double total = 0.0, below = 0.0;
  for (const auto& [value, weight] : value_and_weight) total += weight;
  for (const auto& [value, weight] : value_and_weight) {
    below += weight;
    if (2.0 * below >= total) return value;
  }
  return 0.0;
}

class FivePoint final : public Estimator {
 public:
  explicit FivePoint(const Setup& setup)
      : lens_(setup.camera),
        sigma_(ray_sigma(setup.camera, setup.pixel_sigma)),
        speed_(setup.initial.state.velocity.norm()) {
    if (!(speed_ > 0.0)) speed_ = 1.0;
    camera_.state = setup.initial.state;
    camera_.covariance.setConstant(kUndefined);
    for (const KnownLandmark& known : setup.known) {
      points_[known.track] = {known.position, std::numbers::pi};
    }
  }

  FrameReport process(const Frame& frame, StageListener& stages) override;
  CameraEstimate camera() const override { return camera_; }
  std::vector<LandmarkEstimate> landmarks() const override { return {}; }

 private:
  std::optional<Step> match(const Rays& rays) const;
  double length(const Step& step, double dt) const;
  void move(const Step& step, double timestamp);
  void predict(double timestamp);
  bool wants_key_frame(const Step& step) const;
  void triangulate(const Step& step);
  void set_velocities(const CameraState& before, double dt);

  Camera lens_;
  double sigma_;  // of a ray's coordinate
  double speed_;  // of the newest step of known length [m/s]
  CameraEstimate camera_;
  std::optional<KeyFrame> key_;
  std::map<int, Point> points_;  // by track; of those that left the view too
};

std::optional<Step> FivePoint::match(const Rays& rays) const {
  Step step;
  step.matches = match_rays(key_->rays, rays);
  const auto pose = relative_pose(step.matches.rays, sigma_);
  if (!pose) return std::nullopt;
  step.pose = *pose;
  return step;
}

// Near points far from the epipole tell most.
double FivePoint::length(const Step& step, double dt) const {
  std::vector<std::pair<double, double>> lengths;
  for (const std::size_t i : step.pose.inliers) {
    const auto point = points_.find(step.matches.tracks[i]);
    if (point == points_.end()) continue;
    const Eigen::Vector3d p =
        step.pose.R * key_->R_world_camera.transpose() * (point->second.position - key_->position);
    const Eigen::Vector3d& ray = step.matches.rays.second[i];
    const double weight = ray.cross(step.pose.t).norm() / p.norm();
    lengths.emplace_back(along(p, step.pose.t, ray), weight);
  }
  if (lengths.size() < kLeastPoints) return speed_ * dt;
  const double s = weighted_median(std::move(lengths));
  return std::isfinite(s) ? s : speed_ * dt;
}

void FivePoint::move(const Step& step, double timestamp) {
  const double s = length(step, timestamp - key_->timestamp);
  const Eigen::Matrix3d R = key_->R_world_camera * step.pose.R.transpose();
  camera_.state.orientation = Eigen::Quaterniond(R).normalized();
  camera_.state.position = key_->position - s * R * step.pose.t;
}

void FivePoint::predict(double timestamp) {
  const double dt = timestamp - camera_.timestamp;
  camera_.state = slammot::predict(camera_.state, dt);
}

bool FivePoint::wants_key_frame(const Step& step) const {
  std::vector<double> angles;
  for (const std::size_t i : step.pose.inliers) {
    angles.push_back(parallax(step.pose, step.matches.rays, i));
  }
  const auto middle = angles.begin() + static_cast<std::ptrdiff_t>(angles.size() / 2);
  std::ranges::nth_element(angles, middle);
  const auto left = static_cast<double>(step.matches.tracks.size());
  return *middle > kKeyParallax || left < kLeastShare * static_cast<double>(key_->rays.size());
}

// Between the key frame and the newest image; what was seen under a larger angle stays.
void FivePoint::triangulate(const Step& step) {
  const Eigen::Vector3d baseline = camera_.state.position - key_->position;
  for (const std::size_t i : step.pose.inliers) {
    const double angle = parallax(step.pose, step.matches.rays, i);
    const auto known = points_.find(step.matches.tracks[i]);
    if (!(angle > (known == points_.end() ? kLeastParallax : known->second.parallax))) continue;
    const Eigen::Vector3d first = key_->R_world_camera * step.matches.rays.first[i];
    const Eigen::Vector3d second = camera_.state.orientation * step.matches.rays.second[i];
    const double depth = along(-baseline, first, second);
    if (depth > 0.0) points_[step.matches.tracks[i]] = {key_->position + depth * first, angle};
  }
}

void FivePoint::set_velocities(const CameraState& before, double dt) {
  CameraState& now = camera_.state;
  now.velocity = (now.position - before.position) / dt;
  now.angular_velocity =
      log_so3(Eigen::Quaterniond(before.orientation.conjugate() * now.orientation)) / dt;
}

FrameReport FivePoint::process(const Frame& frame, StageListener& stages) {
  if (key_ && !(frame.timestamp > camera_.timestamp)) {
    throw std::invalid_argument("the time of a frame must be later than that of the one before");
  }
  stages.begin("update");
  FrameReport report;
  report.nis_sum = report.joint_nis = kUndefined;
  const Rays rays = rays_by_track(lens_, frame);
  std::optional<Step> step;
  if (key_) {
    const CameraState before = camera_.state;
    const double dt = frame.timestamp - camera_.timestamp;
    step = match(rays);
    step ? move(*step, frame.timestamp) : predict(frame.timestamp);
    set_velocities(before, dt);
  }
  camera_.timestamp = frame.timestamp;
  if (step) {
    report.accepted = report.accepted_static = static_cast<int>(step->pose.inliers.size());
    report.rejected = static_cast<int>(step->matches.tracks.size()) - report.accepted;
  }
  if (step && !wants_key_frame(*step)) return report;
  if (step) {
    speed_ = (camera_.state.position - key_->position).norm() / (frame.timestamp - key_->timestamp);
    triangulate(*step);
  }
  key_ = {rays, frame.timestamp, camera_.state.position,
          camera_.state.orientation.toRotationMatrix()};
  return report;
}

}  // namespace

std::unique_ptr<Estimator> make_five_point(const Setup& setup) {
  return std::make_unique<FivePoint>(setup);
}

}  // namespace slammot
