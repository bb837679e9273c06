// The sliding window's belief; see window.h for what it is. The functions stand in the order of a
// frame, here, in window.cpp and in the EKF's files alike.
//
// Between two updates nothing is factorised but where a label changes: gate, labels, births, deaths
// and estimates read the marginals of the last factorisation. What has entered since (a new camera,
// one step of each chain, a new landmark) is conditional on what it knows, and marginalising
// changes nothing of what stays, so that it waits for the next update.
#pragma once

#include "estimation/belief.h"
#include "estimation/gate.h"
#include "smoothers/graph/track_history.h"
#include "smoothers/solver/given_others.h"
#include "smoothers/solver/marginalise.h"
#include "smoothers/solver/optimise.h"
#include "smoothers/window/truth_linearisation.h"
#include "smoothers/window/window.h"

namespace slammot {

// Where Jacobians are to be taken, with linearisation `ideal`; else none. Throws
// std::invalid_argument where there is no truth.
std::shared_ptr<const Truth> truth_of(const Setup& setup, const WindowOptions& options);

class Window final : public Belief {
 public:
  // `histories`: told what happens to landmarks, or null.
  // Throws std::invalid_argument for an unknown landmark model or loss.
  Window(const Setup& setup, const ModelOptions& models, const WindowOptions& options,
         TrackHistories* histories = nullptr);
  Window(const Window&) = delete;  // its parts refer to its graph
  Window& operator=(const Window&) = delete;

  void leaving(std::vector<int>& tracks) override;
  void predict(const Frame& frame, double dt, const MotionNoise& noise,
               const TrackRecords& records) override;
  void add_known(const KnownLandmark& known) override;
  void innovations(std::span<const Observation> measured, FrameInnovation& result) override;
  void widen(double factor) override;
  void predict_pixels(std::span<const int> tracks, std::vector<Prediction>& result) override;
  void update(const TrackRecords& records, std::span<const Observation> accepted,
              StageListener& stages) override;
  void leave_one_out(std::vector<LeaveOneOut>& result) override;
  void inverse_depths(std::span<const int> tracks, std::vector<SeenDepth>& result) override;
  void motions(std::span<const int> tracks, std::vector<MotionBelief>& result) override;
  void collapse(std::span<const int> tracks) override;
  void held_motions(std::span<const int> tracks, std::vector<MotionBelief>& result) override;
  void free(int track, const LandmarkPrior& prior) override;
  void release(int track, const LandmarkPrior& prior) override;
  void remove(std::span<const int> tracks, const TrackRecords& records) override;
  bool add(const Observation& z, const LandmarkPrior& prior, bool is_free) override;
  void add_seen(std::span<const Candidate> candidates, std::vector<int>& refused) override;

  int state_size() const override;
  CameraEstimate camera() const override { return camera_; }
  std::optional<PoseEstimate> pose_before(int frames) const override;
  void points(std::vector<LandmarkPoint>& result) override;
  std::vector<LandmarkBelief> landmarks(std::span<const int> tracks) const override;
  std::vector<CameraEstimate> smoothed() override;

  // Every camera so far, oldest first: as it left, or as it is in the window.
  std::vector<CameraState> all_cameras() const;
  // The noise of the step between each two of them; noted where there are histories.
  const std::vector<MotionNoise>& camera_noises() const { return noises_; }
  const Graph& graph() const { return graph_; }

  // Of all frames so far, with `window.retest`.
  const RetestCounts& retest_counts() const { return retest_counts_; }

  // Tells the histories of the landmarks that are still there.
  void end_histories(const TrackRecords& records) const;

 private:
  // window_marginalise.cpp: what leaves the window, what is deactivated and what returns.
  void marginalise();
  void marginalise_drops();
  void find_departures();
  void depart(const WindowLandmark& landmark, const WindowFrame* oldest, bool is_pruned);
  void finish_departures();
  void find_inactive(const WindowFrame& oldest);
  void reactivate_measured();

  // window_landmarks.cpp: chains.
  void extend(WindowLandmark& landmark, Label label, double dt);
  void end_chain(WindowLandmark& landmark);

