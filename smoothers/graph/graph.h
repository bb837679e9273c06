// The factor graph of a smoother: cameras, landmarks, what ties them, and a prior that stands for
// what has been marginalised. Everything keeps its last linearisation, expressed at the current
// estimate; what is solved, marginalised and reported all comes from these same numbers.
#pragma once

#include "smoothers/graph/landmark.h"
#include "smoothers/graph/prior.h"

namespace slammot {

struct GraphCamera {
  VariableId position = 0, orientation = 0, rates = 0;  // rates: v (W), omega (C)
  double time = 0.0;                                    // [s]
};

struct InitialCameraFactor {
  GraphCamera camera;
  InitialCamera initial;
  Vector12d r = Vector12d::Zero();
  Matrix12d J = Matrix12d::Zero();
};

struct CameraMotionFactor {
  GraphCamera from, to;
  Matrix12d weight = Matrix12d::Zero();  // square_root_information()
  double dt = 0.0;
  Vector12d r = Vector12d::Zero();
  Matrix12d J_from = Matrix12d::Zero(), J_to = Matrix12d::Zero();
};

// (m - rho0) / mean_sigma of the scene's mean inverse depth.
struct ScenePrior {
  VariableId scene = 0;
  double inverse_depth = 0.0, sigma = 1.0;
  double r = 0.0;
};

// A batch, and a window in smoothed(), solve, refresh the noises (Graph::refresh_noises) and solve
// again until no noise changes by more than this [sigma]; the window so often at most.
inline constexpr double kNegligibleNoise = 1e-7;
inline constexpr int kMaxRefreshes = 20;

// A step, judged at where it leads.
struct StepOutcome {
  double square = 0.0;        // sum of squares; a pixel that is no longer valid costs very much
  double error_square = 0.0;  // |r(x [+] dx) - (r + J dx)|^2 of the residuals that are not linear
  int residuals = 0;          // how many these are

  double cost() const { return 0.5 * square; }
  // Their root mean square [sigma]: how far the linearised problem is from the true one.
  double linearisation_error() const;
  // What it would cost if every such residual were off by `error`.
  double cost_of(double error) const { return 0.5 * residuals * error * error; }

  template <typename Residual, typename Linear>
  void add(const Residual& r, const Linear& linear) {
    error_square += (r - linear).squaredNorm();
    residuals += static_cast<int>(r.size());
  }
};

class Graph {
 public:
  // `fixed_points`: Jacobians of variables that the prior holds stay where they were then.
  Graph(const GraphModels& models, bool fixed_points)
      : models_(models),
        fixed_points_(fixed_points),
        prior_{MarginalPrior(fixed_points, models.keeps_scale),
               ConditionalMap(models.keeps_scale)} {}

  GraphCamera add_camera(const CameraState& x);
  CameraState camera(const GraphCamera& camera) const;
  CameraState linearisation_point(const GraphCamera& camera) const;

  // Factors are linearised as they are added. Throws std::invalid_argument when Q is singular.
  void add_initial(const GraphCamera& camera, const InitialCamera& initial);
  void add_motion(const GraphCamera& from, const GraphCamera& to, const Matrix12d& Q, double dt);
  void widen_newest_motion(double factor);  // Q := factor Q
  void add_scene(const LandmarkPrior& prior);

  GraphLandmark& operator[](LandmarkId id) { return landmarks[static_cast<std::size_t>(id)]; }
  const GraphLandmark& operator[](LandmarkId id) const {
    return landmarks[static_cast<std::size_t>(id)];
  }
  LandmarkId add_landmark(VariableId anchor, const Eigen::Vector3d& y);
  void remove_landmark(LandmarkId id);
  // It is free from its base, where no chain has begun, with w at zero under its prior.
  void free_landmark(LandmarkId id, const MotionVector& sigmas);
  // It has been at rest all the time: w and all noises are zero, and its measurements are those of
  // one point. Those along the chain are linearised anew. w is kept, until it is forgotten or
  // released, and a chain begins. `rest_time` is that of the base [s].
  void constrain_to_rest(LandmarkId id, double rest_time);
  void forget_motion(LandmarkId id);
  void release_motion(LandmarkId id);
  // A free landmark that corrects itself only (modules/consider.h), or not so any more. The rest,
  // which is the core, is solved for without it; then it is, given the core, p(o | core). What the
  // prior holds of it must then be just that (Leaving::apart).
  void consider(LandmarkId id, bool is_considered);
  // A measurement by a camera at the end of the chain.
  void add_pixel(LandmarkId id, const GraphCamera& camera, const Observation& z, int depth);

