// The landmarks of the EKF: births, classification, deaths, and what is believed of them.
#include <Eigen/Cholesky>

#include "estimation/label_policy.h"
#include "estimation/landmark_estimate.h"
#include "filters/ekf_estimator.h"
#include "models/initialisation.h"
#include "models/observation.h"

namespace slammot {

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
    TrackRecord record = born(z.track, frame.index, Label::kStatic, true, setup_.prior);
    record.known = true;
    record.observations = 0;
    add(record, born_here.y, block, frame.index);
    ++report.admitted;
  }
}

// Thesis 2.1.3, (2.7): y from pixel, rotation and prior, with its full cross-covariance.
void Ekf::admit_new(const Frame& frame, FrameReport& report) {
  unmatched_.clear();
  for (const Observation& z : frame.observations) {
    if (!state_.landmarks.contains(z.track)) unmatched_.push_back(z);
  }
  const auto births =
      admit(unmatched_, static_cast<int>(state_.landmarks.size()), report.accepted, models_.policy);
  const bool first_frame = frame.index == first_frame_;
  const LandmarkPrior& prior = depth_prior_.born();
  for (const Observation& z : births) {
    const auto here = initialise(setup_.camera, state_.camera.orientation, z.pixel,
                                 state_.scene ? state_.scene->inverse_depth : prior.inverse_depth);
    if (!here) continue;
    const NewLandmark at = linearisation_.birth(state_, setup_.camera, z, frame.index, *here);
    const Label label = classifier_->at_birth(z.track, first_frame);
    anchor_here(frame.index);
    const StateBlock block = append_new(at, prior, label == Label::kStatic ? 3 : 6);
    add(born(z.track, frame.index, label, first_frame, prior), here->y, block, frame.index);
    ++report.admitted;
  }
}

// The rows of a landmark's (y) or (y, w) at its birth.
StateBlock Ekf::append_new(const NewLandmark& at, const LandmarkPrior& prior, int dim) {
  const double w_sigma = landmark_.prior_sigma(prior);
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(dim, dim);
  R.topLeftCorner<2, 2>() =
      setup_.pixel_sigma * setup_.pixel_sigma * at.J_angles_pixel * at.J_angles_pixel.transpose();
  R(2, 2) = prior.inverse_depth_sigma * prior.inverse_depth_sigma;
  R.bottomRightCorner(dim - 3, dim - 3).diagonal().setConstant(w_sigma * w_sigma);
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(dim, 3);
  J.topRows<2>() = at.J_angles_rotation;
  std::vector<JointCovariance::Dependence> on{{{kRotation, 3}, J}};
  if (state_.scene) on.push_back({state_.scene->block, Eigen::MatrixXd::Identity(dim, 3).col(2)});
  return state_.covariance.append(on, R);
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
  landmark.y_block = {block.offset, 3};
  if (block.dim > 3) landmark.w_block = {block.offset + 3, 3};
  return landmark;
}

void Ekf::note(int frame) {
  for (auto& [track, landmark] : state_.landmarks) ++landmark.record.unused_frames;
  for (const Match& m : accepted_) note_accepted(state_.landmarks.at(m.track).record, frame);
  for (const int track : gate_.rejected) note_rejected(state_.landmarks.at(track).record);
  for (const int track : out_of_view_) note_rejected(state_.landmarks.at(track).record);
}

// Before this frame's labels, as the window does, whose marginals are those of its last step.
void Ekf::learn_depths() {
  if (!depth_prior_.learns()) return;
  seen_.clear();
  for (const Match& match : accepted_) {
    const FilterLandmark& landmark = state_.landmarks.at(match.track);
    if (landmark.is_free()) continue;
    const StateBlock rho{landmark.y_block.offset + 2, 1};
    seen_.push_back({landmark.y.z(), std::sqrt(state_.covariance.block(rho, rho)(0, 0))});
  }
  depth_prior_.learn(seen_);
}

// Thesis 3.1.3, for every landmark measured in this frame whose label is open.
void Ekf::classify(int frame) {
  tracks_.clear();
  for (const Match& match : accepted_) {
    FilterLandmark& landmark = state_.landmarks.at(match.track);
    if (!is_asked(landmark.record, models_.labels)) continue;
    MotionBelief belief;
    belief.track = match.track;
    belief.w = landmark.w;
    belief.covariance = state_.covariance.block(landmark.w_block, landmark.w_block);
    belief.prior_sigma = landmark_.prior_sigma(landmark.record.prior);
    belief.density_scale = landmark_.density_scale(landmark.x());
    note_answer(landmark.record, classifier_->decide(belief), frame);
    if (landmark.record.label == Label::kStatic) tracks_.push_back(match.track);
  }
}

