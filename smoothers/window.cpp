#include "slammot/smoothers/window.h"

#include "slammot/models/observation.h"
#include "slammot/smoothers/factors.h"
#include "slammot/smoothers/window_estimator.h"

namespace slammot {
namespace {

constexpr int kShared = -1;

std::unique_ptr<ceres::LossFunction> make_loss(const std::string& name) {
  constexpr double kHuber = 1.345;  // 95% efficient under Gaussian noise (Huber 1981)
  if (name == "huber") return std::make_unique<ceres::HuberLoss>(kHuber);
  if (name == "none") return nullptr;
  throw std::invalid_argument("unknown loss '" + name + "'");
}

bool first_estimates(const std::string& linearisation) {
  if (linearisation == "fej") return true;
  if (linearisation == "standard") return false;
  throw std::invalid_argument("unknown linearisation '" + linearisation + "' of the window");
}

}  // namespace

Window::Window(const Setup& setup, const ModelOptions& models, const WindowOptions& options)
    : setup_(setup),
      models_(models),
      options_(options),
      functions_(find_landmark(models.landmark)),
      classifier_(
          make_classifier(classifier_for(functions_, models.classifier), setup.true_labels)),
      loss_(make_loss(options.loss)),
      graph_(first_estimates(options.linearisation)) {
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
  add_measurements(accepted);
  refresh_noises();
  const OptimiseResult optimum = optimise(graph_, options_.iterations, options_.negligible);

  stages.begin("covariances");
  estimate_camera(optimum.equations, optimum.last_step);

  stages.begin("classify");
  for (auto& [track, landmark] : landmarks_) ++landmark.record.unused_frames;
  for (const Observation& z : accepted) note_accepted(landmarks_.at(z.track).record, frame.index);
  classify(accepted, optimum.equations, frame.index);

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
  const CameraState x = state(last);
  add_camera(slammot::predict(x, dt), last.number + 1);
  graph_.add_factor({last.position, last.motion, newest().position, newest().motion},
                    camera_motion_cost(camera_noise(setup_.camera_noise, x, dt), dt));
  for (auto& [track, landmark] : landmarks_) {
    if (landmark.w) extend(landmark, dt);
  }
}

// The oldest frame leaves before the new measurements enter. A camera's position stays on as long
// as landmarks are anchored there.
void Window::marginalise_oldest() {
  if (static_cast<int>(frames_.size()) <= options_.frames) return;
  const WindowFrame oldest = frames_.front();
  const VariableId next = frames_[1].position;
  left_.push_back({oldest.timestamp, state(oldest)});
  std::vector<WindowLandmark*> moving;
  for (auto& [track, landmark] : landmarks_) {
    if (landmark.w && landmark.base == oldest.position) moving.push_back(&landmark);
  }
  for (WindowLandmark& landmark : dead_) {
    if (landmark.base == oldest.position) moving.push_back(&landmark);
  }
  std::set<VariableId> leaving{oldest.motion};
  std::vector<Advance> advances;
  for (WindowLandmark* landmark : moving) {
    for (const Advance& a : leave_base(*landmark, leaving)) advances.push_back(a);
  }
  const std::set<VariableId> resting = rest(oldest, leaving);
  marginalise(graph_, leaving, advances, oldest.knowledge, resting);
  for (WindowLandmark* landmark : moving) enter_base(*landmark, next);
  std::erase_if(dead_, [&](const WindowLandmark& l) { return leaving.contains(l.y); });
  frames_.pop_front();
}

// Static landmarks that no frame after the oldest has measured rest, and so do anchors of which all
// landmarks rest; an anchor of no landmark leaves.
std::set<VariableId> Window::rest(const WindowFrame& oldest, std::set<VariableId>& leaving) {
  std::set<VariableId> resting, anchors_near, anchors_far;
  for (const auto& [track, l] : landmarks_) {
    const bool near = l.w || l.record.last_frame > oldest.index;
    if (!near && !graph_.far().contains(l.y)) resting.insert(l.y);
    (near ? anchors_near : anchors_far).insert(l.anchor);
  }
  for (const WindowLandmark& l : dead_) {
    if (!leaving.contains(l.y)) anchors_near.insert(l.anchor);
  }
  left_anchors_.insert(oldest.position);
  std::set<VariableId> unused;
  for (const VariableId anchor : left_anchors_) {
    if (anchors_near.contains(anchor)) continue;
    if (!anchors_far.contains(anchor)) {
      unused.insert(anchor);
    } else if (!graph_.far().contains(anchor)) {
      resting.insert(anchor);
    }
  }
  for (const VariableId anchor : unused) {
    left_anchors_.erase(anchor);
    if (graph_.far().contains(anchor)) {
      graph_.remove_variables({anchor});
    } else {
      leaving.insert(anchor);
    }
  }
  return resting;
}

void Window::bring_back_measured(const Frame& frame) {
  std::set<VariableId> back;
  for (const Observation& z : frame.observations) {
    const auto it = landmarks_.find(z.track);
    if (it == landmarks_.end()) continue;
    for (const VariableId id : {it->second.y, it->second.anchor}) {
      if (graph_.far().contains(id)) back.insert(id);
    }
  }
  graph_.bring_back({back.begin(), back.end()});
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
    const ChainState landmark = newest_state(l);
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
    form.J.leftCols<6>() = h->J_pose;
    form.J.middleCols<3>(12) = h->J_anchor;
    form.J.rightCols(landmark.J.cols()) = h->J_y * landmark.J.topRows<3>();
  }
  if (visible.empty()) return accepted;
  const double threshold = -2.0 * std::log1p(-models_.gate_probability);
  const std::vector<Eigen::MatrixXd> HPHt = NormalEquations(graph_).covariances(H);
  for (std::size_t i = 0; i < visible.size(); ++i) {
    Eigen::Matrix2d S = HPHt[i];
    S.diagonal().array() += setup_.pixel_sigma * setup_.pixel_sigma;
    const double nis = innovations[i].dot(S.inverse() * innovations[i]);
    if (nis <= threshold) {
      accepted.push_back(visible[i]);
      report.nis_sum += nis;
    } else {
      ++report.rejected;
      note_rejected(landmarks_.at(visible[i].track).record);
    }
  }
  report.accepted = static_cast<int>(accepted.size());
  return accepted;
}

