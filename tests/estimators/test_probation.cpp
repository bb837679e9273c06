// Landmarks that enter at their third sighting with all their measurements (`policy.probation`).
#include <gtest/gtest.h>

#include <set>

#include "datasets/simulation/scenario.h"
#include "eval/configuration/setup.h"
#include "filters/ekf.h"
#include "smoothers/batch.h"
#include "smoothers/window/window.h"
#include "tests/estimators/fixture/linearisation_fixture.h"

namespace slammot {
namespace {

constexpr int kFrames = 24;
constexpr int kWild = 900000;

// True labels and no gate: both ways to enter use the same measurements.
Configuration configured(int probation) {
  Configuration configuration;
  configuration.model.classifier.name = "truth";
  configuration.model.labels.rule = LabelRule::kOneWay;
  configuration.model.labels.first_frame = FirstFrameLabels::kStatic;
  configuration.model.gate = {1.0, 1.0};
  configuration.model.depth_prior = DepthPriorSource::kFixed;
  configuration.model.adaptive_motion = false;  // it follows the estimates on the way
  configuration.model.policy.probation = probation;
  configuration.window.frames = kFrames;
  return configuration;
}

// Tracks measured in each frame from their first to the last frame, born long before the last.
Sequence lasting_tracks(unsigned seed) {
  Sequence sequence = simulate("circle", {{"frames", std::to_string(kFrames)}}, seed);
  std::map<int, int> count, first;
  for (const Frame& frame : sequence.frames) {
    for (const Observation& z : frame.observations) {
      ++count[z.track];
      first.try_emplace(z.track, frame.index);
    }
  }
  for (Frame& frame : sequence.frames) {
    std::erase_if(frame.observations, [&](const Observation& z) {
      return count[z.track] != kFrames - first[z.track] || first[z.track] > kFrames / 2;
    });
  }
  return sequence;
}

using Make = std::function<std::unique_ptr<Estimator>(const slammot::Setup&, const Configuration&)>;

const Make kEkf = [](const slammot::Setup& setup, const Configuration& c) {
  return make_ekf(setup, c.model, c.ekf);
};
const Make kWindow = [](const slammot::Setup& setup, const Configuration& c) {
  return make_window(setup, c.model, c.window);
};

struct Result {
  CameraEstimate camera;
  std::map<int, LandmarkEstimate> landmarks;
  std::map<int, int> admitted;  // frame in which each was first there
};

Result run(const Make& make, const Sequence& sequence, const Configuration& configuration) {
  const auto estimator = make(make_setup(sequence, configuration), configuration);
  NoStages stages;
  Result result;
  for (const Frame& frame : sequence.frames) {
    estimator->process(frame, stages);
    for (const LandmarkEstimate& l : estimator->landmarks()) {
      result.admitted.try_emplace(l.track, frame.index);
    }
  }
  result.camera = estimator->camera();
  for (const LandmarkEstimate& l : estimator->landmarks()) result.landmarks[l.track] = l;
  return result;
}

// [sigma of b]
double distance(const CameraEstimate& a, const CameraEstimate& b) {
  const Vector12d sigma = b.covariance.diagonal().cwiseSqrt();
  return boxminus(a.state, b.state).cwiseQuotient(sigma).cwiseAbs().maxCoeff();
}

// The window's factors are then the same, so that its optimum is.
TEST(ProbationInTheWindow, KnowsWhatItWouldHaveKnownFromFirstSight) {
  for (const unsigned seed : {1u, 2u}) {
    const Sequence sequence = lasting_tracks(seed);
    const Result first = run(kWindow, sequence, configured(1));
    const Result third = run(kWindow, sequence, configured(3));
    ASSERT_EQ(first.landmarks.size(), third.landmarks.size());
    int later = 0;
    for (const auto& [track, frame] : third.admitted) later += frame - first.admitted.at(track);
    EXPECT_GE(later, 20) << "seed " << seed;
    EXPECT_LT(distance(third.camera, first.camera), 0.02);
    EXPECT_LT(test::relative_difference(third.camera.covariance, first.camera.covariance), 0.02);
    for (const auto& [track, l] : first.landmarks) {
      const LandmarkEstimate& other = third.landmarks.at(track);
      const Eigen::Vector3d sigma = l.position_covariance.diagonal().cwiseSqrt();
      EXPECT_LT((other.position - l.position).cwiseQuotient(sigma).norm(), 0.1) << track;
      EXPECT_EQ(other.observations, l.observations);
      EXPECT_EQ(other.first_frame, l.first_frame);
    }
  }
}

// The filter linearises elsewhere: it knows the same but for that.
TEST(ProbationInTheFilter, KnowsWhatItWouldHaveKnownFromFirstSight) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    const Sequence sequence = lasting_tracks(seed);
    const Result first = run(kEkf, sequence, configured(1));
    const Result third = run(kEkf, sequence, configured(3));
    ASSERT_EQ(first.landmarks.size(), third.landmarks.size());
    EXPECT_LT(distance(third.camera, first.camera), 0.5);
    EXPECT_LT(test::relative_difference(third.camera.covariance, first.camera.covariance), 0.1);
  }
}

