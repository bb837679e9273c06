// What the tests of eval/ share: a tiny true sequence, and an estimator that reports what it is
// told.
#pragma once

#include <functional>
#include <vector>

#include "datasets/sequence/sequence.h"
#include "estimation/estimator.h"
#include "eval/run/run.h"
#include "tests/temporary_folder.h"

namespace slammot::test {

// A camera at (0, 0, 0), (1, 0, 0), ... one second apart; track 0 static, track 1 moving along z.
inline Sequence straight_line(int frames) {
  Sequence sequence;
  sequence.name = "line";
  sequence.exact_truth = true;
  sequence.sha256 = "0123";
  for (int i = 0; i < frames; ++i) {
    Frame frame;
    frame.index = i;
    frame.timestamp = i;
    sequence.frames.push_back(frame);
    CameraState truth;
    truth.position.x() = i;
    sequence.truth.push_back(truth);
  }
  sequence.landmarks[0] = {Label::kStatic,
                           {{0, {Eigen::Vector3d(1, 2, 3), Eigen::Vector3d::Zero()}}}};
  sequence.landmarks[1].label = Label::kMoving;
  for (int i = 0; i < frames; ++i) {
    sequence.landmarks[1].by_frame[i] = {Eigen::Vector3d(0, 0, 5 + i), Eigen::Vector3d::UnitZ()};
  }
  return sequence;
}

inline LandmarkEstimate landmark(int track, Label label, int first, int last,
                                 std::optional<int> decision, int observations) {
  LandmarkEstimate estimate;
  estimate.track = track;
  estimate.label = label;
  estimate.first_frame = first;
  estimate.last_frame = last;
  estimate.decision_frame = decision;
  estimate.observations = observations;
  return estimate;
}

struct Belief {
  CameraEstimate camera;
  std::vector<LandmarkEstimate> landmarks;
  FrameReport report;
};

// Believes after each frame what a function says; the function may throw.
class FakeEstimator : public Estimator {
 public:
  explicit FakeEstimator(std::function<Belief(const Frame&)> say) : say_(std::move(say)) {}

  FrameReport process(const Frame& frame, StageListener& stages) override {
    stages.begin("predict");
    stages.begin("update");
    belief_ = say_(frame);
    belief_.camera.timestamp = frame.timestamp;
    return belief_.report;
  }
  CameraEstimate camera() const override { return belief_.camera; }
  std::vector<LandmarkEstimate> landmarks() const override { return belief_.landmarks; }

 private:
  std::function<Belief(const Frame&)> say_;
  Belief belief_;
};

// The true camera with a unit covariance.
inline Belief true_belief(const Sequence& sequence, const Frame& frame) {
  Belief belief;
  belief.camera.state = *sequence.truth[static_cast<size_t>(frame.index)];
  belief.camera.covariance.setIdentity();
  return belief;
}

// The run over a straight line of a camera that is where it is, but for what `change` does.
inline RunResult driven(
    const Sequence& sequence, const std::function<void(int, Belief&)>& change = [](int, auto&) {},
    const DriveOptions& options = {}) {
  FakeEstimator estimator([&](const Frame& f) {
    Belief belief = true_belief(sequence, f);
    change(f.index, belief);
    return belief;
  });
  return drive(sequence, estimator, options);
}

}  // namespace slammot::test
