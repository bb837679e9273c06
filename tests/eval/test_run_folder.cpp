// The run folder: what is written is read back, to the bit, and gives the same metrics.
#include <gtest/gtest.h>

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

RunDescription description_of(const Sequence& sequence, const Configuration& configuration) {
  return {"slammot run 'a b'", "ekf", "/data/line", sequence.name,
          sequence.sha256,     7,     configuration};
}

nlohmann::ordered_json without_frames(nlohmann::ordered_json json) {
  for (auto& row : json["filtered"]["nees"]["series"]) row[0] = 0;
  return json;
}

TEST(RunFolder, ReadsBackToTheSameMetrics) {
  const Sequence sequence = test::straight_line(5);
  FakeEstimator estimator([&](const Frame& f) { return awkward_belief(sequence, f); });
  RunResult run = drive(sequence, estimator);
  run.smoothed = run.filtered;
  run.smoothing_ms = 1.25;
  const RunMetrics metrics = compute_metrics(sequence, run, 0.9);
  Configuration configuration;
  configuration.model.gate = {0.9, 1.0};
  const test::TemporaryFolder folder;
  write_run(folder.path(), description_of(sequence, configuration), run, metrics);

  const StoredRun stored = read_run(folder.path());
  EXPECT_EQ(stored.estimator, "ekf");
  EXPECT_EQ(stored.sequence, "/data/line");
  EXPECT_EQ(stored.gate_probability, 0.9);
  ASSERT_EQ(stored.run.filtered.size(), run.filtered.size());
  for (size_t i = 0; i < run.filtered.size(); ++i) {
    const CameraEstimate& a = run.filtered[i];
    const CameraEstimate& b = stored.run.filtered[i];
    EXPECT_EQ(a.state.position, b.state.position);
    EXPECT_LT((a.state.orientation.coeffs() - b.state.orientation.coeffs()).norm(), 1e-15);
    EXPECT_EQ((a.covariance.topLeftCorner<6, 6>()), (b.covariance.topLeftCorner<6, 6>()));
  }
  const RunMetrics again = compute_metrics(sequence, stored.run, stored.gate_probability);
  // Reading normalises the quaternion, which may change its last bit.
  EXPECT_NEAR(again.filtered.consistency.value->pose.mean,
              metrics.filtered.consistency.value->pose.mean, 1e-12);
  EXPECT_EQ(again.filtered.accuracy.value->position_rmse,
            metrics.filtered.accuracy.value->position_rmse);
  auto before = without_frames(metrics_json(metrics));
  auto after = without_frames(metrics_json(again));
  for (const char* block :
       {"landmark_errors", "landmark_nees", "classification", "coverage", "runtime", "diverged"}) {
    EXPECT_EQ(before[block].dump(), after[block].dump()) << block;  // null equals null
  }
  EXPECT_NEAR(again.nis.mean, metrics.nis.mean, 1e-15);
}

