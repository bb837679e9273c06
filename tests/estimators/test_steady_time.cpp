// Stating a large acceleration of movers must not hide what rests (`prior.steady_time`).
#include <gtest/gtest.h>

#include "datasets/simulation/scenario.h"
#include "eval/configuration/setup.h"
#include "filters/ekf.h"
#include "smoothers/window/window.h"

namespace slammot {
namespace {

TEST(SteadyTime, BoundsTheNoiseOfWhatIsNotKnownToMove) {
  LandmarkPrior prior;
  prior.max_speed = 4.0;
  prior.acceleration = 3.0;
  prior.jerk = 0.1;
  prior.steady_time = 10.0;
  EXPECT_EQ(prior.noise(true).acceleration, 3.0);
  EXPECT_DOUBLE_EQ(prior.noise(false).acceleration, 0.2);
  EXPECT_DOUBLE_EQ(prior.noise(false).jerk, 0.1);
  prior.jerk = 5.0;
  EXPECT_DOUBLE_EQ(prior.noise(false).jerk, 0.3);
  prior.acceleration = 0.1;
  EXPECT_EQ(prior.noise(false).acceleration, 0.1);
  prior.steady_time = 0.0;
  prior.acceleration = 3.0;
  EXPECT_EQ(prior.noise(false).acceleration, 3.0);
}

struct Found {
  double rmse = 0.0;
  int at_rest = 0;  // static ones that are called so
};

Found run(Estimator& estimator, const Sequence& sequence) {
  NoStages stages;
  double square = 0.0;
  std::map<int, Label> labels;
  for (const Frame& frame : sequence.frames) {
    for (const LandmarkEstimate& l : estimator.process(frame, stages).retired) {
      labels[l.track] = l.label;
    }
    const CameraState& truth = *sequence.truth[static_cast<std::size_t>(frame.index)];
    square += (estimator.camera().state.position - truth.position).squaredNorm();
  }
  for (const LandmarkEstimate& l : estimator.landmarks()) labels[l.track] = l.label;
  Found found;
  found.rmse = std::sqrt(square / static_cast<double>(sequence.frames.size()));
  for (const auto& [track, label] : labels) {
    const auto truth = sequence.landmarks.find(track);
    if (truth == sequence.landmarks.end() || truth->second.label != Label::kStatic) continue;
    found.at_rest += label == Label::kStatic ? 1 : 0;
  }
  return found;
}

TEST(SteadyTime, ALargeAccelerationDoesNotHideWhatRests) {
  const Sequence sequence = simulate("circle", {{"frames", "120"}}, 4);
  for (const bool is_window : {false, true}) {
    std::vector<Found> found;
    for (const auto& [acceleration, time] : {std::pair{0.1, 10.0}, {3.0, 10.0}, {3.0, 0.0}}) {
      Configuration configuration;
      configuration.prior.acceleration = acceleration;
      configuration.prior.steady_time = time;
      configuration.window.frames = 10;
      configuration.ekf.static_enough = 0;     // so that movers can draw the camera with them
      configuration.ekf.second_order = false;  // protects the EKF too: 1.2 times at the end
      const slammot::Setup setup = make_setup(sequence, configuration);
      const auto estimator = is_window
                                 ? make_window(setup, configuration.model, configuration.window)
                                 : make_ekf(setup, configuration.model, configuration.ekf);
      found.push_back(run(*estimator, sequence));
      std::printf("%s, %.1f m/s^2, %2.0f s: RMSE %.3f m, %d found at rest\n",
                  is_window ? "window" : "ekf", acceleration, time, found.back().rmse,
                  found.back().at_rest);
    }
    EXPECT_GT(found[1].at_rest, 9 * found[0].at_rest / 10);
    EXPECT_LT(found[2].at_rest, found[1].at_rest);
    EXPECT_LT(found[1].rmse, 1.5 * found[0].rmse);
    EXPECT_GT(found[2].rmse, 1.4 * found[1].rmse);  // 3 where no label's motion is remembered
  }
}

}  // namespace
}  // namespace slammot
