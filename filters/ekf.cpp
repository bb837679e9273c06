#include "slammot/filters/ekf.h"

#include <Eigen/Cholesky>
#include <set>

#include "slammot/filters/ekf_update.h"
#include "slammot/models/classification.h"
#include "slammot/models/initialisation.h"
#include "slammot/models/landmark_models.h"
#include "slammot/models/observation.h"

namespace slammot {
namespace {

class Ekf final : public Estimator {
 public:
  Ekf(const Setup& setup, const ModelOptions& models, const EkfOptions& options);

  FrameReport process(const Frame& frame, StageListener& stages) override;
  CameraEstimate camera() const override;
  std::vector<LandmarkEstimate> landmarks() const override;

 private:
  void predict(const Frame& frame);
  void correct(const Innovation& accepted);
  void classify(const std::vector<Match>& seen, int frame);
  void collapse(const std::vector<int>& tracks);
  void retire(FrameReport& report);
  void admit_known(const Frame& frame, FrameReport& report);
  void admit_new(const Frame& frame, FrameReport& report);
  FilterLandmark& add(TrackRecord record, const Eigen::Vector3d& y, StateBlock block, int frame);
  FilterAnchor& anchor_here(int frame);
  LandmarkEstimate estimate(const FilterLandmark& landmark) const;
  void check() const;

