// The sliding-window smoother on the thesis's models: the last N cameras, the landmarks they see,
// and a prior that keeps what has left the window.
//
// Per frame, in the order of the EKF: predict, gate, marginalise what leaves, optimise, read the
// marginals, classify, collapse, manage. With one frame and one iteration it is the EKF but for the
// devices of docs/frame.md: test_equivalence. Its parts: the cameras (camera_window.h), chains of
// what moves (window_landmark.h), what leaves (departures.h), and what is read from a factorisation
// (marginals.h).
#pragma once

#include <memory>

#include "estimation/options.h"
#include "smoothers/solver/optimise.h"
#include "smoothers/window/departures.h"
#include "smoothers/window/marginals.h"
#include "smoothers/window/window_options.h"

namespace slammot {

class Window final : public Belief {
 public:
  // `histories`: told what happens to landmarks, or null. Throws std::invalid_argument for an
  // unknown landmark model.
  Window(const Setup& setup, const ModelOptions& models, const WindowOptions& options,
         TrackHistories* histories = nullptr);
  Window(const Window&) = delete;  // its parts refer to its graph
  Window& operator=(const Window&) = delete;

  void predict(const Frame& frame, double dt, const MotionNoise& noise,
               const TrackRecords& records) override;
  void add_known(const KnownLandmark& known) override;
  void innovations(std::span<const Observation> measured, FrameInnovation& result) override;
  void widen(double factor) override;
  void predict_pixels(std::span<const int> tracks, std::vector<Prediction>& result) override {
    marginals_.predict_pixels(tracks, result);
  }
  void update(std::span<const Observation> accepted, std::span<const int> considered,
              StageListener& stages) override;
  void leave_one_out(std::vector<LeaveOneOut>& result) override {
    marginals_.leave_one_out(used_, result);
  }
  void inverse_depths(std::span<const int> tracks, std::vector<SeenDepth>& result) override {
    marginals_.inverse_depths(tracks, result);
  }
  void motions(std::span<const int> tracks, std::vector<MotionBelief>& result) override {
    marginals_.motions(tracks, result);
  }
  void collapse(std::span<const int> tracks) override;
  bool remembers_motions() const override { return remembers_; }
  void constrained_motions(std::span<const int> tracks, RememberedMotions& result) override {
    marginals_.constrained_motions(tracks, result);
  }
  void forget_motions(std::span<const int> tracks) override;
  void free(int track, const LandmarkPrior& prior) override;
  void release(std::span<const int> tracks, const TrackRecords& records) override;
  void remove(std::span<const int> tracks, const TrackRecords& records) override;
  bool add(const FirstSight& seen, const LandmarkPrior& prior, bool is_free) override;

  void in_force(InForce& result) const override;
  double scale_information() const override;
  int state_size() const override;
  CameraEstimate camera() const override { return camera_; }
  std::optional<PoseEstimate> pose_before(int frames) const override {
    return marginals_.pose_before(frames);
  }
  void points(std::vector<LandmarkPoint>& result) override;
  std::vector<LandmarkBelief> landmarks(std::span<const int> tracks) const override {
    return marginals_.landmarks(tracks);
  }
  std::vector<CameraEstimate> smoothed() override;

  // For a batch: every camera so far, oldest first, and where there are histories the noise of the
  // step between each two of them.
  std::vector<CameraState> all_cameras() const { return cameras_.all(); }
  const std::vector<MotionNoise>& camera_noises() const { return noises_; }
  // Tells the histories of the landmarks that are still there.
  void end_histories(const TrackRecords& records) const;

  const Graph& graph() const { return graph_; }

 private:
  void release(int track);
  WindowLandmark& insert(int track, VariableId anchor, const Eigen::Vector3d& y);
  void add_pixels(std::span<const Observation> accepted, std::span<const int> considered);
  void consider(const WindowLandmark& landmark, bool is_considered);
  int solve();             // the number of steps
  int minimise();          // likewise
  bool leave_out_poles();  // whether there were any
  void take_step();
  void refactorise();
  double refresh_noises();
  void end_history(const WindowLandmark& landmark, const TrackRecord& record) const;

  Setup setup_;
  WindowOptions options_;
  Gauge gauge_;     // that is asked for
  bool condition_;  // on collapse, w = 0 is used
  bool remembers_;  // and w is kept until the loop forgets it
  const LandmarkFunctions& functions_;
  Graph graph_;
  CameraWindow cameras_;
  WindowLandmarks landmarks_;
  Optimiser optimiser_;  // with the factorisation of the newest update or collapse
  mutable Marginals marginals_;
  Departures departures_;
  CameraEstimate camera_;
  TrackHistories* histories_;
  std::vector<MotionNoise> noises_;
  std::vector<int> measured_, used_;  // of the frame in hand
  ConditionalMap::Values inactive_values_;
  struct Acted {  // in how many frames
    long relinearised = 0, updated = 0, held_points = 0;
  };
  Acted acted_;
};

// Throws std::invalid_argument for an unknown landmark model or classifier; process() throws it at
// the second frame for a singular camera noise.
std::unique_ptr<Estimator> make_window(const Setup& setup, const ModelOptions& models,
                                       const WindowOptions& options);

}  // namespace slammot