TEST(RunFolder, RunYamlReproducesTheConfiguration) {
  const Sequence sequence = test::straight_line(2);
  FakeEstimator estimator([&](const Frame& f) { return awkward_belief(sequence, f); });
  const RunResult run = drive(sequence, estimator);
  Configuration configuration;
  for (const char* text :
       {"landmark=scaled_velocity", "prior.inverse_depth=0.1", "window.frames=17",
        "classifier=odds", "frames.first=1", "preset=thesis"}) {
    assign(configuration, parse_assignment(text));
  }
  const Configuration used = effective_configuration(sequence, configuration, "delayed");
  const test::TemporaryFolder folder;
  write_run(folder.path(), description_of(sequence, used), run,
            compute_metrics(sequence, run, 0.95));
  Configuration again;
  load_configuration(again, folder.path() / "run.yaml");
  EXPECT_EQ(key_values(again), key_values(used));
  const std::string text = test::read_text(folder.path() / "run.yaml");
  for (const char* part : {"version: ", "command: slammot run 'a b'", "sha256: ", "seed: 7"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part;
  }
}

TEST(RunFolder, SaysWhatMadeIt) {
  const Sequence sequence = test::straight_line(2);
  FakeEstimator estimator([&](const Frame& f) { return awkward_belief(sequence, f); });
  const RunResult run = drive(sequence, estimator);
  const test::TemporaryFolder folder;
  RunDescription description = description_of(sequence, {});
  state_commit("0123456789ab", true);
  description.made_by = provenance(3);
  state_commit("unknown", true);
  write_run(folder.path(), description, run, compute_metrics(sequence, run, 0.95));
  const std::string text = test::read_text(folder.path() / "run.yaml");
  for (const char* part : {"commit: 0123456789ab", "modified: true",
                           "compiler: ", "cpu: ", "cores: ", "jobs: 3", "date: 20"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part;
  }
  const Json metrics = Json::parse(test::read_text(folder.path() / "metrics.json"));
  EXPECT_EQ(metrics["provenance"], json_of(description.made_by));
}

TEST(RunFolder, UndefinedIsNanInCsvAndNeverZero) {
  const Sequence sequence = test::straight_line(2);
  FakeEstimator estimator([&](const Frame& f) { return awkward_belief(sequence, f); });
  DriveOptions options;
  options.landmarks_every_frame = true;
  const RunResult run = drive(sequence, estimator, options);
  const test::TemporaryFolder folder;
  write_run(folder.path(), description_of(sequence, {}), run, compute_metrics(sequence, run, 0.95));
  const std::string text = test::read_text(folder.path() / "landmarks.csv");
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 2 + 4);  // heads, 2 landmarks x 2 frames
  EXPECT_NE(text.find("0,1,unknown,nan,nan,nan,nan"), std::string::npos);
  const StoredRun stored = read_run(folder.path());
  ASSERT_EQ(stored.run.landmarks.size(), 2u);
  EXPECT_EQ(stored.run.landmarks[1].frame, 1);
}

TEST(RunFolder, PredictionsAreReadBackAndReplaced) {
  const Sequence sequence = test::straight_line(2);
  FakeEstimator estimator([&](const Frame& f) { return awkward_belief(sequence, f); });
  RunResult run = drive(sequence, estimator);
  EXPECT_TRUE(run.predictions.empty());
  const Eigen::Matrix2d S{{1.0 / 3.0, -0.1}, {-0.1, 7e5 / 9.0}};
  run.predictions = {{0, {4, {1.0 / 3.0, -2e-17}, S, Measured::kAccepted}},
                     {1, {0, {639.1, 2.0}, 3.0 * S, Measured::kNot}},
                     {1, {4, {0.1, 0.2}, S, Measured::kRejected}}};
  const test::TemporaryFolder folder;
  const auto write = [&] {
    write_run(folder.path(), description_of(sequence, {}), run,
              compute_metrics(sequence, run, 0.95));
    return read_prediction_rows(folder.path() / "predictions.csv");
  };
  const std::vector<PredictionRecord> again = write();
  ASSERT_EQ(again.size(), run.predictions.size());
  for (size_t i = 0; i < again.size(); ++i) {
    const Prediction &a = run.predictions[i].prediction, &b = again[i].prediction;
    EXPECT_EQ(run.predictions[i].frame, again[i].frame);
    EXPECT_EQ(a.track, b.track);
    EXPECT_EQ(a.pixel, b.pixel);
    EXPECT_EQ(a.S, b.S);
    EXPECT_EQ(a.measured, b.measured);
  }
  run.predictions.clear();
  EXPECT_TRUE(write().empty());
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "predictions.csv"));
}

