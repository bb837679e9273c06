#include "estimation/labels/label_policy.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace slammot {

namespace {

bool reversible(const LabelOptions& options) { return options.rule == LabelRule::kReversible; }

}  // namespace

int motion_memory(const ModelOptions& models, const LandmarkFunctions& landmark) {
  const bool is_known = models.collapse == Collapse::kCondition && landmark.motion == 3;
  return is_known && landmark.can_move && reversible(models.labels) ? models.labels.memory : 0;
}

bool watches_innovations(const LabelOptions& options) { return reversible(options); }

bool is_asked(const TrackRecord& record, const LabelOptions& options) {
  if (record.observations < options.sightings) return false;
  return record.label == Label::kUnknown || (reversible(options) && record.label == Label::kMoving);
}

void note_answer(TrackRecord& record, Label answer, int frame) {
  if (record.label == Label::kMoving && answer != Label::kStatic) return;
  note_decision(record, answer, frame);
}

void note_innovation(TrackRecord& record, double nis, const LabelOptions& options) {
  if (!reversible(options) || record.label != Label::kStatic || record.known) return;
  std::vector<double>& kept = record.static_nis;
  kept.reserve(static_cast<std::size_t>(options.window));
  if (std::ssize(kept) == options.window) kept.erase(kept.begin());
  kept.push_back(nis);
}

double moved_px(const TrackRecord& record, const Camera& camera, double dt) {
  constexpr double kNear = 2.0;  // sigmas of the inverse depth
  const LandmarkPrior& prior = record.prior;
  const double near = prior.inverse_depth + kNear * prior.inverse_depth_sigma;
  const double metres = prior.velocity_sigma() * dt * (record.unused_frames + 1);
  return std::max(camera.fx, camera.fy) * near * metres;
}

double log_tail(const TrackRecord& record) {
  const std::vector<double>& nis = record.static_nis;
  return log_chi_square_tail(std::accumulate(nis.begin(), nis.end(), 0.0),
                             static_cast<int>(nis.size()));
}

void note_depth(TrackRecord& record, const SeenDepth& depth, const LabelOptions& options) {
  constexpr double kBehind = 5.0;  // [sigma]
  if (!reversible(options) || record.known) return;
  record.is_behind = depth.inverse_depth < -kBehind * depth.sigma;
}

bool is_rejected(const TrackRecord& record, const LabelOptions& options) {
  if (record.is_behind) return true;
  if (record.static_nis.size() < 2) return false;  // a single outlier is the gate's business
  return log_tail(record) < std::log(options.probability);
}

void note_reverted(TrackRecord& record) {
  record.label = Label::kUnknown;
  record.cannot_rest = record.cannot_rest || record.is_behind;
  record.is_behind = false;
  record.decision_frame.reset();
  record.rejected_in_row = 0;
  record.static_nis.clear();
  record.classifier_memory.clear();
}

double log_chi_square_tail(double x, int n) {
  double term = 1.0, sum = 0.0;
  for (int k = 0; k < n; ++k) {
    sum += term;
    term *= 0.5 * x / (k + 1);
  }
  return -0.5 * x + std::log(sum);
}

}  // namespace slammot
