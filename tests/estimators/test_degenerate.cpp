// Geometry that determines little, and measurements that cannot be, given to the library itself: no
// reader stands before it. Filter and window end, in bounded work, with numbers.
#include <gtest/gtest.h>

#include <ctime>

#include "datasets/simulation/scenario.h"
#include "datasets/simulation/scene/known_landmarks.h"
#include "datasets/simulation/scene/random_stream.h"
#include "datasets/simulation/scene/statements.h"
#include "eval/configuration/registry.h"
#include "eval/configuration/setup.h"
#include "eval/metrics/nees.h"
#include "eval/run/run.h"

namespace slammot {
namespace {

constexpr int kFrames = 60;

Sequence recorded(const std::vector<ScenePoint>& points, CameraState (*camera)(double)) {
  RecordingOptions options;
  options.frames = kFrames;
  std::vector<CameraState> trajectory;
  for (int i = 0; i < kFrames; ++i) trajectory.push_back(camera(options.time(i)));
  Sequence sequence = record(options, trajectory, points, 1);
  sequence.known = choose_known({}, sequence, 1);
  state({}, prior_of(sequence), 1, sequence);
  return sequence;
}

CameraState moving_on(double time, const Eigen::Vector3d& velocity) {
  CameraState camera;
  camera.position = time * velocity;
  camera.velocity = velocity;
  return camera;
}

// Nothing tells a turn about the line from nothing at all.
Sequence collinear_points() {
  std::vector<ScenePoint> points;
  for (int i = 0; i < 100; ++i) points.push_back({i, {-10.0 + 0.2 * i, 0.0, 5.0}});
  return recorded(points, [](double time) { return moving_on(time, {0.5, 0.0, 0.0}); });
}

// No parallax: depths stay as they were stated.
Sequence rotation_among(double nearest, double farthest) {
  RandomStream random(1, "points");
  std::vector<ScenePoint> points;
  for (int i = 0; i < 400; ++i) {
    points.push_back({i, random.uniform(nearest, farthest) * random.normals<3>().normalized()});
  }
  return recorded(points, [](double time) {
    constexpr double kRate = 0.5;  // [rad/s]
    CameraState camera;
    camera.orientation = Eigen::AngleAxisd(kRate * time, Eigen::Vector3d::UnitY());
    camera.angular_velocity.y() = kRate;
    return camera;
  });
}

Sequence pure_rotation() { return rotation_among(3.0, 10.0); }

// One point, a landmark many times over.
Sequence coincident_points() {
  std::vector<ScenePoint> points;
  for (int i = 0; i < 80; ++i) points.push_back({i, {0.1, 0.1, 5.0}});
  return recorded(points, [](double time) { return moving_on(time, {0.3, 0.0, 0.0}); });
}

// Where the camera goes: no parallax, and any depth.
Sequence points_ahead() {
  std::vector<ScenePoint> points;
  for (int i = 0; i < 40; ++i) points.push_back({i, {0.0, 0.0, 5.0 + 0.2 * i}});
  return recorded(points, [](double time) { return moving_on(time, {0.0, 0.0, 0.5}); });
}

Sequence circle() { return simulate("circle", {{"frames", std::to_string(kFrames)}}, 1); }

Sequence far_pixel(std::size_t frame) {
  Sequence sequence = circle();
  sequence.frames[frame].observations.back().pixel = {1e9, -1e9};
  return sequence;
}

Sequence tiny_focal_length() {
  Sequence sequence = circle();
  sequence.camera.fx = sequence.camera.fy = 1e-3;
  return sequence;
}

struct Scene {
  std::string name;
  Sequence (*make)();
  bool ends_early = false;  // may: nothing can be made of it
};
void PrintTo(const Scene& scene, std::ostream* out) { *out << scene.name; }

const Scene kScenes[] = {
    {"Circle", circle},
    {"CollinearPoints", collinear_points},
    {"PureRotation", pure_rotation},
    {"CoincidentPoints", coincident_points},
    {"PointsAhead", points_ahead},
    {"FarPixelAtFirst", [] { return far_pixel(0); }},
    {"FarPixelLater", [] { return far_pixel(20); }},
    {"TinyFocalLength", tiny_focal_length, true},
};

// How often frames are processed: again where the first labels are revised (first_frame.h), and
// each time with at most `ekf.iterations` or `window.iterations` linearisations.
class Passes final : public StageListener {
 public:
  void begin(std::string_view stage) override { count += stage == "predict"; }
  int count = 0;
};

using Case = std::tuple<std::string, Scene>;
class Degenerate : public testing::TestWithParam<Case> {};

TEST_P(Degenerate, EndsInBoundedWorkWithNumbers) {
  const auto& [name, scene] = GetParam();
  const Sequence sequence = scene.make();
  Configuration configuration;
  const EstimatorRow& row = find_estimator(name);
  row.adjust(configuration);
  const auto estimator = row.make(make_setup(sequence, configuration), configuration);
  const int revisable = configuration.model.labels.start_over;
  int all = 0;
  Passes passes;
  RunResult run;
  const std::clock_t start = std::clock();
  try {
    for (const Frame& frame : sequence.frames) {
      passes.count = 0;
      estimator->process(frame, passes);
      EXPECT_LE(passes.count, frame.index < revisable ? 1 + 4 * revisable : 1);
      all += passes.count;
      run.frames.push_back(frame.index);
      run.filtered.push_back(estimator->camera());
      ASSERT_TRUE(run.filtered.back().state.position.allFinite());
      ASSERT_TRUE(run.filtered.back().covariance.allFinite());
    }
  } catch (const Diverged& diverged) {
    EXPECT_TRUE(scene.ends_early) << diverged.what();
  }
  EXPECT_LE(all, kFrames + 25 * revisable);
  const double ms = 1e3 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  if (run.filtered.empty()) return;
  std::printf("%s, %s: %zu frames, %.2f ms of CPU a frame, pose NEES %.1f\n", name.c_str(),
              scene.name.c_str(), run.frames.size(), ms / static_cast<double>(run.frames.size()),
              pose_consistency(pair_with_truth(sequence, run.filtered)).pose.mean);
}

INSTANTIATE_TEST_SUITE_P(Families, Degenerate,
                         testing::Combine(testing::Values("ekf", "window"),
                                          testing::ValuesIn(kScenes)),
                         [](const auto& tested) {
                           return std::get<0>(tested.param) + "_" + std::get<1>(tested.param).name;
                         });

// What determines too little is said, by both families; what does not is not.
TEST(DegenerateGeometry, WarnsWhereAllLiesOnOneLine) {
  const std::pair<Sequence, bool> cases[] = {{circle(), false},
                                             {pure_rotation(), false},
                                             {collinear_points(), true},
                                             {coincident_points(), true},
                                             {points_ahead(), true}};
  for (const char* name : {"ekf", "window"}) {
    for (const auto& [sequence, on_one_line] : cases) {
      const RunResult run = run_estimator(sequence, {}, name);
      const bool warns = std::ranges::any_of(run.warnings, [](const RunWarning& warning) {
        return warning.reason.find("lie on one line") != std::string::npos;
      });
      EXPECT_EQ(warns, on_one_line) << name << ", " << sequence.name;
    }
  }
}

// A window takes the most probable path and depths together. Without parallax a small translation
// lets every depth that is not known fit its own noise, which the EKF, linearised without
// translation, does not see. Where the depths are known both do the same.
TEST(PureRotation, TheWindowIsTheEkfWhereDepthsAreKnown) {
  Sequence sequence = rotation_among(6.0, 6.001);
  sequence.prior->inverse_depth = 1.0 / 6.0;
  Configuration configuration;
  configuration.prior.mean_sigma = 0.0;
  for (const double sigma : {1e-3, 0.05}) {
    sequence.prior->inverse_depth_sigma = sigma;
    const RunResult ekf = run_estimator(sequence, configuration, "ekf");
    const RunResult window = run_estimator(sequence, configuration, "window");
    ASSERT_EQ(ekf.filtered.size(), std::size_t{kFrames});
    ASSERT_EQ(window.filtered.size(), std::size_t{kFrames});
    double most = 0.0;  // in standard deviations of the EKF
    for (std::size_t i = 1; i < ekf.filtered.size(); ++i) {
      const CameraEstimate &a = ekf.filtered[i], &b = window.filtered[i];
      const Eigen::Vector3d apart = a.state.position - b.state.position;
      const Eigen::Matrix3d P = a.covariance.topLeftCorner<3, 3>();
      const double distance = std::sqrt(apart.dot(P.llt().solve(apart)));
      ASSERT_TRUE(std::isfinite(distance));
      most = std::max(most, distance);
    }
    const auto nees = [&](const RunResult& run) {
      return pose_consistency(pair_with_truth(sequence, run.filtered)).pose.mean;
    };
    std::printf(
        "sigma of the inverse depth %g: at most %.2f sigma apart, pose NEES %.1f and %.1f\n", sigma,
        most, nees(ekf), nees(window));
    if (sigma < 0.01) {
      EXPECT_LT(most, 0.5);
    } else {
      EXPECT_GT(most, 3.0);  // not cured; docs/robustness.md says so
    }
  }
}

// One measurement that cannot be changes nothing but itself.
TEST(FarPixel, IsNotUsed) {
  for (const char* name : {"ekf", "window"}) {
    Sequence without = circle();
    without.frames[20].observations.pop_back();
    const RunResult a = run_estimator(far_pixel(20), {}, name);
    const RunResult b = run_estimator(without, {}, name);
    EXPECT_FALSE(a.diverged);
    const Eigen::Vector3d apart =
        a.filtered.back().state.position - b.filtered.back().state.position;
    EXPECT_LT(apart.norm(), 0.01) << name;
  }
}

}  // namespace
}  // namespace slammot
