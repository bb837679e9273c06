// An estimator and its row.
#pragma once

#include <slammot/eval/configuration/registry.h>

namespace slammot {

// Dead reckoning: the camera's motion model alone, no measurement is used.
class DeadReckoning final : public Estimator {
 public:
  explicit DeadReckoning(const Setup& setup) : noise_(setup.camera_noise) {
    camera_.state = setup.initial.state;
    camera_.covariance = setup.initial.sigmas().cwiseAbs2().asDiagonal();
  }

  FrameReport process(const Frame& frame, StageListener& stages) override {
    stages.begin("predict");
    if (started_) predict_to(frame.timestamp);
    started_ = true;
    camera_.timestamp = frame.timestamp;
    FrameReport report;
    report.state_size = kCameraDim;
    return report;
  }

  CameraEstimate camera() const override { return camera_; }
  std::vector<LandmarkEstimate> landmarks() const override { return {}; }

 private:
  void predict_to(double timestamp) {
    const double dt = timestamp - camera_.timestamp;
    if (!(dt > 0.0)) throw std::invalid_argument("the time of a frame must increase");
    const Matrix12d F = predict_jacobian(camera_.state, dt);
    camera_.covariance =
        F * camera_.covariance * F.transpose() + camera_noise(noise_, camera_.state, dt);
    camera_.state = predict(camera_.state, dt);
  }

  MotionNoise noise_;
  CameraEstimate camera_;
  bool started_ = false;
};

const EstimatorRow kDeadReckoning{
    "dead_reckoning",
    "the motion model alone",
    EstimatorKind::kFilter,
    false,
    [](Configuration&) {},
    [](const Setup& setup, const Configuration&) -> std::unique_ptr<Estimator> {
      return std::make_unique<DeadReckoning>(setup);
    },
    false};  // has no landmark model

}  // namespace slammot