void Window::add_measurements(const std::vector<Observation>& accepted) {
  for (const Observation& z : accepted) {
    WindowLandmark& l = landmarks_.at(z.track);
    WindowPixel pixel{0, newest().position, newest().motion, z.pixel,
                      static_cast<int>(l.noises.size())};
    pixel.factor = add_pixel(l, pixel);
    if (l.w) l.pixels.push_back(pixel);
    if (record_lives_) l.life.pixels.emplace_back(newest().number, z.pixel);
  }
}

// The newest camera with its marginal covariance at the last linearisation, in the coordinates of
// the estimate.
void Window::estimate_camera(const NormalEquations& equations, const Step& last) {
  const std::vector<std::vector<VariableId>> camera{{newest().position, newest().motion}};
  Matrix12d P = equations.covariances(camera).front();
  if (!graph_.first_estimates()) {
    const Eigen::Vector3d turn = last.at(newest().motion).head<3>();
    const Eigen::Matrix3d J = right_jacobian_so3(turn);
    P.middleRows<3>(kRotation) = (J * P.middleRows<3>(kRotation)).eval();
    P.middleCols<3>(kRotation) = (P.middleCols<3>(kRotation) * J.transpose()).eval();
  }
  camera_ = {newest().timestamp, state(newest()), 0.5 * (P + P.transpose())};
}

std::vector<LandmarkEstimate> Window::estimate(const std::vector<int>& tracks) const {
  if (tracks.empty()) return {};
  std::vector<LinearForm> forms;
  std::vector<LandmarkBelief> beliefs;
  std::vector<Eigen::MatrixXd> far;
  for (const int track : tracks) {
    const WindowLandmark& l = landmarks_.at(track);
    const ChainState landmark = newest_state(l);
    LandmarkBelief& belief = beliefs.emplace_back();
    belief.anchor = graph_.value(l.anchor);
    belief.y = landmark.x.head<3>();
    belief.w = landmark.x.tail<3>();
    LinearForm& form = forms.emplace_back();
    form.variables = {l.anchor};
    for (const VariableId id : state_variables(l)) form.variables.push_back(id);
    const Eigen::Index dim = l.w ? 6 : 3;
    form.J.setZero(3 + dim, 3 + landmark.J.cols());
    form.J.topLeftCorner<3, 3>().setIdentity();
    form.J.bottomRightCorner(dim, landmark.J.cols()) = landmark.J.topRows(dim);
    far.push_back(replace_far(graph_, form));
  }
  const std::vector<Eigen::MatrixXd> P = NormalEquations(graph_).covariances(forms);
  std::vector<LandmarkEstimate> estimates;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    beliefs[i].covariance = P[i] + far[i];
    estimates.push_back(functions_.estimate(landmarks_.at(tracks[i]).record, beliefs[i]));
  }
  return estimates;
}

std::vector<LandmarkEstimate> Window::landmarks() const {
  std::vector<int> tracks;
  for (const auto& [track, landmark] : landmarks_) tracks.push_back(track);
  return estimate(tracks);
}

std::vector<LandmarkEstimate> Window::landmarks_measured(int index) const {
  std::vector<int> tracks;
  for (const auto& [track, landmark] : landmarks_) {
    if (landmark.record.last_frame == index) tracks.push_back(track);
  }
  return estimate(tracks);
}

// Cameras as they left the window, without covariances, which belong to that moment and are not
// kept; then those still in it, converged, with theirs.
std::vector<CameraEstimate> Window::smoothed(StageListener&) {
  optimise(graph_, options_.iterations, options_.negligible);
  for (int i = 0; i < kMaxRefreshes && refresh_noises() > kNegligibleNoise; ++i) {
    optimise(graph_, options_.iterations, options_.negligible);
  }
  graph_.linearise();
  std::vector<std::vector<VariableId>> sets;
  for (const WindowFrame& f : frames_) sets.push_back({f.position, f.motion});
  const std::vector<Eigen::MatrixXd> P = NormalEquations(graph_).covariances(sets);
  std::vector<CameraEstimate> result;
  for (const auto& [timestamp, x] : left_) {
    result.push_back({timestamp, x, Matrix12d::Constant(kUndefined)});
  }
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    result.push_back({frames_[i].timestamp, state(frames_[i]), P[i]});
  }
  return result;
}

std::unique_ptr<Estimator> make_window(const Setup& setup, const ModelOptions& models,
                                       const WindowOptions& options) {
  return std::make_unique<Window>(setup, models, options);
}

}  // namespace slammot
