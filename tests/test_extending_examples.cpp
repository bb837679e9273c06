// The worked examples of docs/extending.md, which quotes them: that they compile is half the test.
// Each stands between its `example` and `end` lines; change the page with them.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>

#include "slammot/datasets/parameters.h"
#include "slammot/datasets/random_stream.h"
#include "slammot/datasets/reader.h"
#include "slammot/datasets/recording.h"
#include "slammot/datasets/scenario.h"
#include "slammot/datasets/sha256.h"
#include "slammot/datasets/statements.h"
#include "slammot/datasets/text_table.h"
#include "slammot/eval/metrics.h"
#include "slammot/eval/registry.h"
#include "slammot/eval/run.h"
#include "slammot/eval/setup.h"
#include "slammot/models/classification.h"
#include "slammot/models/landmark.h"
#include "slammot/models/landmark_estimate.h"
#include "slammot/tests/test_eval_fixture.h"

namespace slammot {
namespace {

// [example: landmark model]
// Dynamic inverse depth whose velocity decays: v' = e^(-dt/tau) v, x = (theta, phi, rho, v).
struct DecayingVelocity {
  static constexpr std::string_view kName = "decaying_velocity";
  static constexpr double kTau = 2.0;  // [s]

  static double decay(double dt) { return std::exp(-dt / kTau); }
  static double travel(double dt) { return kTau * (1.0 - decay(dt)); }  // of a unit velocity

  template <typename T>
  static Vector6<T> predict(const Vector6<T>& x, double dt) {
    const T rho = x(2);
    const Vector3<T> v = x.template tail<3>();
    const Vector3<T> g = direction(T(x(0)), T(x(1))) + rho * v * T(travel(dt));
    Vector6<T> y;
    y << angles(g, T(x(0))), rho / g.norm(), v * T(decay(dt));
    return y;
  }

  static Matrix6d predict_jacobian(const Vector6d& x, double dt) {
    const double rho = x(2), s = travel(dt);
    const Eigen::Vector3d v = x.tail<3>();
    const Eigen::Vector3d g = direction(x(0), x(1)) + rho * v * s;
    Eigen::Matrix<double, 3, 6> J_g_x;
    J_g_x << direction_jacobian(x(0), x(1)), v * s, rho * s * Eigen::Matrix3d::Identity();
    const double n = g.norm();
    Matrix6d F = Matrix6d::Zero();
    F.topRows<2>() = angles_jacobian(g) * J_g_x;
    F.row(2) = -rho / (n * n * n) * g.transpose() * J_g_x;
    F(2, 2) += 1.0 / n;
    F.bottomRightCorner<3, 3>().diagonal().setConstant(decay(dt));
    return F;
  }

  static Matrix6d noise_jacobian(const Vector6d& x) {
    Matrix6d J = Matrix6d::Identity();
    J.topLeftCorner<3, 3>() = noise_jacobian_static(x.head<3>());
    return J;
  }