// (3.3). `condition` first uses w = 0 as an exact measurement: K = P[:,w] P_ww^-1.
void Ekf::collapse() {
  if (tracks_.empty()) return;
  if (models_.collapse == Collapse::kCondition) {
    const auto m = static_cast<Eigen::Index>(3 * tracks_.size());
    Eigen::MatrixXd P_w(state_.covariance.size(), m);
    Eigen::VectorXd w(m);
    std::vector<int> rows;
    for (std::size_t i = 0; i < tracks_.size(); ++i) {
      const FilterLandmark& landmark = state_.landmarks.at(tracks_[i]);
      const auto at = static_cast<Eigen::Index>(3 * i);
      state_.covariance.columns(landmark.w_block, P_w.middleCols(at, 3));
      w.segment<3>(at) = landmark.w;
      for (int k = 0; k < 3; ++k) rows.push_back(landmark.w_block.offset + k);
    }
    const Eigen::LLT<Eigen::MatrixXd> P_ww(P_w(rows, Eigen::all));
    if (P_ww.info() != Eigen::Success) throw Diverged("a velocity's covariance is not positive");
    Eigen::MatrixXd W = P_w;
    P_ww.matrixU().solveInPlace<Eigen::OnTheRight>(W);
    const Eigen::VectorXd dx = -W * P_ww.matrixL().solve(w);
    state_.covariance.subtract_outer(W);
    linearisation_.correct(state_, dx);
  }
  for (const int track : tracks_) state_.drop_motion(track);
}

void Ekf::testify() {
  if (!watches_innovations(models_.labels)) return;
  nis_given_others(innovation_, testimony_);
  for (std::size_t i = 0; i < testimony_.size(); ++i) {
    note_innovation(state_.landmarks.at(innovation_.matches[i].track).record, testimony_[i],
                    models_.labels);
  }
  for (std::size_t i = 0, k = 0; i < gate_.measured.size() && k < gate_.rejected.size(); ++i) {
    if (gate_.measured[i].track != gate_.rejected[k]) continue;
    note_innovation(state_.landmarks.at(gate_.rejected[k++]).record, gate_.nis[i], models_.labels);
  }
}

void Ekf::take_back() {
  for (const Match& match : gate_.measured) {
    TrackRecord& record = state_.landmarks.at(match.track).record;
    if (!is_rejected(record, models_.labels)) continue;
    note_freed(record);
    state_.free_motion(record.track, landmark_.prior_sigma(record.prior));
  }
}

void Ekf::retire(FrameReport& report) {
  state_.correct_far();
  tracks_.clear();
  const CameraState c = linearisation_.camera(state_);
  for (auto& [track, landmark] : state_.landmarks) {
    if (landmark.record.unused_frames > 0) {
      note_unused(landmark.record, in_view(setup_.camera, c.position, c.orientation,
                                           linearisation_.anchor(state_, landmark.anchor),
                                           linearisation_.landmark(state_, track).head<3>()));
    }
    if (!is_lost(landmark.record, models_.policy)) continue;
    tracks_.push_back(track);
    report.retired.push_back(estimate(landmark));
  }
  state_.remove_landmarks(tracks_);
}

LandmarkEstimate Ekf::estimate(const FilterLandmark& landmark) const {
  const FilterAnchor& anchor = state_.anchors.at(landmark.anchor);
  LandmarkBelief belief;
  belief.anchor = anchor.position;
  belief.y = landmark.y;
  belief.w = landmark.w;
  belief.covariance = state_.marginal(landmark);
  return landmark_estimate(landmark_, landmark.record, belief);
}

std::vector<LandmarkEstimate> Ekf::landmarks() const {
  std::vector<LandmarkEstimate> estimates;
  for (const auto& [track, landmark] : state_.landmarks) estimates.push_back(estimate(landmark));
  return estimates;
}

std::vector<LandmarkEstimate> Ekf::landmarks_measured(int index) const {
  std::vector<LandmarkEstimate> estimates;
  for (const auto& [track, landmark] : state_.landmarks) {
    if (landmark.record.last_frame == index) estimates.push_back(estimate(landmark));
  }
  return estimates;
}

}  // namespace slammot
