// A window of one frame and one Gauss-Newton step is the EKF; a window as long as the sequence is
// the batch. On `circle`, with births, classifications and deaths of landmarks.
#include <gtest/gtest.h>

#include "datasets/simulation/scenario.h"
#include "eval/configuration/setup.h"
#include "filters/ekf.h"
#include "models/landmarks/landmark_models.h"
#include "smoothers/batch.h"
#include "smoothers/window/window.h"
#include "tests/estimators/fixture/linearisation_fixture.h"

namespace slammot {
namespace {

using test::relative_difference;

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
// a window keeps a pruned landmark until its last measurement leaves.
void expect_same(const FrameReport& a, const FrameReport& b) {
  ASSERT_EQ(a.accepted, b.accepted);
  ASSERT_EQ(a.rejected, b.rejected);
  ASSERT_EQ(a.out_of_view, b.out_of_view);
  ASSERT_EQ(a.admitted, b.admitted);
  ASSERT_EQ(a.negative_inverse_depth, b.negative_inverse_depth);
  ASSERT_NEAR(a.nis_sum, b.nis_sum, 1e-9 * (1.0 + a.nis_sum));
  ASSERT_NEAR(a.joint_nis, b.joint_nis, 1e-8 * (1.0 + a.joint_nis));
  ASSERT_EQ(a.predictions.size(), b.predictions.size());
  for (std::size_t i = 0; i < a.predictions.size(); ++i) {
    const Prediction &p = a.predictions[i], &q = b.predictions[i];
    ASSERT_EQ(p.track, q.track);
    ASSERT_EQ(p.measured, q.measured);
    ASSERT_LT((p.pixel - q.pixel).norm(), 1e-7 * std::sqrt(p.S.norm()));
    ASSERT_LT(relative_difference(q.S, p.S), 1e-7);
  }
  ASSERT_EQ(a.retired.size(), b.retired.size());
  for (std::size_t i = 0; i < a.retired.size(); ++i) {
    ASSERT_EQ(a.retired[i].track, b.retired[i].track);
    ASSERT_EQ(a.retired[i].label, b.retired[i].label);
    ASSERT_EQ(a.retired[i].observations, b.retired[i].observations);
    ASSERT_EQ(a.retired[i].decision_frame, b.retired[i].decision_frame);
    ASSERT_EQ(a.retired[i].last_frame, b.retired[i].last_frame);
  }
}

// No two measurements of a frame need be equally exact.
Sequence uneven(Sequence sequence) {
  for (Frame& frame : sequence.frames) {
    for (Observation& z : frame.observations) {
      z.relative_sigma = 0.8 + 0.2 * ((z.track + frame.index) % 5);
    }
  }
  return sequence;
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

class OneFrameOf : public testing::TestWithParam<Case> {};

TEST_P(OneFrameOf, AndOneStepIsTheEkf) {
  // Movers in the first frame are labelled static by rule: labels to take back.
  const Sequence sequence =
      uneven(simulate("circle", {{"frames", kFrames}, {"first_moving", "3"}}, 3));
  slammot::Setup setup = make_setup(sequence, Configuration{});
  ModelOptions models;
  models.labels.rule = GetParam().labels == "one_way" ? LabelRule::kOneWay : LabelRule::kReversible;
  models.labels.memory = 0;  // a window remembers its pixels, here one, a filter all of them
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
  WindowOptions one;
  one.frames = 1;
  one.iterations = 1;
  one.linearisation = WindowLinearisation::kStandard;
  const auto ekf = make_ekf(setup, models,
                            {.static_enough = 0,
                             .equivariant_scale = false,
                             .second_order = false});  // a window relinearises
  const auto window = make_window(setup, models, one);
  ekf->keep_predictions();
  window->keep_predictions();
  NoStages stages;
  double worst_state = 0.0, worst_covariance = 0.0, worst_landmark = 0.0;
  int born = 0, dead = 0, decided = 0, negative = 0;
  for (const Frame& frame : sequence.frames) {
    const FrameReport a = ekf->process(frame, stages), b = window->process(frame, stages);
    SCOPED_TRACE("frame " + std::to_string(frame.index));
    expect_same(a, b);
    if (HasFatalFailure()) return;
    negative += a.negative_inverse_depth;
    born += a.admitted;
    dead += static_cast<int>(a.retired.size());
    const CameraEstimate x = ekf->camera(), y = window->camera();
    const Vector12d d = boxminus(y.state, x.state);
    const Vector12d sigma = x.covariance.diagonal().cwiseSqrt();
    worst_state = std::max(worst_state, d.cwiseQuotient(sigma).cwiseAbs().maxCoeff());
    worst_covariance = std::max(worst_covariance, relative_difference(y.covariance, x.covariance));
  }
  const auto landmarks = ekf->landmarks(), same = window->landmarks();
  ASSERT_EQ(landmarks.size(), same.size());
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    ASSERT_EQ(landmarks[i].track, same[i].track);
    ASSERT_EQ(landmarks[i].label, same[i].label);
    ASSERT_EQ(landmarks[i].decision_frame, same[i].decision_frame);
    decided += landmarks[i].decision_frame && !landmarks[i].by_rule;
    worst_landmark = std::max(
        worst_landmark,
        relative_difference(same[i].position_covariance, landmarks[i].position_covariance));
    const Eigen::Vector3d sigma = landmarks[i].position_covariance.diagonal().cwiseSqrt();
    const Eigen::Vector3d moved = same[i].position - landmarks[i].position;
    worst_landmark = std::max(worst_landmark, moved.cwiseQuotient(sigma).cwiseAbs().maxCoeff());
  }
  RecordProperty("state", std::to_string(worst_state));
  std::printf(
      "born %d, dead %d, decided %d; largest difference: state %.2g sigma, covariance %.2g, "
      "landmark covariance %.2g\n",
      born, dead, decided, worst_state, worst_covariance, worst_landmark);
  // 1e-6 is asked for; what is seen is 1e-11 and better. Near rho = 0, where the wide depth prior
  // leads, a position's covariance goes with rho^-4 and magnifies rounding.
  const bool wide = GetParam().inverse_depth_sigma > 0.0;
  EXPECT_LT(worst_state, 1e-9);
  EXPECT_LT(worst_covariance, 1e-9);
  EXPECT_LT(worst_landmark, wide ? 1e-7 : 1e-9);
  EXPECT_GT(born, 50);
  EXPECT_GT(dead, 5);
  EXPECT_GT(decided, 10);
  if (GetParam().inverse_depth_sigma > 0.0) {
    EXPECT_GT(negative, 0);  // or the case compares nothing
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

// With Jacobians at the truth they are two linearisations of one model: the window's motion factor
// is taken where the truth ends up, the EKF's where it would have gone without noise.
TEST(OneFrame, AtTheTruthIsTheIdealEkf) {
  const Sequence sequence = simulate("circle", {{"frames", "120"}}, 3);
  Configuration configuration;
  configuration.ekf.linearisation = FilterLinearisation::kIdeal;
  configuration.window.linearisation = WindowLinearisation::kIdeal;
  configuration.window.frames = configuration.window.iterations = 1;
  configuration.model.gate = {0.999999, 1.0};
  configuration.model.classifier.name = "truth";
  configuration.model.labels.rule = LabelRule::kOneWay;
  const slammot::Setup setup = make_setup(sequence, configuration);
  const auto ekf = make_ekf(setup, configuration.model, configuration.ekf);
  const auto window = make_window(setup, configuration.model, configuration.window);
  NoStages stages;
  double worst_state = 0.0, worst_covariance = 0.0;
  for (const Frame& frame : sequence.frames) {
    const FrameReport a = ekf->process(frame, stages), b = window->process(frame, stages);
    ASSERT_EQ(a.accepted, b.accepted) << "frame " << frame.index;
    const CameraEstimate x = ekf->camera(), y = window->camera();
    const Vector12d sigma = x.covariance.diagonal().cwiseSqrt();
    const Vector12d d = boxminus(y.state, x.state).cwiseQuotient(sigma);
    worst_state = std::max(worst_state, d.cwiseAbs().maxCoeff());
    worst_covariance = std::max(worst_covariance, relative_difference(y.covariance, x.covariance));
  }
  std::printf("largest difference: state %.2g sigma, covariance %.2g\n", worst_state,
              worst_covariance);
  EXPECT_LT(worst_state, 0.05);
  EXPECT_LT(worst_covariance, 0.05);
}

TEST(ManySteps, MakeItTheIteratedEkf) {
  const Sequence sequence = simulate("circle", {{"frames", "40"}}, 3);
  const slammot::Setup setup = make_setup(sequence, Configuration{});
  ModelOptions models;
  models.classifier.name = "truth";
  // So many steps that both are at the minimum: the way there is not the same (Marquardt's
  // damping).
  EkfOptions iterated;
  iterated.iterations = 30;
  iterated.static_enough = 0;
  iterated.equivariant_scale = false;
  iterated.second_order = false;
  WindowOptions one;
  one.frames = 1;
  one.iterations = 30;
  one.linearisation_error = 1e-12;
  one.linearisation = WindowLinearisation::kStandard;
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

void expect_the_batch(const Sequence& sequence, const slammot::Setup& setup,
                      const ModelOptions& models, const WindowOptions& whole) {
  const auto window = make_window(setup, models, whole);
  const auto batch = make_batch(setup, models, whole);
  NoStages stages;
  for (const Frame& frame : sequence.frames) {
    window->process(frame, stages);
    batch->process(frame, stages);
  }
  const auto a = window->smoothed(stages), b = batch->smoothed(stages);
  ASSERT_EQ(a.size(), sequence.frames.size());
  ASSERT_EQ(b.size(), sequence.frames.size());
  double worst_state = 0.0, worst_covariance = 0.0;
  for (std::size_t i = 1; i < a.size(); ++i) {
    const Vector12d d = boxminus(a[i].state, b[i].state);
    const Vector12d sigma = b[i].covariance.diagonal().cwiseSqrt();
    worst_state = std::max(worst_state, d.cwiseQuotient(sigma).cwiseAbs().maxCoeff());
    worst_covariance =
        std::max(worst_covariance, relative_difference(a[i].covariance, b[i].covariance));
  }
  std::printf("largest difference: state %.2g sigma, covariance %.2g\n", worst_state,
              worst_covariance);
  EXPECT_LT(worst_state, 1e-4);
  EXPECT_LT(worst_covariance, 1e-4);
}

class WholeSequence : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(DepthPrior, WholeSequence, testing::Values("fixed", "empirical"));

TEST_P(WholeSequence, WindowIsTheBatch) {
  const Sequence sequence = uneven(simulate("circle", {{"frames", "20"}}, 2));
  const slammot::Setup setup = make_setup(sequence, Configuration{});
  ModelOptions models;
  models.classifier.name = "truth";
  models.depth_prior = source_of(GetParam());
  WindowOptions whole;
  whole.frames = 1000;
  whole.iterations = 40;
  whole.linearisation_error = 1e-10;
  whole.linearisation = WindowLinearisation::kStandard;
  expect_the_batch(sequence, setup, models, whole);
}

// Where only the first velocity tells the scale both take the camera's noise in metres, in the cost
// and in the covariance; our own solver does not (noise_scale.h).
TEST(WholeSequenceOnCeres, WindowIsTheBatchWhereOnlyTheVelocityTellsTheScale) {
  const Sequence sequence = simulate("circle", {{"frames", "12"}, {"known", "0"}}, 2);
  Configuration configuration;
  assign(configuration, {"prior.mean_sigma", "1"});
  assign(configuration, {"prior.spread", "relative"});
  ModelOptions models = configuration.model;
  models.classifier.name = "truth";
  WindowOptions whole;
  whole.frames = 1000;
  whole.solver = WindowSolver::kCeres;
  expect_the_batch(sequence, make_setup(sequence, configuration), models, whole);
}

// Where nothing moves it is one cost in other coordinates: only the way to its minimum differs.
TEST(Batch, HasOneMinimumInEveryParametrisation) {
  const Sequence sequence = simulate("circle", {{"frames", "20"}, {"moving", "0"}}, 2);
  const slammot::Setup setup = make_setup(sequence, Configuration{});
  ModelOptions models;
  models.landmark = "inverse_depth";
  models.depth_prior = DepthPriorSource::kFixed;
  models.adaptive_motion = false;  // it follows the window's estimates on the way
  models.gate = {0.999999, 1.0};
  std::vector<CameraEstimate> first;
  for (const PointFunctions& point : point_table()) {
    SCOPED_TRACE(point.name);
    models.point = point.name;
    const auto batch = make_batch(setup, models, {});
    NoStages stages;
    int rejected = 0;
    for (const Frame& frame : sequence.frames) rejected += batch->process(frame, stages).rejected;
    EXPECT_EQ(rejected, 0);
    const std::vector<CameraEstimate> cameras = batch->smoothed(stages);
    ASSERT_EQ(cameras.size(), sequence.frames.size());
    if (first.empty()) first = cameras;
    double worst = 0.0;
    for (std::size_t i = 1; i < cameras.size(); ++i) {
      const Vector12d d = boxminus(cameras[i].state, first[i].state);
      const Vector12d sigma = first[i].covariance.diagonal().cwiseSqrt();
      worst = std::max(worst, d.cwiseQuotient(sigma).cwiseAbs().maxCoeff());
    }
    std::printf("%s: largest difference %.2g sigma\n", std::string(point.name).c_str(), worst);
    EXPECT_LT(worst, 1e-3);
  }
}

}  // namespace
}  // namespace slammot
