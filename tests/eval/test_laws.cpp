// Laws of metrics and of readers on generated input, with RapidCheck: what fails is shrunk and
// printed with the configuration that repeats it (RC_PARAMS).
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "eval/metrics/accuracy.h"
#include "eval/metrics/alignment.h"
#include "eval/metrics/nees.h"
#include "eval/output/run_reader.h"
#include "eval/output/run_writer.h"
#include "models/so3.h"
#include "tests/eval/fixture.h"

namespace slammot {
namespace {

double number(double largest) { return *rc::gen::inRange(-1000000, 1000001) * 1e-6 * largest; }

Eigen::Vector3d vector(double largest) {
  const double x = number(largest), y = number(largest), z = number(largest);
  return {x, y, z};
}

std::vector<Eigen::Vector3d> points(int count) {
  std::vector<Eigen::Vector3d> result;
  for (int i = 0; i < count; ++i) result.push_back(vector(10.0));
  return result;
}

double ate(const std::vector<Eigen::Vector3d>& estimate, const std::vector<Eigen::Vector3d>& truth,
           AlignmentGroup group) {
  return absolute_trajectory_error(estimate, truth, align(estimate, truth, group));
}

Similarity similarity(double scale) {
  Similarity s;
  s.scale = scale;
  s.rotation = exp_so3(vector(3.0)).toRotationMatrix();
  s.translation = vector(100.0);
  return s;
}

std::vector<Eigen::Vector3d> moved(const Similarity& s, std::vector<Eigen::Vector3d> points) {
  for (Eigen::Vector3d& point : points) point = s * point;
  return points;
}

RC_GTEST_PROP(AteLaws, IsInvariantUnderWhatIsAligned, ()) {
  const int count = *rc::gen::inRange(4, 30);
  const auto truth = points(count), estimate = points(count);
  const double sim3 = ate(estimate, truth, AlignmentGroup::kSim3);
  const double se3 = ate(estimate, truth, AlignmentGroup::kSE3);
  const double scale = 0.1 + std::abs(number(5.0));
  RC_ASSERT(std::abs(ate(moved(similarity(scale), estimate), truth, AlignmentGroup::kSim3) - sim3) <
            1e-8);
  RC_ASSERT(std::abs(ate(moved(similarity(1.0), estimate), truth, AlignmentGroup::kSE3) - se3) <
            1e-8);
  RC_ASSERT(sim3 <= se3 + 1e-9);  // more freedom aligns no worse
}

RC_GTEST_PROP(AteLaws, IsZeroOfASimilarCopy, ()) {
  const auto truth = points(*rc::gen::inRange(4, 30));
  const Similarity s = similarity(0.1 + std::abs(number(5.0)));
  RC_ASSERT(ate(moved(s, truth), truth, AlignmentGroup::kSim3) < 1e-8);
}

// NEES does not depend on the coordinates in which error and covariance are written.
RC_GTEST_PROP(NeesLaws, IsInvariantUnderALinearMap, ()) {
  const auto matrix = [] {
    Eigen::Matrix3d m;
    for (int i = 0; i < 3; ++i) m.col(i) = vector(1.0);
    return Eigen::Matrix3d(m + 4.0 * Eigen::Matrix3d::Identity());  // diagonally dominant
  };
  const Eigen::Matrix3d root = matrix(), A = matrix();
  const Eigen::Matrix3d P = root * root.transpose();
  const Eigen::Vector3d e = vector(2.0);
  const double before = nees(e, P), after = nees(A * e, A * P * A.transpose());
  RC_ASSERT(std::abs(after - before) <= 1e-9 * (1.0 + before));
}

RunResult generated_run(const Sequence& sequence) {
  RunResult run;
  run.frames_offered = static_cast<int>(sequence.frames.size());
  for (const Frame& frame : sequence.frames) {
    CameraEstimate camera;
    camera.timestamp = frame.timestamp;
    camera.state.position = vector(1e3);
    camera.state.orientation = exp_so3(vector(2.0));
    for (int row = 0; row < 6; ++row) {
      for (int col = row; col < 6; ++col) {
        camera.covariance(row, col) = camera.covariance(col, row) = number(10.0);
      }
    }
    run.frames.push_back(frame.index);
    run.filtered.push_back(camera);
    run.timing.push_back({frame.index, "total", std::abs(number(50.0)), *rc::gen::inRange(0, 999)});
  }
  const int landmarks = *rc::gen::inRange(0, 6);
  for (int track = 0; track < landmarks; ++track) {
    LandmarkRecord record{*rc::gen::inRange(0, 5), {}};
    record.estimate.track = track;
    record.estimate.label = *rc::gen::element(Label::kUnknown, Label::kStatic, Label::kMoving);
    record.estimate.position = vector(1e5);
    const bool moves = record.estimate.label == Label::kMoving;
    if (moves) record.estimate.velocity = vector(3.0);  // else undefined
    run.landmarks.push_back(record);
    run.classification.push_back({track, std::nullopt, record.estimate.label,
                                  moves ? std::optional(*rc::gen::inRange(0, 9)) : std::nullopt,
                                  *rc::gen::inRange(0, 99)});
  }
  return run;
}

std::map<std::string, std::string> files_of(const std::filesystem::path& folder) {
  std::map<std::string, std::string> files;
  for (const char* name :
       {"pose_covariance.csv", "landmarks.csv", "classification.csv", "timing.csv", "run.yaml"}) {
    files[name] = test::read_text(folder / name);
  }
  return files;
}

// What is read back and written again is the same text: nothing is lost, and nothing is made up.
// Of the trajectory this holds but for the last bit of a quaternion, which reading normalises.
RC_GTEST_PROP(RunFolderLaws, ReadingIsTheInverseOfWriting, ()) {
  const Sequence sequence = test::straight_line(5);
  const RunResult run = generated_run(sequence);
  const test::TemporaryFolder first, second;
  RunDescription description;
  description.command = "c";
  description.estimator = "e";
  description.sequence = "/s";
  description.sequence_name = sequence.name;
  description.sequence_sha256 = "0";
  description.seed = 3;
  write_run(first.path(), description, run, compute_metrics(sequence, run, 0.9));
  const StoredRun stored = read_run(first.path());
  write_run(second.path(), description, stored.run, compute_metrics(sequence, stored.run, 0.9));
  RC_ASSERT(files_of(first.path()) == files_of(second.path()));
  for (size_t i = 0; i < run.filtered.size(); ++i) {
    RC_ASSERT(stored.run.filtered[i].state.position == run.filtered[i].state.position);
    RC_ASSERT((stored.run.filtered[i].state.orientation.coeffs() -
               run.filtered[i].state.orientation.coeffs())
                  .norm() < 1e-15);
  }
}

}  // namespace
}  // namespace slammot
