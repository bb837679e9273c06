#include "filters/ekf.h"

#include "filters/ekf_estimator.h"

namespace slammot {

Ekf::Ekf(const Setup& setup, const ModelOptions& models, const EkfOptions& options)
    : setup_(setup),
      models_(models),
      options_(options),
      landmark_(find_landmark(models.landmark)),
      classifier_(make_classifier(classifier_for(landmark_, models.classifier), setup.true_labels)),
      depth_prior_(learns_depths(models.depth_prior, !setup.known.empty()), setup.prior),
      linearisation_(options.linearisation, landmark_, setup.truth) {
  if (options.deferred && options.linearisation == FilterLinearisation::kInvariant) {
    throw std::invalid_argument(
        "ekf.deferred cannot go with linearisation invariant, which changes far rows at each "
        "update");
  }
  for (const KnownLandmark& known : setup.known) known_[known.track] = known;
  state_.camera = setup.initial.state;
  state_.covariance.append({}, setup.initial.sigmas().cwiseAbs2().asDiagonal().toDenseMatrix());
  const LandmarkPrior& prior = setup.prior;
  if (prior.mean_sigma > 0.0) {
    const Eigen::MatrixXd variance =
        Eigen::MatrixXd::Constant(1, 1, prior.mean_sigma * prior.mean_sigma);
    state_.scene = {prior.inverse_depth, state_.covariance.append({}, variance)};
  }
}

// One frame of the thesis's algorithm (chapters 2 and 3).
FrameReport Ekf::process(const Frame& frame, StageListener& stages) {
  FrameReport report;
  stages.begin("predict");
  if (!timestamp_) first_frame_ = frame.index;
  if (options_.deferred) divide(frame);
  predict(frame);
  admit_known(frame, report);

  stages.begin("gate");
  matches_.clear();
  for (const Observation& z : frame.observations) {
    if (state_.landmarks.contains(z.track)) matches_.push_back({z.track, z.pixel});
  }
  linearise(state_, linearisation_, setup_.camera, matches_, innovation_);
  out_of_view_.swap(innovation_.out_of_view);
  report.out_of_view = static_cast<int>(out_of_view_.size());
  gate(state_, PixelGate(models_.gate_probability, setup_.pixel_sigma), innovation_, gate_);
  accepted_ = innovation_.matches;
  report.accepted = static_cast<int>(accepted_.size());
  report.rejected = static_cast<int>(gate_.rejected.size());
  report.nis_sum = gate_.nis_sum;

  stages.begin("update");
  correct();
  learn_depths();

  stages.begin("classify");
  note(frame.index);
  classify(frame.index);
  stages.begin("collapse");
  collapse();
  take_back();

  stages.begin("manage");
  retire(report);
  admit_new(frame, report);
  check();
  report.state_size = state_.size();
  for (const auto& [track, l] : state_.landmarks) report.negative_inverse_depth += l.y.z() < 0.0;
  return report;
}

// Thesis 2.1.1 for the camera, (2.5) for what may move; a static landmark is not predicted (3.1.3).
void Ekf::predict(const Frame& frame) {
  if (timestamp_ && !(frame.timestamp > *timestamp_)) {
    throw std::invalid_argument("the time of a frame must be later than that of the one before");
  }
  const double dt = timestamp_ ? frame.timestamp - *timestamp_ : 0.0;
  timestamp_ = frame.timestamp;
  if (dt == 0.0) return;  // the first frame
  JointCovariance& P = state_.covariance;
  const CameraState camera_at = linearisation_.camera(state_);
  const Matrix12d Q = camera_noise(setup_.camera_noise, camera_at, dt);
  P.propagate({JointState::kCamera}, predict_jacobian(camera_at, dt), Q);
  state_.camera = slammot::predict(state_.camera, dt);
  for (auto& [track, landmark] : state_.landmarks) {
    if (!landmark.is_free()) continue;
    const Vector6d at = linearisation_.landmark(state_, track);
    const Matrix6d F = landmark_.predict_jacobian(at, dt);
    const Vector6d x = landmark_.predict(landmark.x(), dt);
    landmark.y = x.head<3>();
    landmark.w = x.tail<3>();
    const Matrix6d G =
        landmark_.noise_root(landmark_.predict(at, dt), setup_.prior.acceleration, dt);
    P.propagate({landmark.y_block, landmark.w_block}, F, G * G.transpose());
  }
  linearisation_.predicted(state_, frame.index, dt);
}

void Ekf::correct() {
  const double variance = setup_.pixel_sigma * setup_.pixel_sigma;
  pending_.clear();
  if (options_.delayed) {
    const auto is_pending = [&](const Match& m) {
      return state_.landmarks.at(m.track).record.label == Label::kUnknown;
    };
    matches_.clear();
    for (const Match& m : accepted_) (is_pending(m) ? pending_ : matches_).push_back(m);
    linearise(state_, linearisation_, setup_.camera, matches_, innovation_);
  }
  update(state_, linearisation_, setup_.camera, variance, options_.iterations, innovation_);
  testify();
  for (const Match& m : pending_) {
    update_alone(state_, linearisation_, setup_.camera, m, variance, innovation_);
  }
}

// Without a positive diagonal nothing that follows means anything.
void Ekf::check() const {
  const auto diagonal = state_.covariance.diagonal();
  const StateBlock adjoint = state_.far.adjoint();  // no covariance stands there
  const auto positive = [](const auto& d) { return d.size() == 0 || d.minCoeff() >= 0.0; };
  if (!diagonal.allFinite() || !positive(diagonal.head(adjoint.offset)) ||
      !positive(diagonal.tail(diagonal.size() - adjoint.end()))) {
    throw Diverged("the covariance has a negative or infinite variance");
  }
}

CameraEstimate Ekf::camera() const {
  return {timestamp_.value_or(0.0), state_.camera,
          state_.covariance.block(JointState::kCamera, JointState::kCamera)};
}

std::unique_ptr<Estimator> make_ekf(const Setup& setup, const ModelOptions& models,
                                    const EkfOptions& options) {
  return std::make_unique<Ekf>(setup, models, options);
}

}  // namespace slammot
