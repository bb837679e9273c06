// The run folder: what is written is read back, to the bit, and gives the same metrics.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "eval/output/metrics_json.h"
#include "eval/output/run_reader.h"
#include "eval/output/run_writer.h"
#include "eval/run/run.h"
#include "tests/eval/fixture.h"

namespace slammot {
namespace {

using test::FakeEstimator;
using test::landmark;

// Numbers that no short decimal text holds.
test::Belief awkward_belief(const Sequence& sequence, const Frame& frame) {
  test::Belief belief = test::true_belief(sequence, frame);
  const double third = (frame.index + 1) / 3.0;
  belief.camera.state.position += third * Eigen::Vector3d(0.1, -0.2, 1e-17);
  belief.camera.state.orientation = exp_so3(Eigen::Vector3d(0.1 * third, 0.2, 0.3));
  belief.camera.covariance += Matrix12d::Constant(0.01 * third);
  belief.report.accepted = 3;
  belief.report.rejected = 1;
  belief.report.nis_sum = third;
  belief.report.state_size = 12 + 6 * frame.index;
  const bool decided = frame.index > 0;
  belief.landmarks = {landmark(0, Label::kUnknown, 0, frame.index, std::nullopt, frame.index + 1),
                      landmark(1, decided ? Label::kMoving : Label::kUnknown, 0, frame.index,
                               decided ? std::optional(1) : std::nullopt, frame.index + 1)};
  belief.landmarks[1].position = Eigen::Vector3d(0.1, 0.2, 5.0 + third);
  belief.landmarks[1].position_covariance = third * Eigen::Matrix3d::Identity();
  belief.landmarks[1].velocity = Eigen::Vector3d(0, 0, third);
  belief.landmarks[1].velocity_covariance = third * Eigen::Matrix3d::Identity();
  return belief;
}

// A run in a folder.
class RunFolder : public testing::Test {
 protected:
  void drive_over(int frames, const DriveOptions& options = {}) {
    sequence_ = test::straight_line(frames);
    FakeEstimator estimator([&](const Frame& f) { return awkward_belief(sequence_, f); });
    run_ = drive(sequence_, estimator, options);
  }
  void write(const Configuration& configuration = {}) {
    description_.configuration = configuration;
    write_run(path(), description_, run_, compute_metrics(sequence_, run_, 0.95));
  }
  std::filesystem::path path() const { return folder_.path(); }
  std::string text(const char* name) const { return test::read_text(path() / name); }

