// Labels are judged against what the object was when it was last measured.
#include <gtest/gtest.h>

#include "datasets/native/native_writer.h"
#include "datasets/simulation/scenario.h"
#include "eval/metrics/labels/label_truth.h"
#include "eval/output/run_writer.h"
#include "eval/run/evaluate.h"
#include "eval/run/run.h"
#include "tests/eval/fixture.h"

namespace slammot {
namespace {

using test::FakeEstimator;
using test::landmark;

constexpr int kLabelled = 10;

// Track 0 never moves, track 1 always; track 2 moves, stands in frames 3 to 6, and moves again.
Sequence stop_and_go() {
  Sequence sequence = test::straight_line(kLabelled);
  sequence.camera.fx = sequence.camera.fy = 400.0;  // as the reader wants it
  sequence.landmarks[2].label = Label::kMoving;
  double z = 5.0;
  for (int i = 0; i < kLabelled; ++i) {
    const double v = i >= 3 && i <= 6 ? 0.0 : 1.0;
    sequence.landmarks[2].by_frame[i] = {Eigen::Vector3d(1, 0, z), {0, 0, v}};
    z += v;
  }
  return sequence;
}

void measure(Sequence& sequence, int track, int first, int last) {
  for (int i = first; i <= last; ++i) {
    sequence.frames[static_cast<size_t>(i)].observations.push_back({track, {0, 0}});
  }
}

TEST(LabelTruth, IsTheMotionWhenLastMeasured) {
  Sequence sequence = stop_and_go();
  for (const int track : {0, 1, 2}) measure(sequence, track, 0, 5);
  auto truth = labels_when_last_measured(sequence, kLabelled);
  EXPECT_EQ(truth,
            (std::map<int, Label>{{0, Label::kStatic}, {1, Label::kMoving}, {2, Label::kStatic}}));
  EXPECT_EQ(labels_when_last_measured(sequence, 2).at(2), Label::kMoving);  // a run that ended
  measure(sequence, 2, 7, 8);
  EXPECT_EQ(labels_when_last_measured(sequence, kLabelled).at(2), Label::kMoving);
}

TEST(LabelTruth, IsTheClassWhereNothingElseIsKnown) {
  Sequence sequence = stop_and_go();
  EXPECT_EQ(labels_when_last_measured(sequence, kLabelled).at(2), Label::kMoving);  // not measured
  measure(sequence, 2, 5, 5);
  sequence.landmarks[2].by_frame.erase(5);
  EXPECT_EQ(labels_when_last_measured(sequence, kLabelled).at(2), Label::kMoving);
}

// A made-up run: who says `static` of the object that stands is right, who says `moving` is wrong;
// and the same when the run is read back.
TEST(LabelTruth, JudgesARunAndAStoredOne) {
  Sequence sequence = stop_and_go();
  for (const int track : {0, 1, 2}) measure(sequence, track, 0, 6);
  const auto expect = [](const RunMetrics& metrics, Label said) {
    const ClassCounts& statics = metrics.classification.statics;
    EXPECT_EQ(statics.right, said == Label::kStatic ? 2 : 1);
    EXPECT_EQ(statics.wrong, said == Label::kMoving ? 1 : 0);
    EXPECT_EQ(statics.undecided, said == Label::kUnknown ? 1 : 0);
    EXPECT_EQ(metrics.classification.movings.right, 1);
  };
  const test::TemporaryFolder folder;
  const std::string stored = (folder.path() / "sequence").string();
  write_native(sequence, stored);
  for (const Label said : {Label::kStatic, Label::kMoving, Label::kUnknown}) {
    FakeEstimator estimator([&](const Frame& f) {
      test::Belief belief = test::true_belief(sequence, f);
      belief.landmarks = {landmark(0, Label::kStatic, 1, f.index, 1, f.index),
                          landmark(1, Label::kMoving, 1, f.index, 1, f.index),
                          landmark(2, said, 1, f.index, 1, f.index)};
      return belief;
    });
    const RunResult run = drive(sequence, estimator);
    const RunMetrics metrics = compute_metrics(sequence, run, 0.95);
    expect(metrics, said);
    for (const LandmarkSample& s : run.samples) {
      if (s.track != 2) continue;
      EXPECT_EQ(s.label, said);
      EXPECT_EQ(s.truth, Label::kMoving);
      EXPECT_EQ(s.motion, s.frame >= 3 && s.frame <= 6 ? Label::kStatic : Label::kMoving);
    }
    const std::filesystem::path own = folder.path() / std::string(to_string(said));
    write_run(own, {"", "ekf", stored, "", "", 1, {}}, run, metrics);
    expect(Judge({})(own, std::nullopt).metrics, said);
  }
}

}  // namespace
}  // namespace slammot
