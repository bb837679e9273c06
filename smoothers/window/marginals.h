// What gate, labels, births and reports ask of the window, read from the last factorisation.
//
// Between two updates nothing is factorised but where a label changes. What has entered since (a
// new camera, one step of each chain, a new landmark) is conditional on what the equations know.
#pragma once

#include <optional>
#include <span>

#include "estimation/belief.h"
#include "smoothers/solver/normal_equations.h"
#include "smoothers/window/window_landmark.h"

namespace slammot {

class Marginals {
 public:
  Marginals(const Graph& graph, const CameraWindow& cameras, const WindowLandmarks& landmarks,
            NormalEquations& equations)
      : graph_(graph), cameras_(cameras), landmarks_(landmarks), equations_(equations) {}

  void start();                                // after a solve: F = I, Q = 0
  void predict();                              // F and Q are those of the newest motion
  void widen(double factor) { Q_ *= factor; }  // whose noise has become so much larger

  // As Belief has them.
  void innovations(std::span<const Observation> measured, FrameInnovation& result);
  void predict_pixels(std::span<const int> tracks, std::vector<Prediction>& result);
  void leave_one_out(std::span<const int> tracks, std::vector<LeaveOneOut>& result);
  void inverse_depths(std::span<const int> tracks, std::vector<SeenDepth>& result);
  void motions(std::span<const int> tracks, std::vector<MotionBelief>& result);
  void constrained_motions(std::span<const int> tracks, RememberedMotions& result);
  std::vector<LandmarkBelief> landmarks(std::span<const int> tracks);
  std::optional<PoseEstimate> pose_before(int frames) const;

  // The newest camera of the last factorisation, in the coordinates of the estimate.
  CameraEstimate camera();

  // (y, 0) of a static one.
  LandmarkVector at_rest(const WindowLandmark& landmark) const;

 private:
  using CameraRows = Eigen::Matrix<double, 2, kCameraDim>;

  // A measurement's pixel as it is expected.
  struct Expected {
    int track = 0;
    LandmarkId landmark = 0;
    ObservedPixel h;
    Eigen::Vector2d nu;  // z - h(x) [px]
    // Of (camera, anchor, state) as they were factorised; of one known at first sight: (camera).
    BoundedMatrix<2, Eigen::Dynamic, 2, kMaxJoint> H;
  };

  void prepare(std::span<const int> tracks);
  JointMatrix joint(const WindowLandmark& landmark) const;
  LeaveOneOut leave_rig_out(const WindowLandmark& landmark) const;

  // expected_pixels.cpp
  std::optional<Expected> expect_pixel(const Observation& z) const;
  CameraRows rows_of_new(const GraphLandmark& l, const ObservedPixel& h) const;
  Eigen::Matrix3d J_of_known(const GraphLandmark& l) const;
  Eigen::Matrix2d shared(const WindowLandmark& landmark, const ObservedPixel& a,
                         const ObservedPixel& b) const;
  Eigen::Matrix2d shared_of_new(const GraphLandmark& l, const ObservedPixel& a,
                                const ObservedPixel& b) const;
  void fill_HPHt(GrowingMatrix& HPHt);
  void add_inactive(Eigen::Ref<Eigen::MatrixXd> HPHt) const;

  // constrained_motion.cpp
  void add_information(LandmarkId id, const Eigen::VectorXd& prior_gradient,
                       Eigen::Ref<Eigen::MatrixXd> of_core, MotionMatrix& information,
                       MotionVector& vector);

  void add_shared(std::size_t i, std::size_t k, RememberedMotions& result) const;

  const Graph& graph_;
  const CameraWindow& cameras_;
  const WindowLandmarks& landmarks_;
  NormalEquations& equations_;

  // The newest camera given the one that the factorisation knows as newest.
  Matrix12d F_ = Matrix12d::Identity(), Q_ = Matrix12d::Zero();

  // Of the frame in hand, kept for their memory.
  std::vector<Expected> expected_;
  std::vector<int> tracks_;
  std::vector<LandmarkId> ids_;
  GrowingMatrix core_columns_, motion_rows_, motion_columns_;
};

}  // namespace slammot