  static Eigen::Vector3d velocity(const Vector6d& x) { return x.tail<3>(); }
  static Matrix36d velocity_jacobian(const Vector6d&) {
    Matrix36d J = Matrix36d::Zero();
    J.rightCols<3>().setIdentity();
    return J;
  }
  static Eigen::Vector3d motion_of(const Eigen::Vector3d& /*y*/, const Eigen::Vector3d& v) {
    return v;
  }
  static double density_scale(const Vector6d&) { return 1.0; }
  static double prior_sigma(const LandmarkPrior& prior) { return prior.velocity_sigma(); }
};
static_assert(LandmarkModel<DecayingVelocity>);
// [end]

Vector6d random_landmark(std::mt19937_64& engine) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  Vector6d x;
  x << 3.0 * unit(engine), 1.4 * unit(engine), 0.4 + 0.5 * unit(engine), 2.0 * unit(engine),
      2.0 * unit(engine), 2.0 * unit(engine);
  return x;
}

TEST(ExtendingLandmark, JacobianIsThatOfThePrediction) {
  std::mt19937_64 engine(1);
  for (int k = 0; k < 500; ++k) {
    const Vector6d x = random_landmark(engine);
    const double dt = 0.02 + 0.001 * (k % 100);
    const Matrix6d F = DecayingVelocity::predict_jacobian(x, dt);
    for (int i = 0; i < 6; ++i) {
      constexpr double kStep = 1e-5;
      const Vector6d d = kStep * Vector6d::Unit(i);
      const Vector6d numeric = (DecayingVelocity::predict(Vector6d(x + d), dt) -
                                DecayingVelocity::predict(Vector6d(x - d), dt)) /
                               (2.0 * kStep);
      ASSERT_LT((numeric - F.col(i)).norm(), 1e-7 * F.norm()) << x.transpose() << ", column " << i;
    }
  }
}

TEST(ExtendingLandmark, MovesAndNoiseStandsInMetres) {
  std::mt19937_64 engine(2);
  for (int k = 0; k < 100; ++k) {
    const Vector6d x = random_landmark(engine);
    if (std::abs(x(2)) < 1e-2) continue;
    // Two half steps are one step: the prediction is that of a differential equation.
    const Vector6d halves = DecayingVelocity::predict(DecayingVelocity::predict(x, 0.05), 0.05);
    EXPECT_LT((halves - DecayingVelocity::predict(x, 0.1)).norm(), 1e-12);
    Matrix6d J_metric = Matrix6d::Zero();
    J_metric.topLeftCorner<3, 3>() = position_jacobian(x.head<3>());
    J_metric.bottomRows<3>() = DecayingVelocity::velocity_jacobian(x);
    const Matrix6d I = DecayingVelocity::noise_jacobian(x) * J_metric;
    EXPECT_LT((I - Matrix6d::Identity()).cwiseAbs().maxCoeff(), 1e-7);
    EXPECT_TRUE(landmark_noise_root<DecayingVelocity>(x, 1.0, 0.1).allFinite());
  }
}

// [example: lens]
// The division model (Fitzgibbon 2001), undistorted = distorted / (1 + k |distorted|^2), solved for
// the distorted point.
struct DivisionLens {
  static constexpr std::string_view kName = "division";
  std::array<double, 1> coefficients{};

  template <typename T>
  Vector2<T> distort(const Vector2<T>& x) const {
    using std::sqrt;
    return x * (T(2.0) / (T(1.0) + sqrt(T(1.0) - T(4.0 * coefficients[0]) * x.squaredNorm())));
  }

  Eigen::Matrix2d jacobian(const Eigen::Vector2d& x) const {
    const double k = coefficients[0];
    const double root = std::sqrt(1.0 - 4.0 * k * x.squaredNorm());
    const double scale = 2.0 / (1.0 + root);
    const double slope = 4.0 * k / (root * (1.0 + root) * (1.0 + root));  // d scale / d |x|^2
    return scale * Eigen::Matrix2d::Identity() + 2.0 * slope * x * x.transpose();
  }
};
// [end]

TEST(ExtendingLens, IsItsDefinitionAndHasItsJacobian) {
  const DivisionLens lens{{-0.2}};
  for (const Eigen::Vector2d& x :
       {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(0.3, -0.4), Eigen::Vector2d(-1.0, 0.7)}) {
    const Eigen::Vector2d d = lens.distort(x);
    EXPECT_LT((d / (1.0 + lens.coefficients[0] * d.squaredNorm()) - x).norm(), 1e-14);
    for (int i = 0; i < 2; ++i) {
      const Eigen::Vector2d step = 1e-5 * Eigen::Vector2d::Unit(i);
      const Eigen::Vector2d numeric =
          (lens.distort(Eigen::Vector2d(x + step)) - lens.distort(Eigen::Vector2d(x - step))) /
          2e-5;
      EXPECT_LT((numeric - lens.jacobian(x).col(i)).norm(), 1e-8);
    }
  }
}

// [example: classifier]
// Static below a speed, moving above it, once two standard deviations say which.
class SpeedClassifier final : public Classifier {
 public:
  explicit SpeedClassifier(double speed) : speed_(speed) {}

  Label decide(const MotionBelief& belief) const override {
    const double w_per_v = std::cbrt(belief.density_scale);  // w = v, or w = rho v
    const double speed = belief.w.norm() / w_per_v;
    const double margin = 2.0 * std::sqrt(belief.covariance.trace()) / w_per_v;
    if (speed + margin < speed_) return Label::kStatic;
    return speed - margin > speed_ ? Label::kMoving : Label::kUnknown;
  }

