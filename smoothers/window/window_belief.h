// The sliding window's belief; see window.h for what it is. The functions stand in the order of a
// frame, here, in window.cpp and in the EKF's files alike.
//
// Variables: camera position and motion for each frame; for each landmark y, and while it is free w
// and the noises of its chain (landmark_chain.h). The position of the camera in the frame in which
// a landmark was initialised is its anchor, and stays when that frame has left.
#pragma once

#include "estimation/belief.h"
#include "smoothers/solver/optimise.h"
#include "smoothers/window/free_landmarks.h"
#include "smoothers/window/track_history.h"
#include "smoothers/window/window.h"

namespace slammot {

// Where Jacobians are to be taken, with linearisation `ideal`; else none. Throws
// std::invalid_argument where there is no truth.
std::shared_ptr<const Truth> truth_of(const Setup& setup, const WindowOptions& options);

class Window final : public Belief {
 public:
  // `histories`: told what happens to landmarks, or null.
  // Throws std::invalid_argument for an unknown landmark model, linearisation or loss.
  Window(const Setup& setup, const ModelOptions& models, const WindowOptions& options,
         TrackHistories* histories = nullptr);
  Window(const Window&) = delete;  // its parts refer to its graph
  Window& operator=(const Window&) = delete;

  void predict(const Frame& frame, double dt, StageListener& stages) override;
  void add_known(const KnownLandmark& known) override;
  void innovations(std::span<const Observation> measured,
                   std::vector<PixelInnovation>& result) override;
  void update(const TrackRecords& records, std::span<const Observation> accepted) override;
  void leave_one_out(std::vector<LeaveOneOut>& result) override;
  void inverse_depths(std::span<const int> tracks, std::vector<SeenDepth>& result) override;
  void motions(std::span<const int> tracks, std::vector<MotionBelief>& result) override;
  void collapse(std::span<const int> tracks) override;
  void free(int track, const LandmarkPrior& prior) override;
  void remove(std::span<const int> tracks, const TrackRecords& records) override;
  bool add(const Observation& z, const LandmarkPrior& prior, bool is_free) override;

  int state_size() const override;
  CameraEstimate camera() const override { return camera_; }
  void points(std::vector<LandmarkPoint>& result) override;
  std::vector<LandmarkBelief> landmarks(std::span<const int> tracks) const override;
  std::vector<CameraEstimate> smoothed() override;

  // Every camera so far, oldest first: as it left, or as it is in the window.
  std::vector<CameraState> all_cameras() const;
  // Tells the histories of the landmarks that are still there.
  void end_histories(const TrackRecords& records) const;

 private:
  // window_marginalise.cpp: what leaves the window, what is deactivated and what returns.
  void marginalise_oldest();
  std::set<VariableId> find_inactive(const WindowFrame& oldest, std::set<VariableId>& leaving);
  void release_anchors(const std::set<VariableId>& active, const std::set<VariableId>& inactive,
                       std::set<VariableId>& leaving, std::set<VariableId>& deactivated);
  void reactivate_measured(const Frame& frame);

  WindowLandmark& insert(int track);
  void add_measurements(std::span<const Observation> accepted);
  double refresh_noises();
  void estimate_camera();
  Eigen::MatrixXd before_last_step(const Factor& factor) const;
  LandmarkVector at_rest(const WindowLandmark& landmark) const;  // (y, 0) of a static one
  void end_history(const WindowLandmark& landmark, const TrackRecord& record) const;

  Setup setup_;
  WindowOptions options_;
  bool condition_;  // on collapse, w = 0 is used
  const LandmarkFunctions& functions_;
  std::unique_ptr<ceres::LossFunction> loss_;
  Graph graph_;
  CameraWindow cameras_;
  TruthLinearisation truth_;
  FreeLandmarks free_landmarks_;
  std::optional<VariableId> scene_;          // mean inverse depth at first sight, when it is learnt
  std::map<int, WindowLandmark> landmarks_;  // by track
  std::vector<WindowLandmark> pruned_;       // with measurements in the window
  std::set<VariableId> left_anchors_;  // camera positions whose frame has left, inactive ones too
  CameraEstimate camera_;
  std::optional<OptimiseResult> optimum_;  // of the newest update or collapse
  TrackHistories* histories_;

  // Of the frame in hand.
  struct Used {
    int track;
    FactorId factor;
  };
  std::vector<Used> used_;
};

}  // namespace slammot
