// The sliding window's state and the steps of its frame; see window.h for what it is.
//
// Variables: camera position and motion for each frame; for each landmark y, and while it is free w
// and the noises of its chain (landmark_chain.h). The position of the camera in the frame of a
// landmark's birth is its anchor, and stays when that frame has left.
#pragma once

#include <deque>
#include <set>

#include "estimation/classification.h"
#include "estimation/depth_prior.h"
#include "models/observation.h"
#include "smoothers/graph/camera_manifold.h"
#include "smoothers/graph/landmark_variables.h"
#include "smoothers/solver/marginalise.h"
#include "smoothers/solver/optimise.h"
#include "smoothers/window/window.h"

namespace slammot {

struct WindowFrame {
  int number = 0;  // counted from the first frame processed
  int index = 0;   // Frame::index
  double timestamp = 0.0;
  VariableId position = 0;
  VariableId motion = 0;
  std::set<FactorId> knowledge;  // what was stated of landmarks born here; it leaves with the frame
};

// A measurement of a free landmark in the window, with its factor.
struct WindowPixel : MeasuredPixel {
  FactorId factor = 0;
};

// What a batch needs to know of a landmark's life; kept only for one.
struct LandmarkLife {
  int birth = 0;  // WindowFrame::number
  bool known = false;
  std::vector<std::pair<int, Eigen::Vector2d>> pixels;  // by frame, the first one included
  std::vector<Vector6d> states;  // (y, w) by frame from the birth; of a static one its last
  TrackRecord record;

  // A batch knows no change of mind: what was ever taken for moving is free all its life.
  bool is_free() const { return record.was_moving || record.label != Label::kStatic; }
};

// Its chain goes from the base to the newest frame.
struct WindowLandmark : LandmarkVariables {
  TrackRecord record;
  FactorId w_prior = 0;
  VariableId base = 0;                 // camera position of the base's frame
  std::vector<FactorId> noise_priors;  // as `noises`
  std::vector<WindowPixel> pixels;     // of a free landmark
  LandmarkLife life;
};

// The mean inverse depth of the scene with its prior; nothing when it is known (mean_sigma = 0).
std::optional<VariableId> add_scene(Graph& graph, const LandmarkPrior& prior);

class Window : public Estimator {
 public:
  // Throws std::invalid_argument for an unknown landmark model, classifier, linearisation, loss or
  // source of the depth prior.
  Window(const Setup& setup, const ModelOptions& models, const WindowOptions& options);

  FrameReport process(const Frame& frame, StageListener& stages) override;
  CameraEstimate camera() const override { return camera_; }
  std::vector<LandmarkEstimate> landmarks() const override;
  std::vector<LandmarkEstimate> landmarks_measured(int index) const override;
  std::vector<CameraEstimate> smoothed(StageListener& stages) override;

 private:
  friend class Batch;

  // window.cpp: the frame.
  void predict(const Frame& frame);
  std::vector<Observation> gate(const Frame& frame, FrameReport& report);
  // Returns their factors.
  std::vector<FactorId> add_measurements(const std::vector<Observation>& accepted);
  // What they say of the static labels, given all others.
  void testify(const std::vector<Observation>& accepted, const std::vector<FactorId>& pixels,
               const OptimiseResult& optimum);
  Eigen::MatrixXd before(const Factor& factor, const Step& last) const;
  CameraState state(const WindowFrame& frame) const;

  // window_marginalise.cpp: what leaves.
  void marginalise_oldest();
  // What leaves with the oldest frame, and what then rests in the far map.
  std::set<VariableId> rest(const WindowFrame& oldest, std::set<VariableId>& leaving);
  void bring_back_measured(const Frame& frame);

  // window_estimates.cpp: what is believed.
  void estimate_camera(const NormalEquations& equations, const Step& last);
  std::vector<LandmarkEstimate> estimate(const std::vector<int>& tracks) const;

  // window_landmarks.cpp: the life of landmarks.
  void admit_known(const Frame& frame, FrameReport& report);
  void admit_new(const Frame& frame, FrameReport& report);
  WindowLandmark& birth(const TrackRecord& record, const Eigen::Vector2d& pixel);
  void learn_depths(const std::vector<Observation>& accepted, const NormalEquations& equations);
  // Returns the tracks that are static from now on.
  std::vector<int> classify(const std::vector<Observation>& accepted,
                            const NormalEquations& equations, int frame);
  void collapse(const std::vector<int>& tracks);
  void add_motion(WindowLandmark& landmark);
  // Takes back static labels that the innovations of this frame reject.
  void take_back(const Frame& frame);
  void condition(WindowLandmark& landmark);
  void drop(WindowLandmark& landmark);
  void retire(FrameReport& report);

  // window_chains.cpp: free landmarks through the window.
  void extend(WindowLandmark& landmark, double dt);
  // With linearisation `ideal`: its points and the G of its chain are the truth's; else nothing.
  void linearise_at_truth(const WindowLandmark& landmark);
  std::vector<Vector6d> true_chain(const WindowLandmark& landmark) const;
  std::optional<ObservedPixel> observed_at_truth(const WindowLandmark& landmark) const;
  double refresh_noises();  // of all landmarks
  WindowPixel measured(const WindowLandmark& landmark, const MeasuredPixel& z);
  Advance advance(const WindowLandmark& landmark, const Vector6d& from, std::size_t step) const;
  std::vector<Advance> leave_base(WindowLandmark& landmark, std::set<VariableId>& leaving);
  void enter_base(WindowLandmark& landmark, VariableId base);
  void end_chain(WindowLandmark& landmark);
  // The states of its chain before the newest, into its life.
  void remember_chain(WindowLandmark& landmark) const;
  // Its states (y, 0) of frames in which it was static, before the newest.
  void remember_rest(WindowLandmark& landmark) const;
  LandmarkLife life_so_far(const WindowLandmark& landmark) const;

  WindowFrame& newest() { return frames_.back(); }

  Setup setup_;
  ModelOptions models_;
  WindowOptions options_;
  const LandmarkFunctions& functions_;
  std::unique_ptr<Classifier> classifier_;
  DepthPrior depth_prior_;
  std::unique_ptr<ceres::LossFunction> loss_;
  MotionManifold motion_manifold_;
  std::map<int, KnownLandmark> known_;
  std::set<int> known_used_;
  Graph graph_;
  std::shared_ptr<const Truth> truth_;  // of linearisation `ideal`
  std::optional<VariableId> scene_;     // mean inverse depth at first sight, when it is learnt
  std::deque<WindowFrame> frames_;
  std::map<int, WindowLandmark> landmarks_;  // by track
  std::vector<WindowLandmark> dead_;         // lost, with measurements in the window
  std::set<VariableId> left_anchors_;        // camera positions whose frame has left, far ones too
  CameraEstimate camera_;
  // Cameras as they were believed when they left the window, by time.
  std::vector<std::pair<double, CameraState>> left_;
  int first_frame_ = 0;
  bool record_lives_ = false;
  std::vector<LandmarkLife> ended_lives_;
};

}  // namespace slammot