 private:
  double speed_;  // [m/s]
};
// [end]

TEST(ExtendingClassifier, DecidesThroughItsInterface) {
  const std::unique_ptr<Classifier> classifier = std::make_unique<SpeedClassifier>(0.3);
  MotionBelief belief;
  belief.w = {0.1, 0.0, 0.0};
  belief.covariance = Eigen::Matrix3d::Identity();
  EXPECT_EQ(classifier->decide(belief), Label::kUnknown);
  belief.covariance *= 1e-4;
  EXPECT_EQ(classifier->decide(belief), Label::kStatic);
  belief.w.x() = 1.0;
  EXPECT_EQ(classifier->decide(belief), Label::kMoving);
  // The same point in scaled velocity, at rho = 0.2: u = rho v.
  belief.w *= 0.2;
  belief.covariance *= 0.04;
  belief.density_scale = 0.008;
  EXPECT_EQ(classifier->decide(belief), Label::kMoving);
  EXPECT_EQ(classifier->at_birth(7, true), Label::kStatic);
}

// [example: estimator]
// Dead reckoning: the camera's motion model alone, no measurement is used.
class DeadReckoning final : public Estimator {
 public:
  explicit DeadReckoning(const Setup& setup) : noise_(setup.camera_noise) {
    camera_.state = setup.initial.state;
    camera_.covariance = setup.initial.sigmas().cwiseAbs2().asDiagonal();
  }

  FrameReport process(const Frame& frame, StageListener& stages) override {
    stages.begin("predict");
    if (started_) predict_to(frame.timestamp);
    started_ = true;
    camera_.timestamp = frame.timestamp;
    FrameReport report;
    report.state_size = kCameraDim;
    return report;
  }

  CameraEstimate camera() const override { return camera_; }
  std::vector<LandmarkEstimate> landmarks() const override { return {}; }

 private:
  void predict_to(double timestamp) {
    const double dt = timestamp - camera_.timestamp;
    if (!(dt > 0.0)) throw std::invalid_argument("the time of a frame must increase");
    const Matrix12d F = predict_jacobian(camera_.state, dt);
    camera_.covariance =
        F * camera_.covariance * F.transpose() + camera_noise(noise_, camera_.state, dt);
    camera_.state = predict(camera_.state, dt);
  }

  MotionNoise noise_;
  CameraEstimate camera_;
  bool started_ = false;
};

constexpr EstimatorRow kDeadReckoning{
    "dead_reckoning", "the motion model alone", [](Configuration&) {},
    [](const Setup& setup, const Configuration&) -> std::unique_ptr<Estimator> {
      return std::make_unique<DeadReckoning>(setup);
    }};
// [end]

TEST(ExtendingEstimator, IsDrivenAndJudged) {
  // [example: driving]
  Sequence sequence = test::straight_line(5);  // x = 0, 1, 2, ... m, one second apart
  sequence.initial.emplace();
  sequence.initial->state.velocity = {1.0, 0.0, 0.0};

  const Configuration configuration;
  const auto setup = make_setup(sequence, configuration);
  const std::unique_ptr<Estimator> estimator = kDeadReckoning.make(setup, configuration);
  const RunResult run = drive(sequence, *estimator);
  const RunMetrics metrics = compute_metrics(sequence, run, configuration.model.gate_probability);
  // [end]
  ASSERT_FALSE(run.diverged);
  ASSERT_EQ(run.filtered.size(), 5u);
  ASSERT_TRUE(metrics.filtered.accuracy.value);
  EXPECT_LT(metrics.filtered.accuracy.value->position_rmse, 1e-12);
  EXPECT_GT(run.filtered[4].covariance(0, 0), run.filtered[3].covariance(0, 0));
}

// [example: reader]
// `pixels.txt`: rows `timestamp track u v` by time, then by track, from one camera.
bool is_pixel_list(const std::filesystem::path& folder) {
  return std::filesystem::is_regular_file(folder / "pixels.txt");
}

Sequence read_pixel_list(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "pixels.txt";
  const std::string text = read_text_file(file);
  Sequence sequence;
  sequence.name = folder.filename().string();
  sequence.folder = folder;
  sequence.camera = {640, 480, 385.0, 385.0, 319.5, 239.5, PinholeLens{}};
  TextTable table(file, text);
  while (table.next_blank_row(4)) {
    const double time = table.real(0);
    const Observation z{table.count(1), {table.real(2), table.real(3)}};
    std::vector<Frame>& frames = sequence.frames;
    if (frames.empty() || time > frames.back().timestamp) {
      frames.push_back({static_cast<int>(frames.size()), time, {}});
    } else if (time < frames.back().timestamp ||
               z.track <= frames.back().observations.back().track) {
      table.refuse("rows must be ordered by time, then by track");
    }
    frames.back().observations.push_back(z);
  }
  if (sequence.frames.empty()) throw InputError(file, 0, "no measurements");
  sequence.truth.resize(sequence.frames.size());
  Sha256 hash;
  hash.add(text);
  sequence.sha256 = hash.hex();
  return sequence;
}

constexpr ReaderRow kPixelList{"pixel_list", "pixels.txt", is_pixel_list, read_pixel_list};
// [end]

TEST(ExtendingReader, ReadsAndRefusesWithTheLine) {
  const test::TemporaryFolder folder;
  EXPECT_FALSE(kPixelList.recognises(folder.path()));
  test::write_text(folder.path() / "pixels.txt", "0.0 3 100 200\n0.0 5 120 90\n0.1 3 101 201\n");
  ASSERT_TRUE(kPixelList.recognises(folder.path()));
  const Sequence sequence = kPixelList.read(folder.path());
  ASSERT_EQ(sequence.frames.size(), 2u);
  EXPECT_EQ(sequence.frames[0].observations.size(), 2u);
  EXPECT_EQ(sequence.frames[1].observations[0].track, 3);
  test::write_text(folder.path() / "pixels.txt", "0.1 3 100 200\n0.0 5 120 90\n");
  try {
    kPixelList.read(folder.path());
    FAIL() << "time went back";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("pixels.txt:2:"), std::string::npos) << error.what();
  }
}