  const test::TemporaryFolder folder_;
  Sequence sequence_;
  RunResult run_;
  RunDescription description_{"slammot run 'a b'", "ekf", "/data/line", "line", "0123", 7, {}};
};

TEST_F(RunFolder, ReadsBackToTheSameMetrics) {
  drive_over(5);
  run_.smoothed = run_.filtered;
  run_.smoothing_ms = 1.25;
  run_.totals.lasting_sums = 3;
  run_.totals.lasting_nis = 7.5;
  Configuration configuration;
  configuration.model.gate = {0.9, 1.0};
  write(configuration);
  const StoredRun stored = read_run(path());
  EXPECT_EQ(stored.estimator, "ekf");
  EXPECT_EQ(stored.sequence, "/data/line");
  EXPECT_EQ(stored.gate_probability, 0.9);
  const RunMetrics metrics = compute_metrics(sequence_, run_, 0.9);
  EXPECT_EQ(stored.run.totals.lasting_sums, 3);
  EXPECT_EQ(stored.run.totals.lasting_nis, 7.5);
  const RunMetrics again = compute_metrics(sequence_, stored.run, stored.gate_probability);
  // Reading normalises the quaternion, which may change its last bit.
  EXPECT_NEAR(again.filtered.consistency.value->pose.mean,
              metrics.filtered.consistency.value->pose.mean, 1e-12);
  EXPECT_EQ(again.filtered.accuracy.value->position_rmse,
            metrics.filtered.accuracy.value->position_rmse);
  const auto before = metrics_json(metrics), after = metrics_json(again);
  for (const char* block :
       {"landmark_errors", "landmark_nees", "classification", "coverage", "runtime", "diverged"}) {
    EXPECT_EQ(before[block].dump(), after[block].dump()) << block;  // null equals null
  }
  EXPECT_NEAR(again.nis.mean, metrics.nis.mean, 1e-15);
}

TEST_F(RunFolder, HasTheShapeInTheLastScale) {
  drive_over(5);
  run_.last_scale = run_.filtered;
  for (CameraEstimate& camera : run_.last_scale) camera.state.position *= 1.0 / 3.0;
  write();
  const auto read = read_run(path()).run.last_scale;
  ASSERT_EQ(read.size(), 5u);
  EXPECT_EQ(read[3].state.position, run_.last_scale[3].state.position);
  EXPECT_TRUE(read[3].covariance.array().isNaN().all());
  EXPECT_THAT(text("metrics.json"), testing::HasSubstr("\"last_scale\""));
  run_.last_scale.clear();  // of a run that knows the scale, in the same folder
  write();
  EXPECT_TRUE(read_run(path()).run.last_scale.empty());
  EXPECT_FALSE(std::filesystem::exists(path() / "trajectory_last_scale.tum"));
  EXPECT_THAT(text("metrics.json"), testing::Not(testing::HasSubstr("last_scale")));
}

TEST_F(RunFolder, RunYamlReproducesTheConfiguration) {
  drive_over(2);
  Configuration configuration;
  for (const char* text :
       {"landmark=scaled_velocity", "prior.inverse_depth=0.1", "window.frames=17",
        "classifier=odds", "frames.first=1", "preset=thesis"}) {
    assign(configuration, parse_assignment(text));
  }
  const Configuration used = effective_configuration(sequence_, configuration, "delayed");
  write(used);
  Configuration again;
  load_configuration(again, path() / "run.yaml");
  EXPECT_EQ(key_values(again), key_values(used));
}

TEST_F(RunFolder, SaysWhatMadeIt) {
  drive_over(2);
  state_commit("0123456789ab", true);
  description_.made_by = provenance(3);
  state_commit("unknown", true);
  write();
  for (const char* part :
       {"version: ", "command: slammot run 'a b'", "sha256: ", "seed: 7", "commit: 0123456789ab",
        "modified: true", "compiler: ", "cpu: ", "cores: ", "jobs: 3", "date: 20"}) {
    EXPECT_THAT(text("run.yaml"), testing::HasSubstr(part));
  }
  EXPECT_EQ(Json::parse(text("metrics.json"))["provenance"], json_of(description_.made_by));
}

TEST_F(RunFolder, UndefinedIsNanInCsvAndNeverZero) {
  DriveOptions options;
  options.landmarks_every_frame = true;
  drive_over(2, options);
  write();
  const std::string landmarks = text("landmarks.csv");
  EXPECT_EQ(std::ranges::count(landmarks, '\n'), 2 + 4);  // heads, 2 landmarks x 2 frames
  EXPECT_THAT(landmarks, testing::HasSubstr("0,1,unknown,nan,nan,nan,nan"));
  const StoredRun stored = read_run(path());
  ASSERT_EQ(stored.run.landmarks.size(), 2u);
  EXPECT_EQ(stored.run.landmarks[1].frame, 1);
}

TEST_F(RunFolder, PredictionsAreReadBackAndReplaced) {
  drive_over(2);
  EXPECT_TRUE(run_.predictions.empty());
  const Eigen::Matrix2d S{{1.0 / 3.0, -0.1}, {-0.1, 7e5 / 9.0}};
  run_.predictions = {{0, {4, {1.0 / 3.0, -2e-17}, S, Measured::kAccepted}},
                      {1, {0, {639.1, 2.0}, 3.0 * S, Measured::kNot}},
                      {1, {4, {0.1, 0.2}, S, Measured::kRejected}}};
  write();
  EXPECT_THAT(text("predictions.csv"), testing::HasSubstr("s_vv,measured\n"));
  run_.predictions.push_back({1, {4, {0.3, 0.2}, S, Measured::kAccepted, 1}});  // of a rig
  const auto written = [&] {
    write();
    return read_prediction_rows(path() / "predictions.csv");
  };
  const std::vector<PredictionRecord> again = written();
  ASSERT_EQ(again.size(), run_.predictions.size());
  for (size_t i = 0; i < again.size(); ++i) {
    const Prediction &a = run_.predictions[i].prediction, &b = again[i].prediction;
    EXPECT_EQ(run_.predictions[i].frame, again[i].frame);
    EXPECT_EQ(a.track, b.track);
    EXPECT_EQ(a.pixel, b.pixel);
    EXPECT_EQ(a.S, b.S);
    EXPECT_EQ(a.measured, b.measured);
    EXPECT_EQ(a.camera, b.camera);
  }
  run_.predictions.clear();
  EXPECT_TRUE(written().empty());
  EXPECT_FALSE(std::filesystem::exists(path() / "predictions.csv"));
}

TEST_F(RunFolder, BadPredictionsAreNamed) {
  const auto reason = [&](const std::string& rows) -> std::string {
    test::write_text(path() / "predictions.csv",
                     "frame,track,u,v,s_uu,s_uv,s_vv,measured\n0,3,1,2,4,1,1,-\n" + rows);
    try {
      read_prediction_rows(path() / "predictions.csv");
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(reason(""), "");
  for (const auto& [row, what] : std::vector<std::pair<std::string, std::string>>{
           {"0,4,1,2,4,2,1,-", "no covariance"},
           {"0,4,1,2,-4,0,-1,-", "no covariance"},
           {"0,4,1,2,nan,0,1,-", "'nan' is not a finite number"},
           {"0,4,1,2,4,1,1,maybe", "'maybe' is neither accepted, rejected nor -"},
           {"0,4,1e300,2,4,1,1,-", "not plausible"},
           {"0,3,1,2,4,1,1,-", "not by frame, track and camera"},
           {"0,4,1,2,4,1,1", "expected 8 fields, found 7"}}) {
    EXPECT_THAT(reason(row + "\n"), testing::ContainsRegex("predictions.csv:3: .*" + what));
  }
}

TEST_F(RunFolder, ADivergedRunStaysDiverged) {
  sequence_ = test::straight_line(4);
  FakeEstimator estimator([&](const Frame& f) {
    if (f.index == 2) throw Diverged("gone");
    return awkward_belief(sequence_, f);
  });
  run_ = drive(sequence_, estimator);
  write();
  const StoredRun stored = read_run(path());
  ASSERT_TRUE(stored.run.diverged);
  EXPECT_EQ(stored.run.diverged->reason, "gone");
  EXPECT_EQ(stored.run.frames_offered, 4);
}

TEST_F(RunFolder, ATrajectoryIsEnough) {
  test::write_text(path() / "trajectory.tum",
                   "# made elsewhere\n0 0 0 0 0 0 0 1\n1.0  1 1 0 0 0 0 1\r\n");
  const RunMetrics metrics = compute_metrics(test::straight_line(3), read_run(path()).run, 0.95);
  EXPECT_NEAR(metrics.filtered.accuracy.value->position_rmse, std::sqrt(0.5), 1e-12);
  EXPECT_FALSE(metrics.filtered.consistency.value);
  EXPECT_EQ(metrics.filtered.consistency.reason, "not every pose has a covariance");
}

}  // namespace
}  // namespace slammot
