// `window.retest`: an outlier that has passed the gate is let go when later frames speak against
// it, and a correct measurement that was refused returns.
#include <gtest/gtest.h>

#include "datasets/simulation/scenario.h"
#include "eval/run/run.h"
#include "tests/smoothers/fixture/looped_window.h"

namespace slammot {
namespace {

class WindowRun {
 public:
  WindowRun(const Sequence& sequence, bool retest, const GateOptions& gate = {})
      : run_(sequence, configuration(retest, gate)) {}

  void process(const Frame& frame) { run_.process(frame); }
  void process_until(const Sequence& sequence, std::size_t end) {
    for (; next_ < end; ++next_) process(sequence.frames[next_]);
  }
  bool knows(int track) const { return run_.loop->records().contains(track); }
  bool uses(const Observation& z) const {
    for (const GraphLandmark& l : run_.window->graph().landmarks) {
      for (const GraphPixel& pixel : l.pixels) {
        if (l.is_alive && pixel.z.pixel == z.pixel) return true;
      }
    }
    return false;
  }
  CameraEstimate camera() const { return run_.loop->camera(); }
  RetestCounts counts() const { return run_.window->retest_counts(); }

 private:
  static Configuration configuration(bool retest, const GateOptions& gate) {
    Configuration result;
    result.window.frames = 10;
    result.window.retest = retest;
    result.model.gate = gate;
    return result;
  }

  LoopedWindow run_;
  std::size_t next_ = 0;
};

Sequence clean(int frames) { return simulate("circle", {{"frames", std::to_string(frames)}}, 3); }

Observation* find(Frame& frame, int track) {
  const auto z = std::ranges::find(frame.observations, track, &Observation::track);
  return z == frame.observations.end() ? nullptr : &*z;
}

// Displaced so little that the gate does not see it, but the later frames of the window do.
TEST(Retest, LetsGoOfAnOutlierThatHasPassedTheGate) {
  constexpr std::size_t kFrame = 8, kEnd = 14;
  int tried = 0;
  const Sequence without = clean(kEnd);
  for (const Observation& z : without.frames[kFrame].observations) {
    Sequence sequence = without;
    Observation* outlier = find(sequence.frames[kFrame], z.track);
    if (!find(sequence.frames[kEnd - 1], z.track) || !find(sequence.frames[kFrame - 3], z.track)) {
      continue;
    }
    ++tried;
    outlier->pixel += Eigen::Vector2d(3.0, -3.0);
    WindowRun retested(sequence, true);
    retested.process_until(sequence, kFrame + 1);
    if (!retested.uses(*outlier)) continue;
    retested.process_until(sequence, kEnd);
    if (retested.uses(*outlier)) continue;
    WindowRun plain(sequence, false);
    plain.process_until(sequence, kFrame + 1);
    if (!plain.uses(*outlier)) continue;
    plain.process_until(sequence, kEnd);
    EXPECT_TRUE(plain.uses(*outlier));
    return;
  }
  FAIL() << "none of " << tried << " outliers was let go";
}

TEST(Retest, ACorrectMeasurementThatWasRefusedReturns) {
  const Sequence sequence = clean(25);
  WindowRun run(sequence, true);
  struct Refused {
    Observation z;
    int frame;
  };
  std::vector<Refused> refused;
  int returned = 0;
  for (const Frame& frame : sequence.frames) {
    std::vector<int> known;
    for (const Observation& z : frame.observations) {
      if (run.knows(z.track)) known.push_back(z.track);
    }
    run.process(frame);
    for (const Refused& r : refused) {
      returned += r.frame > frame.index - 10 && run.uses(r.z);
    }
    std::erase_if(refused, [&](const Refused& r) { return run.uses(r.z); });
    for (const Observation& z : frame.observations) {
      const bool was_known = std::ranges::find(known, z.track) != known.end();
      if (was_known && !run.uses(z)) refused.push_back({z, frame.index});
    }
  }
  EXPECT_GT(returned, 0);
  EXPECT_GE(run.counts().admitted, returned);
}

TEST(Retest, WithAnOpenGateNothingChanges) {
  const Sequence sequence = clean(25);
  WindowRun plain(sequence, false, {1.0, 1.0}), retested(sequence, true, {1.0, 1.0});
  for (const Frame& frame : sequence.frames) {
    plain.process(frame);
    retested.process(frame);
    ASSERT_EQ(plain.camera().state.position, retested.camera().state.position);
    ASSERT_EQ(plain.camera().covariance, retested.camera().covariance);
  }
  EXPECT_EQ(retested.counts(), RetestCounts{});
}

// What the window lets go of the batch behind it does not use either.
TEST(Retest, TheBatchFollows) {
  Configuration configuration;
  assign(configuration, {"window.frames", "10"});
  assign(configuration, {"window.retest", "true"});
  const Sequence sequence = clean(40);
  const RunResult run = run_estimator(sequence, configuration, "batch");
  EXPECT_FALSE(run.diverged);
  EXPECT_LT((run.smoothed.back().state.position - sequence.truth.back()->position).norm(), 0.5);
}

}  // namespace
}  // namespace slammot
