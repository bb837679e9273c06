#include "eval/run/landmark_history.h"

#include <set>

#include "eval/metrics/labels/label_truth.h"
#include "eval/metrics/nees.h"

namespace slammot {

void LandmarkHistory::add(int frame, const std::vector<LandmarkEstimate>& landmarks) {
  newest_frame_ = frame;
  for (const LandmarkEstimate& landmark : landmarks) {
    remember(frame, landmark);
    if (landmark.last_frame == frame) sample(frame, landmark);
  }
}

void LandmarkHistory::retire(int frame, const std::vector<LandmarkEstimate>& landmarks) {
  for (const LandmarkEstimate& landmark : landmarks) {
    remember(frame, landmark);
    entries_[landmark.track].gone = true;
  }
}

void LandmarkHistory::revise(int frame, const std::vector<LandmarkEstimate>& landmarks) {
  for (const LandmarkEstimate& landmark : landmarks) {
    remember(landmark.state_frame.value_or(frame), landmark);
  }
}

void LandmarkHistory::remember(int frame, const LandmarkEstimate& landmark) {
  Entry& entry = entries_[landmark.track];
  const LandmarkEstimate& before = entry.record.estimate;
  const bool same_decision = before.first_frame == landmark.first_frame &&
                             before.decision_frame == landmark.decision_frame;
  if (!landmark.decision_frame || !same_decision) {
    entry.observations_at_decision = landmark.observations;
  }
  entry.gone = false;
  entry.record = {frame, landmark};
  if (landmark.last_frame == frame) entry.measured = entry.record;
}

void LandmarkHistory::sample(int frame, const LandmarkEstimate& landmark) {
  const auto truth = sequence_.landmarks.find(landmark.track);
  if (truth == sequence_.landmarks.end()) return;
  const TruePoint* point = truth->second.at(frame);
  if (point == nullptr) return;
  const Eigen::Vector3d position_error = landmark.position - point->position;
  const Eigen::Vector3d velocity_error = landmark.velocity - point->velocity;
  samples_.push_back({landmark.track, frame, landmark.observations, landmark.label,
                      truth->second.label, truth->second.label_at(frame), position_error.norm(),
                      velocity_error.norm(),
                      nees_if_defined(position_error, landmark.position_covariance),
                      nees_if_defined(velocity_error, landmark.velocity_covariance)});
}

std::vector<LandmarkRecord> LandmarkHistory::latest() const {
  std::vector<LandmarkRecord> records;
  for (const auto& [track, entry] : entries_) {
    const bool gone = entry.gone || entry.record.frame != newest_frame_;
    const bool same = entry.measured.estimate.observations > 0 &&
                      entry.measured.estimate.first_frame == entry.record.estimate.first_frame;
    records.push_back(gone && same ? entry.measured : entry.record);
  }
  return records;
}

std::vector<ClassificationRecord> LandmarkHistory::classification() const {
  std::set<int> known;
  for (const KnownLandmark& landmark : sequence_.known) known.insert(landmark.track);
  const std::map<int, Label> truths = labels_when_last_measured(sequence_, newest_frame_);
  std::vector<ClassificationRecord> records;
  for (const auto& [track, entry] : entries_) {
    const LandmarkEstimate& landmark = entry.record.estimate;
    if (landmark.by_rule || known.contains(track)) continue;
    const auto truth = truths.find(track);
    records.push_back({track, truth != truths.end() ? std::optional(truth->second) : std::nullopt,
                       landmark.label, landmark.decision_frame, entry.observations_at_decision});
  }
  return records;
}

}  // namespace slammot