// Without the pixels of the first two sightings it would know less of them.
TEST(ProbationInTheFilter, UsesThePastPixels) {
  const Sequence sequence = lasting_tracks(1);
  Sequence without = sequence;
  std::map<int, int> seen;
  for (const Observation& z : sequence.frames[0].observations) seen[z.track] = 2;
  for (Frame& frame : without.frames) {
    std::erase_if(frame.observations, [&](const Observation& z) { return ++seen[z.track] <= 2; });
  }
  const Result with = run(kEkf, sequence, configured(3));
  const Result less = run(kEkf, without, configured(1));
  double ratios = 0.0;
  int later = 0;
  for (const auto& [track, frame] : with.admitted) {
    if (frame == 0) continue;
    ratios += with.landmarks.at(track).position_covariance.trace() /
              less.landmarks.at(track).position_covariance.trace();
    ++later;
  }
  ASSERT_GT(later, 5);
  std::printf("variance over that without the first pixels: %.2f of %d\n", ratios / later, later);
  EXPECT_LT(ratios / later, 0.9);
}

class ProbationOf : public testing::TestWithParam<bool> {
 protected:
  const Make& make() const { return GetParam() ? kWindow : kEkf; }
};

INSTANTIATE_TEST_SUITE_P(Families, ProbationOf, testing::Bool(),
                         [](const auto& family) { return family.param ? "window" : "ekf"; });

// A track whose pixels are of no one point, and one that is lost at once.
TEST_P(ProbationOf, KeepsOutWhatIsNoPoint) {
  Sequence sequence = lasting_tracks(1);
  for (Frame& frame : sequence.frames) {
    const double jump = frame.index % 2 == 0 ? 0.0 : 150.0;
    if (frame.index >= 5) frame.observations.push_back({kWild, {100.0 + jump, 80.0 + jump}});
    if (frame.index == 8 || frame.index == 9) {
      frame.observations.push_back({kWild + 1, {200.0, 100.0}});
    }
  }
  Configuration configuration = configured(3);
  configuration.model.classifier.name = "odds";
  configuration.model.gate = {};
  const Result result = run(make(), sequence, configuration);
  EXPECT_FALSE(result.admitted.contains(kWild));
  EXPECT_FALSE(result.admitted.contains(kWild + 1));
  EXPECT_GT(result.landmarks.size(), 15u);
}

TEST(Probation, OfABatchGivesItTheSamePixels) {
  const Sequence sequence = lasting_tracks(2);
  std::vector<std::vector<CameraEstimate>> smoothed;
  for (const int probation : {1, 3}) {
    const Configuration configuration = configured(probation);
    const auto batch =
        make_batch(make_setup(sequence, configuration), configuration.model, configuration.window);
    NoStages stages;
    for (const Frame& frame : sequence.frames) batch->process(frame, stages);
    smoothed.push_back(batch->smoothed(stages));
  }
  ASSERT_EQ(smoothed[0].size(), smoothed[1].size());
  for (std::size_t i = 1; i < smoothed[0].size(); ++i) {
    EXPECT_LT(distance(smoothed[1][i], smoothed[0][i]), 1e-3) << "frame " << i;
  }
}

TEST(Probation, NeedsPastPosesAndTheStandardLinearisation) {
  const Sequence sequence = lasting_tracks(1);
  Configuration fej = configured(3);
  fej.ekf.linearisation = FilterLinearisation::kFej;
  fej.window.linearisation = WindowLinearisation::kFej;
  EXPECT_THROW(run(kEkf, sequence, fej), std::invalid_argument);
  EXPECT_THROW(run(kWindow, sequence, fej), std::invalid_argument);
  Configuration narrow = configured(3);
  narrow.window.frames = 2;
  EXPECT_THROW(run(kWindow, sequence, narrow), std::invalid_argument);
}

}  // namespace
}  // namespace slammot