  // window_held.cpp: static landmarks that may have moved.
  void forget_motions();
  void motion_rows(const WindowLandmark& landmark, GrowingMatrix& A) const;
  const WindowFrame& base_of_release(const WindowLandmark& landmark) const;
  void move_to_base(const WindowLandmark& landmark, const WindowFrame& base);
  void move_since(WindowLandmark& landmark, const WindowFrame& base);

  // window_retest.cpp
  void note_refused(std::span<const Observation> accepted);
  void forget_refused(int track);
  void forget_pixel(int track, VariableId position);
  bool retest();  // whether anything was let go or admitted
  void retest_held(const WindowLandmark& landmark);
  void retest_refused(const RefusedPixel& refused);
  int insert_pixel(GraphLandmark& l, const WindowLandmark& landmark,
                   const RefusedPixel& refused) const;
  void let_go(const RetestedPixel& z);
  void admit(const RetestedPixel& z);

  // window_probation.cpp
  bool insert_seen(const Candidate& candidate);
  void find_refused(std::span<const Candidate> candidates, std::vector<int>& refused);
  void begin_history(const Candidate& candidate);
  const WindowFrame& frame_of(const Sighting& seen) const;

  WindowLandmark& insert(int track, VariableId anchor, const Eigen::Vector3d& y);
  WindowLandmark* insert_at(const WindowFrame& frame, const Observation& z,
                            const LandmarkPrior& prior, bool is_free);
  void solve();
  bool leave_out_poles();  // whether there were any
  void refactorise();
  void estimate_camera();
  double refresh_noises();
  void prepare(std::span<const int> tracks) const;
  JointMatrix joint(const WindowLandmark& landmark) const;

  // window_innovations.cpp: a measurement's pixel as it is expected.
  struct Expected {
    LandmarkId landmark = 0;
    Eigen::Vector2d nu;    // z - h(x) [px]
    Eigen::Matrix2d HPHt;  // [px^2]
    Eigen::Matrix<double, 2, 6> J_pose;
    // Of (camera, anchor, state) as they were factorised; of one known at first sight: (camera).
    BoundedMatrix<2, Eigen::Dynamic, 2, kMaxJoint> H;
  };
  std::optional<Expected> expected(const Observation& z) const;
  void expect_new(const GraphLandmark& l, const ObservedPixel& h, Expected& result) const;
  void fill_HPHt(GrowingMatrix& HPHt);
  void add_inactive(Eigen::Ref<Eigen::MatrixXd> HPHt) const;

  LandmarkVector at_rest(const WindowLandmark& landmark) const;  // (y, 0) of a static one
  void end_history(const WindowLandmark& landmark, const TrackRecord& record) const;
  bool is_inactive(VariableId id) const { return !graph_.variables[id].is_active; }

  Setup setup_;
  WindowOptions options_;
  bool condition_;  // on collapse, w = 0 is used
  const LandmarkFunctions& functions_;
  int memory_;  // frames for which the motion of a static landmark is remembered
  std::unique_ptr<ceres::LossFunction> loss_;
  Graph graph_;
  CameraWindow cameras_;
  TruthLinearisation truth_;
  std::map<int, WindowLandmark> landmarks_;  // by track
  std::vector<WindowLandmark> pruned_;       // with measurements in the window
  std::vector<VariableId> left_anchors_;     // camera positions whose frame has left
  CameraEstimate camera_;
  mutable Optimiser optimiser_;  // with the factorisation of the newest update or collapse
  Marginaliser marginaliser_;
  TrackHistories* histories_;
  std::vector<MotionNoise> noises_;

  // With `window.retest`.
  double threshold_given_others_;
  GivenOthers given_others_;
  std::vector<Observation> gated_;     // of the frame in hand
  std::vector<RefusedPixel> refused_;  // in the window, of landmarks that are there
  std::vector<RetestedPixel> retested_;
  RetestCounts retest_counts_;

  // The newest camera given the one that the factorisation knows as newest.
  Matrix12d F_ = Matrix12d::Identity(), Q_ = Matrix12d::Zero();

  // Of the frame in hand, kept for their memory.
  std::vector<int> measured_, used_;
  std::vector<Expected> expected_;
  GrowingMatrix core_columns_, motion_rows_, motion_columns_;
  mutable std::vector<LandmarkId> ids_;
  Leaving leaving_;
  std::vector<VariableId> returning_;
  ConditionalMap::Values inactive_values_;
};

}  // namespace slammot