// [example: scenario]
// A camera at constant speed along z, between two walls of static points.
struct CorridorOptions {
  CorridorOptions() { recording.frames = 100; }
  RecordingOptions recording;
  StatementOptions statements;
  double speed = 1.0;  // [m/s]
  double width = 4.0;  // between the walls [m]
  int points = 200;
};

Parameters parameters(CorridorOptions& o) {
  return joined({{"speed", "of the camera [m/s]", &o.speed, kAbove0},
                 {"width", "between the walls [m]", &o.width, kAbove0},
                 {"points", "on both walls together", &o.points, 1}},
                joined(parameters(o.recording), parameters(o.statements)));
}

Sequence simulate_corridor(const CorridorOptions& options, std::uint64_t seed) {
  const RecordingOptions& recording = options.recording;
  std::vector<CameraState> trajectory;
  for (int i = 0; i < recording.frames; ++i) {
    CameraState& camera = trajectory.emplace_back();
    camera.velocity = {0.0, 0.0, options.speed};
    camera.position = camera.velocity * recording.time(i);
  }
  const double length = trajectory.back().position.z() + recording.max_depth;
  RandomStream random(seed, "points");
  std::vector<ScenePoint> points;
  for (int i = 0; i < options.points; ++i) {
    const double x = (i % 2 == 0 ? 0.5 : -0.5) * options.width;
    const double y = random.uniform(-1.0, 1.0), z = random.uniform(0.0, length);
    points.push_back({i, {x, y, z}});
  }
  Sequence sequence = record(recording, trajectory, points, seed);
  state(options.statements, prior_of(sequence), seed, sequence);
  return sequence;
}
// [end]

TEST(ExtendingScenario, IsSimulatedWithOverridesAndRun) {
  CorridorOptions options;
  apply({{"corridor.frames", "20"}, {"width", "3"}}, "corridor", parameters(options));
  EXPECT_THROW(apply({{"widht", "3"}}, "corridor", parameters(options)), std::invalid_argument);
  const Sequence sequence = simulate_corridor(options, 5), again = simulate_corridor(options, 5);
  ASSERT_EQ(sequence.frames.size(), 20u);
  ASSERT_FALSE(sequence.frames[0].observations.empty());
  EXPECT_EQ(sequence.frames[7].observations[0].pixel, again.frames[7].observations[0].pixel);
  const RunResult run = run_estimator(sequence, Configuration{}, "ekf");
  EXPECT_FALSE(run.diverged);
  EXPECT_EQ(run.filtered.size(), 20u);
}

}  // namespace
}  // namespace slammot