  Setup setup_;
  ModelOptions models_;
  EkfOptions options_;
  const LandmarkFunctions& landmark_;
  std::unique_ptr<Classifier> classifier_;
  std::map<int, KnownLandmark> known_;
  std::set<int> known_used_;
  JointState state_;
  Linearisation linearisation_;
  std::optional<double> timestamp_;
  int first_frame_ = 0;  // index of the first frame processed
};

Ekf::Ekf(const Setup& setup, const ModelOptions& models, const EkfOptions& options)
    : setup_(setup),
      models_(models),
      options_(options),
      landmark_(find_landmark(models.landmark)),
      classifier_(make_classifier(classifier_for(landmark_, models.classifier), setup.true_labels)),
      linearisation_(options.linearisation, landmark_, setup.truth) {
  for (const KnownLandmark& known : setup.known) known_[known.track] = known;
  const InitialCamera& initial = setup.initial;
  Vector12d sigma;
  sigma << Eigen::Vector3d::Constant(initial.position_sigma),
      Eigen::Vector3d::Constant(initial.rotation_sigma),
      Eigen::Vector3d::Constant(initial.velocity_sigma),
      Eigen::Vector3d::Constant(initial.angular_velocity_sigma);
  state_.camera = initial.state;
  state_.covariance.append({}, sigma.cwiseAbs2().asDiagonal().toDenseMatrix());
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
  predict(frame);
  admit_known(frame, report);

  stages.begin("gate");
  std::vector<Match> matches;
  for (const Observation& z : frame.observations) {
    if (state_.landmarks.contains(z.track)) matches.push_back({z.track, z.pixel});
  }
  const Innovation all = innovation(state_, linearisation_, setup_.camera, matches);
  const Gate gated = gate(state_, all, PixelGate(models_.gate_probability, setup_.pixel_sigma));
  report.accepted = static_cast<int>(gated.accepted.matches.size());
  report.rejected = static_cast<int>(gated.rejected.size());
  std::set<int> out_of_view;
  for (const Match& m : matches) out_of_view.insert(m.track);
  for (const Match& m : all.matches) out_of_view.erase(m.track);
  report.out_of_view = static_cast<int>(out_of_view.size());
  report.nis_sum = gated.nis_sum;

  stages.begin("update");
  correct(gated.accepted);

  stages.begin("classify");
  for (auto& [track, landmark] : state_.landmarks) ++landmark.record.unused_frames;
  for (const Match& m : gated.accepted.matches) {
    note_accepted(state_.landmarks.at(m.track).record, frame.index);
  }
  for (const int track : gated.rejected) note_rejected(state_.landmarks.at(track).record);
  for (const int track : out_of_view) note_rejected(state_.landmarks.at(track).record);
  classify(gated.accepted.matches, frame.index);

  stages.begin("manage");
  retire(report);
  admit_new(frame, report);
  check();
  report.state_size = state_.covariance.size();
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
  P.propagate(JointState::kCamera, predict_jacobian(camera_at, dt), Q);
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
    P.propagate(landmark.block, F, G * G.transpose());
  }
  linearisation_.predicted(state_, frame.index, dt);
}

void Ekf::correct(const Innovation& accepted) {
  const double variance = setup_.pixel_sigma * setup_.pixel_sigma;
  if (!options_.delayed) {
    update(state_, linearisation_, setup_.camera, accepted, variance, options_.iterations);
    return;
  }
  std::vector<Match> classified, pending;
  for (const Match& m : accepted.matches) {
    const bool unknown = state_.landmarks.at(m.track).record.label == Label::kUnknown;
    (unknown ? pending : classified).push_back(m);
  }
  const Innovation first = innovation(state_, linearisation_, setup_.camera, classified);
  update(state_, linearisation_, setup_.camera, first, variance, options_.iterations);
  for (const Match& m : pending) update_alone(state_, linearisation_, setup_.camera, m, variance);
}

// Thesis 3.1.3, for every unknown landmark measured in this frame.
void Ekf::classify(const std::vector<Match>& seen, int frame) {
  std::vector<int> now_static;
  for (const Match& match : seen) {
    FilterLandmark& landmark = state_.landmarks.at(match.track);
    if (landmark.record.label != Label::kUnknown) continue;
    MotionBelief belief;
    belief.track = match.track;
    belief.w = landmark.w;
    belief.covariance = state_.covariance.block(landmark.w_block(), landmark.w_block());
    belief.prior_sigma = landmark_.prior_sigma(setup_.prior);
    belief.density_scale = landmark_.density_scale(landmark.x());
    note_decision(landmark.record, classifier_->decide(belief), frame);
    if (landmark.record.label == Label::kStatic) now_static.push_back(match.track);
  }
  collapse(now_static);
}

// (3.3). `condition` first uses w = 0 as an exact measurement: K = P[:,w] P_ww^-1.
void Ekf::collapse(const std::vector<int>& tracks) {
  if (tracks.empty()) return;
  if (models_.collapse == "condition") {
    const auto m = static_cast<Eigen::Index>(3 * tracks.size());
    Eigen::MatrixXd P_w(state_.covariance.size(), m);
    Eigen::VectorXd w(m);
    std::vector<int> rows;
    for (std::size_t i = 0; i < tracks.size(); ++i) {
      const FilterLandmark& landmark = state_.landmarks.at(tracks[i]);
      const auto at = static_cast<Eigen::Index>(3 * i);
      P_w.middleCols(at, 3) = state_.covariance.cols(landmark.w_block());
      w.segment<3>(at) = landmark.w;
      for (int k = 0; k < 3; ++k) rows.push_back(landmark.w_block().offset + k);
    }
    const Eigen::LLT<Eigen::MatrixXd> P_ww(P_w(rows, Eigen::all));
    if (P_ww.info() != Eigen::Success) throw Diverged("a velocity's covariance is not positive");
    Eigen::MatrixXd W = P_w;
    P_ww.matrixU().solveInPlace<Eigen::OnTheRight>(W);
    const Eigen::VectorXd dx = -W * P_ww.matrixL().solve(w);
    state_.covariance.subtract_outer(W);
    linearisation_.correct(state_, dx);
  }
  state_.drop_motion(tracks);
}

void Ekf::retire(FrameReport& report) {
  std::vector<int> lost;
  const CameraState c = linearisation_.camera(state_);
  for (auto& [track, landmark] : state_.landmarks) {
    if (landmark.record.unused_frames > 0) {
      note_unused(landmark.record, in_view(setup_.camera, c.position, c.orientation,
                                           linearisation_.anchor(state_, landmark.anchor),
                                           linearisation_.landmark(state_, track).head<3>()));
    }
    if (!is_lost(landmark.record, models_.policy)) continue;
    lost.push_back(track);
    report.retired.push_back(estimate(landmark));
  }
  state_.remove_landmarks(lost);
}

FilterAnchor& Ekf::anchor_here(int frame) {
  const auto found = state_.anchors.find(frame);
  if (found != state_.anchors.end()) return found->second;
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  const StateBlock block =
      state_.covariance.append({{{kPosition, 3}, I}}, Eigen::MatrixXd::Zero(3, 3));
  return state_.anchors[frame] = {state_.camera.position, block, 0};
}

FilterLandmark& Ekf::add(TrackRecord record, const Eigen::Vector3d& y, StateBlock block,
                         int frame) {
  ++state_.anchors.at(frame).landmarks;
  FilterLandmark& landmark = state_.landmarks[record.track];
  landmark.record = record;
  landmark.anchor = frame;
  landmark.y = y;
  landmark.block = block;
  return landmark;
}

// Landmarks known beforehand enter before the update, so that their first pixel counts as well.
void Ekf::admit_known(const Frame& frame, FrameReport& report) {
  for (const Observation& z : frame.observations) {
    const auto known = known_.find(z.track);
    if (known == known_.end() || state_.landmarks.contains(z.track)) continue;
    if (!known_used_.insert(z.track).second) continue;  // what was stated counts once
    const FilterAnchor& anchor = anchor_here(frame.index);
    const NewKnownLandmark born_here = initialise_known(known->second, anchor.position);
    const Eigen::MatrixXd J =
        linearisation_.known_birth(state_, known->second, frame.index, born_here).J_y_position;
    const double variance = known->second.sigma * known->second.sigma;
    const StateBlock block =
        state_.covariance.append({{anchor.block, -J}}, variance * J * J.transpose());
    TrackRecord record = born(z.track, frame.index, Label::kStatic, true);
    record.observations = 0;
    add(record, born_here.y, block, frame.index);
    ++report.admitted;
  }
}

// Thesis 2.1.3, (2.7): y from pixel, rotation and prior, with its full cross-covariance.
void Ekf::admit_new(const Frame& frame, FrameReport& report) {
  std::vector<Observation> candidates;
  for (const Observation& z : frame.observations) {
    if (!state_.landmarks.contains(z.track)) candidates.push_back(z);
  }
  const auto births =
      admit(candidates, static_cast<int>(state_.landmarks.size()), report.accepted, models_.policy);
  const bool first_frame = frame.index == first_frame_;
  for (const Observation& z : births) {
    const auto y =
        initialise(setup_.camera, state_.camera.orientation, z.pixel,
                   state_.scene ? state_.scene->inverse_depth : setup_.prior.inverse_depth);
    if (!y) continue;
    const NewLandmark at = linearisation_.birth(state_, setup_.camera, z, frame.index, *y);
    const Label label = classifier_->at_birth(z.track, first_frame);
    const int dim = label == Label::kStatic ? 3 : 6;
    const double w_sigma = landmark_.prior_sigma(setup_.prior);
    Eigen::MatrixXd R = Eigen::MatrixXd::Zero(dim, dim);
    R.topLeftCorner<2, 2>() =
        setup_.pixel_sigma * setup_.pixel_sigma * at.J_angles_pixel * at.J_angles_pixel.transpose();
    R(2, 2) = setup_.prior.inverse_depth_sigma * setup_.prior.inverse_depth_sigma;
    R.bottomRightCorner(dim - 3, dim - 3).diagonal().setConstant(w_sigma * w_sigma);
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(dim, 3);
    J.topRows<2>() = at.J_angles_rotation;
    anchor_here(frame.index);
    std::vector<JointCovariance::Dependence> on{{{kRotation, 3}, J}};
    if (state_.scene) on.push_back({state_.scene->block, Eigen::MatrixXd::Identity(dim, 3).col(2)});
    const StateBlock block = state_.covariance.append(on, R);
    add(born(z.track, frame.index, label, first_frame), y->y, block, frame.index);
    ++report.admitted;
  }
}

// Without a positive diagonal nothing that follows means anything.
void Ekf::check() const {
  const auto diagonal = state_.covariance.P().diagonal();
  if (!diagonal.allFinite() || diagonal.minCoeff() < 0.0) {
    throw Diverged("the covariance has a negative or infinite variance");
  }
}

CameraEstimate Ekf::camera() const {
  return {timestamp_.value_or(0.0), state_.camera,
          state_.covariance.block(JointState::kCamera, JointState::kCamera)};
}

LandmarkEstimate Ekf::estimate(const FilterLandmark& landmark) const {
  const FilterAnchor& anchor = state_.anchors.at(landmark.anchor);
  const JointCovariance& P = state_.covariance;
  LandmarkBelief belief;
  belief.anchor = anchor.position;
  belief.y = landmark.y;
  belief.w = landmark.w;
  const StateBlock blocks[] = {anchor.block, landmark.block};
  belief.covariance.resize(3 + landmark.block.dim, 3 + landmark.block.dim);
  belief.covariance << P.block(blocks[0], blocks[0]), P.block(blocks[0], blocks[1]),
      P.block(blocks[1], blocks[0]), P.block(blocks[1], blocks[1]);
  return landmark_.estimate(landmark.record, belief);
}

std::vector<LandmarkEstimate> Ekf::landmarks() const {
  std::vector<LandmarkEstimate> estimates;
  for (const auto& [track, landmark] : state_.landmarks) estimates.push_back(estimate(landmark));
  return estimates;
}

}  // namespace

std::unique_ptr<Estimator> make_ekf(const Setup& setup, const ModelOptions& models,
                                    const EkfOptions& options) {
  return std::make_unique<Ekf>(setup, models, options);
}

}  // namespace slammot