  // Whether it is solved for with the cameras: neither inactive nor considered.
  bool is_solved_jointly(const GraphLandmark& landmark) const {
    return landmark.is_alive && !landmark.is_considered && variables[landmark.y].is_active;
  }

  // Brings inactive variables back into the prior, at their mean. Throws Diverged when their
  // covariance is not positive definite.
  void reactivate(const std::vector<VariableId>& ids);

  // Of an active variable its value; of an inactive one its mean given the active ones.
  SmallVector value(VariableId id) const;

  // The states of a landmark's chain, base first, at the current estimate; y alone of a static one.
  std::vector<LandmarkVector> states(const GraphLandmark& landmark) const;
  LandmarkVector newest_state(const GraphLandmark& landmark) const;

  // Takes G along the chain's states, and the noises of least norm that lead through them. G
  // depends on the depth, which a smoother goes on correcting: with the old noises and a new G the
  // landmark would jump. Returns the largest change of a noise [sigma].
  double refresh_noises(GraphLandmark& landmark);

  // Linearises all but the considered landmarks anew at the current estimate; returns half the sum
  // of squares there, prior included. A pixel that is not valid does not count: if it cost
  // something, any step that ends this would be taken, however bad.
  double linearise();
  // Of one landmark; returns its whole sum of squares, not half of it.
  double linearise(GraphLandmark& landmark);

  // A moving landmark that may pass through the camera can explain any pixel there: the solution is
  // drawn to that pole and then held by its edge (observation.h), all of it. A measurement whose
  // landmark has come within 5 cm of the camera, or behind it, says nothing of the rest. Smoothers
  // leave it out and solve again.
  bool is_at_pole(const GraphPixel& pixel) const;

  // Shortens the steps of y where points lack infinity (limited_step); true when one was shortened
  // by the factor. A landmark's least inverse depth [1/m] is a hundredth of its birth's mean, 0
  // where the prior holds the birth.
  bool limit_step();
  double farthest(const GraphLandmark& landmark) const;

  // What is true at x [+] step, without considered landmarks. Nothing is changed but
  // Variable::candidate.
  StepOutcome try_step();

  // One landmark moves while the rest stays. First all steps are zero, and candidates the values.
  void clear_steps();
  // Half the square of what the prior says of its variables, at their values or candidates.
  double cost_of_prior(LandmarkId id, MarginalPrior::Field field = &Variable::value);
  // What is true at its variables [+] step, as try_step() of all; and that step, taken.
  StepOutcome try_own_step(LandmarkId id);
  void take_own_step(LandmarkId id);

  // x := x [+] step, prior untouched. Stored linearisations are carried along: r += J dx, and J is
  // expressed in the tangent space at the new estimate.
  void retract();

  const GraphModels& models() const { return models_; }
  bool fixed_points() const { return fixed_points_; }
  bool keeps_scale() const { return models_.keeps_scale; }

  Variables variables;
  std::optional<InitialCameraFactor> initial;
  std::vector<CameraMotionFactor> motions;  // oldest first
  std::optional<ScenePrior> scene;
  std::deque<GraphLandmark> landmarks;  // slots
  Prior& prior() { return prior_; }
  const Prior& prior() const { return prior_; }

 private:
  void linearise(InitialCameraFactor& factor);
  void linearise(CameraMotionFactor& factor);
  void linearise_chain(GraphLandmark& landmark);
  double linearise_pixel(GraphPixel& pixel, const GraphLandmark& landmark, const Eigen::Vector3d& y,
                         const Eigen::Vector3d& y_point);
  void linearise_motion(GraphPixel& pixel, const GraphLandmark& landmark,
                        const Eigen::Vector3d& y_point) const;
  double linearise_birth(GraphLandmark& landmark);
  void try_step(const GraphLandmark& landmark, StepOutcome& outcome) const;
  void try_step(const GraphPixel& pixel, const GraphLandmark& landmark, const Eigen::Vector3d& y,
                const LandmarkVector& dx, StepOutcome& outcome) const;
  void retract(GraphLandmark& landmark);
  void turn_jacobians();

  GraphModels models_;
  bool fixed_points_;
  Prior prior_;
  std::vector<LandmarkId> vacant_;
};

}  // namespace slammot