TEST(RunFolder, BadPredictionsAreNamed) {
  const auto reason = [](const std::string& rows) {
    const test::TemporaryFolder folder;
    const auto file = folder.path() / "predictions.csv";
    test::write_text(file, "frame,track,u,v,s_uu,s_uv,s_vv,measured\n" + rows);
    try {
      read_prediction_rows(file);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const std::string good = "0,3,1,2,4,1,1,-\n";
  EXPECT_EQ(reason(good), "");
  for (const auto& [row, what] : std::vector<std::pair<std::string, std::string>>{
           {"0,4,1,2,4,2,1,-", "no covariance"},
           {"0,4,1,2,-4,0,-1,-", "no covariance"},
           {"0,4,1,2,nan,0,1,-", "'nan' is not a finite number"},
           {"0,4,1,2,4,1,1,maybe", "'maybe' is neither accepted, rejected nor -"},
           {"0,4,1e300,2,4,1,1,-", "not plausible"},
           {"0,3,1,2,4,1,1,-", "not by frame and track"},
           {"0,4,1,2,4,1,1", "expected 8 fields, found 7"}}) {
    const std::string said = reason(good + row + "\n");
    EXPECT_NE(said.find("predictions.csv:3: "), std::string::npos) << said;
    EXPECT_NE(said.find(what), std::string::npos) << said;
  }
}

TEST(RunFolder, ADivergedRunStaysDiverged) {
  const Sequence sequence = test::straight_line(4);
  FakeEstimator estimator([&](const Frame& f) {
    if (f.index == 2) throw Diverged("gone");
    return awkward_belief(sequence, f);
  });
  const RunResult run = drive(sequence, estimator);
  const test::TemporaryFolder folder;
  write_run(folder.path(), description_of(sequence, {}), run, compute_metrics(sequence, run, 0.95));
  const StoredRun stored = read_run(folder.path());
  ASSERT_TRUE(stored.run.diverged);
  EXPECT_EQ(stored.run.diverged->reason, "gone");
  EXPECT_EQ(stored.run.frames_offered, 4);
}

TEST(RunFolder, ATrajectoryIsEnough) {
  const test::TemporaryFolder folder;
  test::write_text(folder.path() / "trajectory.tum",
                   "# made elsewhere\n0 0 0 0 0 0 0 1\n1.0  1 1 0 0 0 0 1\r\n");
  const StoredRun stored = read_run(folder.path());
  const RunMetrics metrics = compute_metrics(test::straight_line(3), stored.run, 0.95);
  EXPECT_NEAR(metrics.filtered.accuracy.value->position_rmse, std::sqrt(0.5), 1e-12);
  EXPECT_FALSE(metrics.filtered.consistency.value);
  EXPECT_EQ(metrics.filtered.consistency.reason, "not every pose has a covariance");
}

TEST(RunFolder, BadLinesAreNamed) {
  const auto reason = [](const std::string& trajectory, const std::string& covariance) {
    const test::TemporaryFolder folder;
    test::write_text(folder.path() / "trajectory.tum", trajectory);
    if (!covariance.empty()) {
      test::write_text(folder.path() / "pose_covariance.csv", covariance);
    }
    try {
      read_run(folder.path());
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const std::string good = "0 0 0 0 0 0 0 1\n";
  const auto has = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  EXPECT_TRUE(has(reason("0 0 0 0 0 0 1\n", ""), "trajectory.tum:1: expected 8 fields, found 7"));
  EXPECT_TRUE(has(reason(good + "1 0 x 0 0 0 0 1\n", ""), "trajectory.tum:2: 'x' is not a number"));
  EXPECT_TRUE(has(reason(good + "1 0 nan 0 0 0 0 1\n", ""), ":2: 'nan' is not a finite number"));
  EXPECT_TRUE(has(reason(good + good, ""), "trajectory.tum:2: timestamp 0 does not follow 0"));
  EXPECT_TRUE(has(reason("0 0 0 0 0 0 0 2\n", ""), ":1: the quaternion"));
  EXPECT_TRUE(has(reason("# nothing\n", ""), "holds no pose"));
  EXPECT_TRUE(
      has(reason(good, "timestamp\n0,1\n"), "pose_covariance.csv:2: expected 22 fields, found 2"));
}

}  // namespace
}  // namespace slammot
