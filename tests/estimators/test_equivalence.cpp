// A window of one frame and one Gauss-Newton step is the EKF, with births, classifications and
// deaths of landmarks. One of all frames: test_whole_sequence.cpp.
#include <gtest/gtest.h>

#include <filesystem>

#include "datasets/readers/reader.h"
#include "datasets/simulation/scenario.h"
#include "eval/configuration/model_names.h"
#include "eval/configuration/setup.h"
#include "filters/ekf.h"
#include "models/landmarks/landmark_models.h"
#include "smoothers/window/window.h"
#include "tests/estimators/fixture/linearisation_fixture.h"
#include "tests/paths.h"

namespace slammot {
namespace {

using test::expect_same_labels;
using test::relative_difference;
using test::uneven;

struct Case {
  std::string landmark, collapse, classifier;
  double mean_sigma = 0.0;
  std::string labels = "one_way";
  std::string depth_prior = "fixed";
  double inverse_depth_sigma = 0.0;  // above 0: instead of the sequence's
  std::string point = "inverse_depth";
  bool relative = false;  // LandmarkPrior::spread_follows_mean
};

// Every field but the size of the state: a filter and a smoother that agree also report alike, but
// a window keeps a pruned landmark until its first measurement leaves.
// `rounding`: how many times more of it there is than in a room of some metres.
void expect_same(const FrameReport& a, const FrameReport& b, double rounding = 1.0) {
  const auto bar = [&](double of_a_room) { return rounding * of_a_room; };
  ASSERT_EQ(a.accepted, b.accepted);
  ASSERT_EQ(a.rejected, b.rejected);
  ASSERT_EQ(a.out_of_view, b.out_of_view);
  ASSERT_EQ(a.admitted, b.admitted);
  ASSERT_EQ(a.negative_inverse_depth, b.negative_inverse_depth);
  ASSERT_NEAR(a.nis_sum, b.nis_sum, bar(1e-9) * (1.0 + a.nis_sum));
  ASSERT_NEAR(a.joint_nis, b.joint_nis, bar(1e-8) * (1.0 + a.joint_nis));
  ASSERT_EQ(std::isnan(a.scale_change), std::isnan(b.scale_change));
  if (!std::isnan(a.scale_change)) {
    ASSERT_NEAR(a.scale_change, b.scale_change, bar(1e-9));
  }
  ASSERT_EQ(a.predictions.size(), b.predictions.size());
  for (std::size_t i = 0; i < a.predictions.size(); ++i) {
    const Prediction &p = a.predictions[i], &q = b.predictions[i];
    ASSERT_EQ(p.track, q.track);
    ASSERT_EQ(p.measured, q.measured);
    ASSERT_LT((p.pixel - q.pixel).norm(), bar(1e-7) * std::sqrt(p.S.norm()));
    ASSERT_LT(relative_difference(q.S, p.S), bar(1e-7)) << p.track << "\n" << p.S << "\n" << q.S;
  }
  expect_same_labels(a.retired, b.retired);
}

DepthPriorSource source_of(const std::string& name) {
  return name == "fixed" ? DepthPriorSource::kFixed : DepthPriorSource::kEmpirical;
}

void PrintTo(const Case& c, std::ostream* out) {
  *out << c.landmark << ' ' << c.collapse << ' ' << c.classifier << ' ' << c.labels << ' '
       << c.depth_prior << ' ' << c.point;
}

// Sanitizers make a frame fifty times slower, and ask for its code, not for its number.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr char kFrames[] = "45";
#else
constexpr char kFrames[] = "120";
#endif

// The largest differences of an EKF and a window of one frame and one step over a sequence, in
// sigma, and how much there was to compare.
struct Difference {
  double state = 0.0, covariance = 0.0, landmark = 0.0;
  int born = 0, dead = 0, decided = 0, negative = 0;
};

void compare_landmarks(const Estimator& ekf, const Estimator& window, Difference& d) {
  const auto landmarks = ekf.landmarks(), same = window.landmarks();
  ASSERT_EQ(landmarks.size(), same.size());
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    ASSERT_EQ(landmarks[i].track, same[i].track);
    ASSERT_EQ(landmarks[i].label, same[i].label);
    ASSERT_EQ(landmarks[i].decision_frame, same[i].decision_frame);
    d.decided += landmarks[i].decision_frame && !landmarks[i].by_rule;
    d.landmark = std::max(d.landmark, relative_difference(same[i].position_covariance,
                                                          landmarks[i].position_covariance));
    const Eigen::Vector3d sigma = landmarks[i].position_covariance.diagonal().cwiseSqrt();
    const Eigen::Vector3d moved = same[i].position - landmarks[i].position;
    d.landmark = std::max(d.landmark, moved.cwiseQuotient(sigma).cwiseAbs().maxCoeff());
  }
}

void compare(const Sequence& sequence, Estimator& ekf, Estimator& window, Difference& d,
             double rounding = 1.0) {
  NoStages stages;
  for (const Frame& frame : sequence.frames) {
    const FrameReport a = ekf.process(frame, stages), b = window.process(frame, stages);
    SCOPED_TRACE("frame " + std::to_string(frame.index));
    expect_same(a, b, rounding);
    if (testing::Test::HasFatalFailure()) return;
    expect_same_labels(ekf.landmarks_measured(frame.index), window.landmarks_measured(frame.index));
    if (testing::Test::HasFatalFailure()) return;
    d.negative += a.negative_inverse_depth;
    d.born += a.admitted;
    d.dead += static_cast<int>(a.retired.size());
    const CameraEstimate x = ekf.camera(), y = window.camera();
    const Vector12d difference = boxminus(y.state, x.state);
    const Vector12d sigma = x.covariance.diagonal().cwiseSqrt();
    d.state = std::max(d.state, difference.cwiseQuotient(sigma).cwiseAbs().maxCoeff());
    d.covariance = std::max(d.covariance, relative_difference(y.covariance, x.covariance));
  }
  compare_landmarks(ekf, window, d);
  std::printf(
      "born %d, dead %d, decided %d; largest difference: state %.2g sigma, covariance %.2g, "
      "landmark covariance %.2g\n",
      d.born, d.dead, d.decided, d.state, d.covariance, d.landmark);
}

// A window that neither remembers more cameras nor relinearises.
WindowOptions one_frame_and_step() {
  WindowOptions one;
  one.frames = 1;
  one.iterations = 1;
  return one;
}

// The EKF without the devices that a window cannot have (docs/frame.md, "Devices of one family").
ModelOptions without_gauge(ModelOptions models) {
  models.gauge = Gauge::kNone;
  return models;
}

EkfOptions without_devices() { return {.second_order = false}; }

class OneFrameOf : public testing::TestWithParam<Case> {};

// Every option beside its default, and every landmark model that moves.
TEST_P(OneFrameOf, AndOneStepIsTheEkf) {
  // Movers in the first frame are labelled static by rule: labels to undo.
  const Sequence sequence =
      uneven(simulate("circle", {{"frames", kFrames}, {"first_moving", "3"}}, 3));
  slammot::Setup setup = make_setup(sequence, Configuration{});
  ModelOptions models;
  models.labels.rule = GetParam().labels == "one_way" ? LabelRule::kOneWay : LabelRule::kReversible;
  setup.prior.mean_sigma = GetParam().mean_sigma;
  if (GetParam().inverse_depth_sigma > 0.0) {
    setup.prior.inverse_depth_sigma = GetParam().inverse_depth_sigma;
  }
  setup.prior.spread_follows_mean = GetParam().relative;
  models.depth_prior = source_of(GetParam().depth_prior);
  models.landmark = GetParam().landmark;
  models.point = GetParam().point;
  // With xyz adaptive noise makes more of the rounding errors: covariances differ by 1.4e-9.
  models.adaptive_motion = GetParam().point != "xyz";
  models.collapse = GetParam().collapse == "drop" ? Collapse::kDrop : Collapse::kCondition;
  models.classifier.name = GetParam().classifier;
  const auto ekf = make_ekf(setup, without_gauge(models), without_devices());
  const auto window = make_window(setup, models, one_frame_and_step());
  ekf->keep_predictions();
  window->keep_predictions();
  Difference d;
  compare(sequence, *ekf, *window, d);
  // 1e-6 is asked for; what is seen is 1e-11 and better. Near rho = 0, where the wide depth prior
  // leads, a position's covariance goes with rho^-4 and magnifies rounding.
  const bool wide = GetParam().inverse_depth_sigma > 0.0;
  EXPECT_LT(d.state, 1e-9);
  EXPECT_LT(d.covariance, 1e-9);
  EXPECT_LT(d.landmark, wide ? 1e-7 : 1e-9);
  EXPECT_GT(d.born, 50);
  EXPECT_GT(d.dead, 5);
  EXPECT_GT(d.decided, 10);
  if (wide) {
    EXPECT_GT(d.negative, 0);  // or the case compares nothing
  }
}

// Every landmark model that may move with every parametrisation, and each option beside it.
std::vector<Case> cases() {
  std::vector<Case> all = {
      {"dynamic_inverse_depth", "condition", "thesis"},
      {"scaled_velocity", "drop", "odds", 0.02},
      {"dynamic_inverse_depth", "drop", "thesis", 0.0, "reversible"},
      {"scaled_velocity", "drop", "thesis", 0.0, "reversible"},
      {"scaled_velocity", "condition", "thesis", 0.04, "reversible", "empirical"},
      {"scaled_velocity", "condition", "thesis", 0.0, "reversible", "fixed", 0.3},
      {"scaled_velocity", "drop", "odds", 0.04, "reversible", "empirical", 0.0, "inverse_depth",
       true},
      {"scaled_velocity", "drop", "odds", 0.04, "reversible", "fixed", 0.0, "xyz", true}};
  for (const LandmarkFunctions& landmark : landmark_table()) {
    if (!landmark.can_move) continue;
    const std::string name(landmark.name), point(landmark.point.name);
    all.push_back({name, "drop", "thesis", 0.0, "one_way", "empirical", 0.0, point});
    // The scene's mean, too, is one of inverse depth whatever y is.
    const double mean_sigma = landmark.point.linear_depth ? 0.0 : 0.04;
    all.push_back({name, "condition", "odds", mean_sigma, "reversible", "fixed", 0.0, point});
  }
  return all;
}

INSTANTIATE_TEST_SUITE_P(Models, OneFrameOf, testing::ValuesIn(cases()), [](const auto& tested) {
  return tested.param.landmark + "_" + tested.param.collapse + "_" + tested.param.classifier + "_" +
         tested.param.labels + "_" + tested.param.depth_prior + "_" + tested.param.point +
         (tested.param.inverse_depth_sigma > 0.0 ? "_wide" : "") +
         (tested.param.mean_sigma > 0.0 ? "_scene" : "") +
         (tested.param.relative ? "_relative" : "");
});

// README's sentence: at the defaults, with nothing switched off but those devices, a difference in
// the result is one between filtering and smoothing.
class OneFrameAtTheDefaults : public testing::TestWithParam<std::tuple<std::string, std::string>> {
};

// Of 120 frames as many as a test has time for: a shorter path of its own would be a faster one.
Sequence first_of(const std::string& scenario, ScenarioOverrides scene) {
  scene["frames"] = "120";
  return select_frames(simulate(scenario, scene, 3), 0, std::stoi(kFrames) - 1, 1);
}

std::optional<Sequence> sequence_of(const std::string& name) {
  if (name == "stereo" || name == "depths") {
    const auto rig =
        name == "stereo" ? std::pair("stereo", "0.3") : std::pair("depth_sigma", "0.1");
    return first_of("circle", {{"known", "0"}, rig});
  }
  if (name == "odds") return first_of("circle", {{"odds_right", "0.9"}});
  if (name == "nothing_known") return first_of("circle", {{"known", "0"}});
  if (name != "recording") return first_of(name, {});
  const std::filesystem::path drive =
      std::filesystem::path(test::kSharedData) / "kitti_klt" / "2011_09_26_drive_0001";
  if (!std::filesystem::exists(drive)) return std::nullopt;
  return select_frames(read_sequence(drive), 0, std::stoi(kFrames) - 1, 1);
}

TEST_P(OneFrameAtTheDefaults, AndOneStepIsTheEkf) {
  const auto& [name, landmark] = GetParam();
  const std::optional<Sequence> sequence = sequence_of(name);
  if (!sequence) GTEST_SKIP() << "no recording";
  Configuration configuration;
  configuration.model.landmark = landmark;
  const slammot::Setup setup = make_setup(*sequence, configuration);
  // On a road depths are a hundred times those of a room, and a covariance and a triangle of
  // information round apart: 3e-8 sigma is seen.
  const double rounding = name == "recording" ? 1000.0 : 1.0;
  Difference d;
  compare(*sequence, *make_ekf(setup, without_gauge(configuration.model), without_devices()),
          *make_window(setup, configuration.model, one_frame_and_step()), d, rounding);
  EXPECT_LT(d.state, rounding * 1e-9);
  EXPECT_LT(d.covariance, rounding * 1e-9);
  EXPECT_LT(d.landmark, rounding * 1e-9);
  EXPECT_GT(d.born, 50);
  EXPECT_GT(d.dead, 5);
  if (find_landmark(landmark, configuration.model.point).can_move) {
    EXPECT_GT(d.decided, 10);
  }
}

INSTANTIATE_TEST_SUITE_P(Sequences, OneFrameAtTheDefaults,
                         testing::Combine(testing::Values("circle", "square", "recording", "stereo",
                                                          "depths", "nothing_known", "odds"),
                                          testing::ValuesIn(names_of(landmark_list()))),
                         [](const auto& tested) {
                           return std::get<0>(tested.param) + "_" + std::get<1>(tested.param);
                         });

TEST(ManySteps, MakeItTheIteratedEkf) {
  const Sequence sequence = simulate("circle", {{"frames", "40"}}, 3);
  const slammot::Setup setup = make_setup(sequence, Configuration{});
  ModelOptions models;
  models.classifier.name = "truth";
  // So many steps that both are at the minimum: the way there is not the same (Marquardt's
  // damping).
  EkfOptions iterated;
  iterated.iterations = 30;
  iterated.second_order = false;
  WindowOptions one;
  one.frames = 1;
  one.iterations = 30;
  one.linearisation_error = 1e-12;
  const auto ekf = make_ekf(setup, models, iterated);
  const auto window = make_window(setup, models, one);
  NoStages stages;
  double worst = 0.0;
  for (const Frame& frame : sequence.frames) {
    ekf->process(frame, stages);
    window->process(frame, stages);
    const CameraEstimate x = ekf->camera();
    const Vector12d d = boxminus(window->camera().state, x.state);
    const Vector12d sigma = x.covariance.diagonal().cwiseSqrt();
    worst = std::max(worst, d.cwiseQuotient(sigma).cwiseAbs().maxCoeff());
  }
  std::printf("largest difference of the state: %.2g sigma\n", worst);
  EXPECT_LT(worst, 1e-4);
}

}  // namespace
}  // namespace slammot
