// `window.prior: cameras`: landmarks leave with the frame of their birth, and what is left of them
// is what they say of the cameras.
#include <gtest/gtest.h>

#include <set>

#include "datasets/simulation/scenario.h"
#include "tests/smoothers/fixture/looped_window.h"

namespace slammot {
namespace {

Configuration of(const std::vector<std::string>& settings) {
  Configuration configuration;
  assign(configuration, {"window.prior", "cameras"});
  assign(configuration, {"window.frames", "10"});
  for (const std::string& text : settings) assign(configuration, parse_assignment(text));
  return configuration;
}

std::set<VariableId> cameras_and_scene(const Graph& graph) {
  std::set<VariableId> ids;
  for (const CameraMotionFactor& motion : graph.motions) {
    for (const GraphCamera& c : {motion.from, motion.to}) {
      ids.insert({c.position, c.orientation, c.rates});
    }
  }
  if (graph.scene) ids.insert(graph.scene->scene);
  return ids;
}

class CameraPrior : public testing::TestWithParam<std::string> {};

TEST_P(CameraPrior, HoldsNoLandmark) {
  const Sequence sequence = simulate("circle", {{"frames", "100"}}, 2);
  LoopedWindow run(sequence, of({GetParam()}));
  std::size_t held = 0, reborn = 0;
  std::set<int> seen;
  for (const Frame& frame : sequence.frames) {
    const FrameReport report = run.process(frame);
    for (const LandmarkEstimate& l : report.retired) seen.insert(l.track);
    for (const auto& [track, record] : run.loop->records()) {
      reborn += record.first_frame == frame.index && seen.contains(track);
      EXPECT_GT(record.first_frame, frame.index - 10);
    }
    const Graph& graph = run.window->graph();
    const std::set<VariableId> allowed = cameras_and_scene(graph);
    for (const MarginalPrior::Block& block : graph.prior().active.blocks()) {
      ++held;
      ASSERT_TRUE(allowed.contains(block.variable->id)) << "frame " << frame.index;
    }
    ASSERT_TRUE(graph.prior().inactive.empty());
    ASSERT_TRUE(run.loop->camera().state.position.allFinite());
  }
  EXPECT_GT(held, 0u);
  EXPECT_GT(reborn, 0u);
}

INSTANTIATE_TEST_SUITE_P(With, CameraPrior,
                         testing::Values("prior.mean_sigma=0", "prior.mean_sigma=0.05",
                                         "window.retest=true", "window.linearisation=fej"),
                         [](const auto& tested) {
                           std::string name = tested.param.substr(0, tested.param.find('='));
                           std::ranges::replace(name, '.', '_');
                           return name + std::to_string(tested.index);
                         });

TEST(CameraPriors, DropWouldKeepLandmarks) {
  const Sequence sequence = simulate("circle", {{"frames", "2"}}, 1);
  EXPECT_THROW(LoopedWindow(sequence, of({"collapse=drop"})), std::invalid_argument);
}

}  // namespace
}  // namespace slammot
