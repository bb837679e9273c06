// A camera that flies over a field in straight legs and curves, with movers below. Its noise is
// stated as the root mean square of its accelerations, which have one sign in a curve.
#include <gtest/gtest.h>

#include <random>

#include "eval/run/run.h"

namespace slammot {
namespace {

constexpr double kDt = 0.1, kSpeed = 5.0, kHeight = 25.0;
// Sanitizers make a frame fifty times slower, and ask for its code, not for its number.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr int kFrames = 70;
#else
constexpr int kFrames = 250;
#endif

// Turn rate [rad/s]: two curves to either side, each entered within a second.
double turn_rate(double t) {
  const auto curve = [&](double begin, double end) {
    return std::clamp(std::min(t - begin, end - t), 0.0, 1.0);
  };
  return 0.55 * (curve(5.0, 11.5) - curve(18.0, 24.5));
}

// [rad], about the camera's axes: what a gimbal leaves of the wind.
Eigen::Vector3d sway(double t) {
  const auto wave = [&](double amplitude, double period, double phase) {
    return amplitude * std::sin(2.0 * M_PI * (t / period + phase));
  };
  return {wave(0.03, 3.1, 0.0) + wave(0.012, 1.4, 0.3), wave(0.03, 2.6, 0.5), wave(0.03, 3.7, 0.2)};
}

// Looking 45 degrees down and swaying; W has z up.
Eigen::Quaterniond looking(double heading, double t) {
  const Eigen::Vector3d ahead(std::cos(heading), std::sin(heading), 0.0);
  Eigen::Matrix3d R;
  R.col(0) << std::sin(heading), -std::cos(heading), 0.0;
  R.col(2) = (ahead - Eigen::Vector3d::UnitZ()).normalized();
  R.col(1) = R.col(2).cross(R.col(0));
  return Eigen::Quaterniond(R) * exp_so3(sway(t));
}

std::vector<CameraState> flight() {
  std::vector<CameraState> cameras;
  CameraState x;
  x.position.z() = kHeight;
  double heading = 0.0;
  constexpr int kParts = 100;
  constexpr double kPart = kDt / kParts;
  for (int i = 0; i < kFrames * kParts; ++i) {
    const double t = i * kPart;
    x.velocity = kSpeed * Eigen::Vector3d(std::cos(heading), std::sin(heading), 0.0);
    if (i % kParts == 0) {
      x.orientation = looking(heading, t);
      const Eigen::Quaterniond next = looking(heading + turn_rate(t) * 1e-5, t + 1e-5);
      x.angular_velocity = log_so3(x.orientation.conjugate() * next) / 1e-5;
      cameras.push_back(x);
    }
    x.position += kPart * x.velocity;
    heading += kPart * turn_rate(t);
  }
  return cameras;
}

StatedMotion root_mean_square(const std::vector<CameraState>& cameras) {
  double linear = 0.0, angular = 0.0;
  for (std::size_t k = 1; k < cameras.size(); ++k) {
    linear += (cameras[k].velocity - cameras[k - 1].velocity).squaredNorm();
    angular += (cameras[k].angular_velocity - cameras[k - 1].angular_velocity).squaredNorm();
  }
  const double steps = 3.0 * static_cast<double>(cameras.size() - 1) * kDt * kDt;  // of each axis
  return {std::sqrt(linear / steps), std::sqrt(angular / steps)};
}

struct Point {
  Eigen::Vector3d start, velocity;
};

// Points all over the field, one in five of them on its way; those of the first frame rest.
std::vector<Point> field(std::mt19937_64& random) {
  std::uniform_real_distribution<double> across(-90.0, 90.0), up(0.0, 6.0), one(0.0, 1.0);
  std::vector<Point> points;
  for (int i = 0; i < 400; ++i) {
    const double heading = 2.0 * M_PI * one(random), speed = 1.0 + 9.0 * one(random);
    const bool moves = i % 5 == 0;
    points.push_back({{across(random) + 30.0, across(random), up(random)},
                      moves
                          ? Eigen::Vector3d(speed * std::cos(heading), speed * std::sin(heading), 0)
                          : Eigen::Vector3d::Zero()});
  }
  return points;
}

Sequence fly(unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const std::vector<CameraState> cameras = flight();
  const std::vector<Point> points = field(random);
  Sequence s;
  s.name = "flight";
  s.camera.fx = s.camera.fy = 500.0;
  s.camera.cx = 320.0;
  s.camera.cy = 240.0;
  s.exact_truth = true;
  s.motion = root_mean_square(cameras);
  for (int k = 0; k < kFrames; ++k) {
    const CameraState& x = cameras[static_cast<std::size_t>(k)];
    s.truth.emplace_back(x);
    Frame frame{k, k * kDt, {}};
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3d at = points[i].start + k * kDt * points[i].velocity;
      const auto p = s.camera.project(x.orientation.conjugate() * (at - x.position));
      if (!p) continue;
      const Eigen::Vector2d pixel = p->pixel + Eigen::Vector2d(normal(random), normal(random));
      if (!s.camera.in_image(pixel)) continue;
      const int track = static_cast<int>(i);
      frame.observations.push_back({track, pixel});
      TrueLandmark& truth = s.landmarks[track];
      truth.label = points[i].velocity.isZero() ? Label::kStatic : Label::kMoving;
      truth.by_frame[k] = {at, points[i].velocity};
    }
    s.frames.push_back(frame);
  }
  for (const Observation& z : s.frames.front().observations) {
    const Point& point = points[static_cast<std::size_t>(z.track)];
    if (s.known.size() < 4 && point.velocity.isZero())
      s.known.push_back({z.track, point.start, 0.02});
  }
  s.initial = InitialCamera{};
  s.initial->state = cameras.front();
  s.initial->velocity_sigma = 0.2;
  s.initial->angular_velocity_sigma = 0.05;
  return s;
}

struct Outcome {
  double error = 0.0;  // of the position, root mean square [m]
  int static_right = 0, static_wrong = 0;
};

Outcome outcome(const Sequence& sequence, const std::string& estimator, bool adaptive) {
  Configuration configuration;
  configuration.model.adaptive_motion = adaptive;
  configuration.model.policy.movers = Movers::kJoint;
  const RunResult run = run_estimator(sequence, configuration, estimator);
  Outcome result;
  EXPECT_FALSE(run.diverged);
  for (std::size_t k = 0; k < run.filtered.size(); ++k) {
    result.error +=
        (run.filtered[k].state.position - sequence.truth[k]->position).squaredNorm() / kFrames;
  }
  result.error = std::sqrt(result.error);
  for (const LandmarkRecord& record : run.landmarks) {
    const LandmarkEstimate& l = record.estimate;
    if (sequence.landmarks.at(l.track).label != Label::kStatic || l.observations < 10) continue;
    result.static_right += l.label == Label::kStatic;
    result.static_wrong += l.label == Label::kMoving;
  }
  return result;
}

// An EKF that must keep its velocity takes two thirds of what rests for moving, and is 8 to 13 m
// off; a window is up to 3 m off.
TEST(Curve, DoesNotMoveTheMap) {
  const Sequence sequence = fly(1);
  for (const char* estimator : {"ekf", "window"}) {
    SCOPED_TRACE(estimator);
    const Outcome stated = outcome(sequence, estimator, false);
    const Outcome adaptive = outcome(sequence, estimator, true);
    std::printf("%s: as stated %.2f m, static %d right %d wrong; adaptive %.2f m, %d %d\n",
                estimator, stated.error, stated.static_right, stated.static_wrong, adaptive.error,
                adaptive.static_right, adaptive.static_wrong);
    if (kFrames < 250) continue;
    EXPECT_LT(adaptive.error, 1.0);
    EXPECT_LE(adaptive.static_wrong, 1);
    EXPECT_GT(adaptive.static_right, 120);
    const double share = std::string_view(estimator) == "ekf" ? 0.1 : 1.0;
    EXPECT_LT(adaptive.error, share * stated.error);
  }
}

}  // namespace
}  // namespace slammot
