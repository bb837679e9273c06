#include "smoothers/window/window.h"

#include "estimation/gate.h"
#include "estimation/label_policy.h"
#include "models/landmarks/true_state.h"
#include "models/observation.h"
#include "models/so3.h"
#include "smoothers/graph/factors.h"
#include "smoothers/window/window_estimator.h"

namespace slammot {
namespace {

constexpr int kShared = -1;

std::unique_ptr<ceres::LossFunction> make_loss(Loss loss) {
  constexpr double kHuber = 1.345;  // 95% efficient under Gaussian noise (Huber 1981)
  return loss == Loss::kHuber ? std::make_unique<ceres::HuberLoss>(kHuber) : nullptr;
}

// Whether Jacobians are taken at fixed points.
bool first_estimates(WindowLinearisation linearisation) {
  return linearisation != WindowLinearisation::kStandard;
}

}  // namespace

Window::Window(const Setup& setup, const ModelOptions& models, const WindowOptions& options)
    : setup_(setup),
      models_(models),
      options_(options),
      functions_(find_landmark(models.landmark)),
      classifier_(
          make_classifier(classifier_for(functions_, models.classifier), setup.true_labels)),
      depth_prior_(learns_depths(models.depth_prior, !setup.known.empty()), setup.prior),
      loss_(make_loss(options.loss)),
      graph_(first_estimates(options.linearisation)),
      truth_(options.linearisation == WindowLinearisation::kIdeal ? setup.truth : nullptr) {
  if (options.linearisation == WindowLinearisation::kIdeal && !truth_) {
    throw std::invalid_argument("linearisation ideal needs the exact truth of a simulation");
  }
  for (const KnownLandmark& known : setup.known) known_[known.track] = known;
  scene_ = add_scene(graph_, setup.prior);
}

FrameReport Window::process(const Frame& frame, StageListener& stages) {
  FrameReport report;
  stages.begin("predict");
  predict(frame);
  stages.begin("marginalise");
  marginalise_oldest();
  admit_known(frame, report);

  bring_back_measured(frame);

  stages.begin("gate");
  const std::vector<Observation> accepted = gate(frame, report);

  stages.begin("optimise");
  const std::vector<FactorId> pixels = add_measurements(accepted);
  refresh_noises();
  const OptimiseResult optimum = optimise(graph_, options_.iterations, options_.cost_tolerance);

  stages.begin("covariances");
  estimate_camera(optimum.equations, optimum.last_step);
  learn_depths(accepted, optimum.equations);
  testify(accepted, pixels, optimum);

  stages.begin("classify");
  for (auto& [track, landmark] : landmarks_) ++landmark.record.unused_frames;
  for (const Observation& z : accepted) note_accepted(landmarks_.at(z.track).record, frame.index);
  const std::vector<int> now_static = classify(accepted, optimum.equations, frame.index);
  stages.begin("collapse");
  collapse(now_static);
  take_back(frame);

  stages.begin("manage");
  retire(report);
  admit_new(frame, report);
  report.state_size = graph_.far().dim();
  for (const auto& [id, v] : graph_.variables()) report.state_size += v.dim();
  return report;
}

CameraState Window::state(const WindowFrame& frame) const {
  return camera_from_blocks(graph_.value(frame.position).data(), graph_.value(frame.motion).data());
}

// Thesis 2.1.1 and (2.5), as in the EKF: the new camera enters at its prediction.
void Window::predict(const Frame& frame) {
  const auto add_camera = [&](const CameraState& x, int number) {
    Eigen::VectorXd position(3), motion(kMotionSize);
    camera_to_blocks(x, position.data(), motion.data());
    frames_.push_back({number,
                       frame.index,
                       frame.timestamp,
                       graph_.add_variable(position, nullptr, kShared),
                       graph_.add_variable(motion, &motion_manifold_, kShared),
                       {}});
    if (!truth_) return;
    camera_to_blocks(true_camera(*truth_, frame.index), position.data(), motion.data());
    graph_.linearise_at(newest().position, position);
    graph_.linearise_at(newest().motion, motion);
  };
  if (frames_.empty()) {
    first_frame_ = frame.index;
    add_camera(setup_.initial.state, 0);
    graph_.add_factor({newest().position, newest().motion}, initial_camera_cost(setup_.initial));
    return;
  }
  const WindowFrame last = frames_.back();
  const double dt = frame.timestamp - last.timestamp;
  if (!(dt > 0.0)) {
    throw std::invalid_argument("the time of a frame must be later than that of the one before");
  }
  const CameraState x = state(last), at = truth_ ? true_camera(*truth_, last.index) : x;
  add_camera(slammot::predict(x, dt), last.number + 1);
  graph_.add_factor({last.position, last.motion, newest().position, newest().motion},
                    camera_motion_cost(camera_noise(setup_.camera_noise, at, dt), dt));
  for (auto& [track, landmark] : landmarks_) {
    if (!landmark.w) continue;
    extend(landmark, dt);
    linearise_at_truth(landmark);
  }
}

std::optional<ObservedPixel> Window::observed_at_truth(const WindowLandmark& l) const {
  const CameraState x = camera_from_blocks(graph_.point(frames_.back().position).data(),
                                           graph_.point(frames_.back().motion).data());
  return observe(setup_.camera, x.position, x.orientation, graph_.point(l.anchor),
                 true_chain(l).back().head<3>());
}

// As in the EKF: each measurement on its own, against the predicted joint of camera and landmark.
std::vector<Observation> Window::gate(const Frame& frame, FrameReport& report) {
  std::vector<Observation> visible, accepted;
  std::vector<Eigen::Vector2d> innovations;
  std::vector<LinearForm> H;
  const CameraState x = state(newest());
  for (const Observation& z : frame.observations) {
    const auto it = landmarks_.find(z.track);
    if (it == landmarks_.end()) continue;
    const WindowLandmark& l = it->second;
    const ChainState landmark = newest_state(graph_, l);
    const auto h = expect(setup_.camera, x.position, x.orientation, graph_.value(l.anchor),
                          landmark.x.head<3>());
    if (!h) {
      ++report.out_of_view;
      note_rejected(landmarks_.at(z.track).record);
      continue;
    }
    visible.push_back(z);
    innovations.emplace_back(z.pixel - h->pixel);
    LinearForm& form = H.emplace_back();
    form.variables = {newest().position, newest().motion, l.anchor};
    for (const VariableId id : state_variables(l)) form.variables.push_back(id);
    form.J.setZero(2, 15 + landmark.J.cols());
    const ObservedPixel at = truth_ ? observed_at_truth(l).value_or(*h) : *h;
    form.J.leftCols<6>() = at.J_pose;
    form.J.middleCols<3>(12) = at.J_anchor;
    form.J.rightCols(landmark.J.cols()) = at.J_y * landmark.J.topRows<3>();
  }
  if (visible.empty()) return accepted;
  const PixelGate test(models_.gate_probability, setup_.pixel_sigma);
  const std::vector<Eigen::MatrixXd> HPHt = NormalEquations(graph_).covariances(H);
  for (std::size_t i = 0; i < visible.size(); ++i) {
    TrackRecord& record = landmarks_.at(visible[i].track).record;
    const double nis = test.nis(innovations[i], HPHt[i]);
    if (test.passes(nis)) {
      accepted.push_back(visible[i]);
      report.nis_sum += nis;
    } else {
      ++report.rejected;
      note_rejected(record);
      note_innovation(record, nis, models_.labels);
    }
  }
  report.accepted = static_cast<int>(accepted.size());
  return accepted;
}

std::vector<FactorId> Window::add_measurements(const std::vector<Observation>& accepted) {
  std::vector<FactorId> pixels;
  for (const Observation& z : accepted) {
    WindowLandmark& l = landmarks_.at(z.track);
    const auto depth = static_cast<int>(l.noises.size());
    const WindowPixel pixel = measured(l, {newest().position, newest().motion, z.pixel, depth});
    pixels.push_back(pixel.factor);
    if (l.w) l.pixels.push_back(pixel);
    if (record_lives_) l.life.pixels.emplace_back(newest().number, z.pixel);
  }
  return pixels;
}

// With r the residual that is left and I - J P J' its covariance, r' (I - J P J')^-1 r is the NIS
// given all other measurements, as the EKF has it from its innovations (mathematics.md).
void Window::testify(const std::vector<Observation>& accepted, const std::vector<FactorId>& pixels,
                     const OptimiseResult& optimum) {
  if (!watches_innovations(models_.labels)) return;
  std::vector<TrackRecord*> records;
  std::vector<Eigen::Vector2d> residuals;
  std::vector<LinearForm> forms;
  for (std::size_t i = 0; i < accepted.size(); ++i) {
    WindowLandmark& l = landmarks_.at(accepted[i].track);
    const Factor& factor = graph_.factors().at(pixels[i]);
    if (l.w || !factor.valid) continue;
    records.push_back(&l.record);
    residuals.emplace_back(factor.r);
    forms.push_back({factor.variables, before(factor, optimum.last_step)});
  }
  const std::vector<Eigen::MatrixXd> JPJt = optimum.equations.covariances(forms);
  for (std::size_t i = 0; i < forms.size(); ++i) {
    const Eigen::Matrix2d own = Eigen::Matrix2d::Identity() - JPJt[i];
    note_innovation(*records[i], residuals[i].dot(own.inverse() * residuals[i]), models_.labels);
  }
}

// J of a pixel's factor in the coordinates that the last step was taken in.
Eigen::MatrixXd Window::before(const Factor& factor, const Step& last) const {
  Eigen::MatrixXd J = factor.J;
  if (graph_.first_estimates()) return J;
  for (std::size_t i = 0; i < factor.variables.size(); ++i) {
    if (!factor.at[i]->manifold) continue;
    const Eigen::Vector3d turn = last.at(factor.variables[i]).head<3>();
    J.middleCols<3>(factor.offset[i]) *= right_jacobian_so3(turn);
  }
  return J;
}

std::unique_ptr<Estimator> make_window(const Setup& setup, const ModelOptions& models,
                                       const WindowOptions& options) {
  return std::make_unique<Window>(setup, models, options);
}

}  // namespace slammot
