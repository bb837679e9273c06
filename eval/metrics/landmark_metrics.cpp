#include "eval/metrics/landmark_metrics.h"

#include <cmath>
#include <set>

#include "eval/statistics/statistics.h"

namespace slammot {
namespace {

struct Samples {
  std::vector<double> static_position, moving_position, moving_velocity;
  std::vector<double> position_nees, velocity_nees;
};

ErrorSummary summarise(const std::vector<double>& errors) {
  return {static_cast<int>(errors.size()), root_mean_square(errors), median(errors),
          quantile(errors, 0.95)};
}

void add_defined(double value, std::vector<double>& samples) {
  if (!std::isnan(value)) samples.push_back(value);
}

void add(const LandmarkEstimate& estimate, const TruePoint& truth, Label label, Samples& samples) {
  const Eigen::Vector3d position_error = truth.position - estimate.position;
  const Eigen::Vector3d velocity_error = truth.velocity - estimate.velocity;
  const bool moves = label == Label::kMoving;
  if (!position_error.hasNaN()) {
    (moves ? samples.moving_position : samples.static_position).push_back(position_error.norm());
  }
  if (moves && !velocity_error.hasNaN()) {
    samples.moving_velocity.push_back(velocity_error.norm());
  }
  add_defined(nees_if_defined(position_error, estimate.position_covariance), samples.position_nees);
  add_defined(nees_if_defined(velocity_error, estimate.velocity_covariance), samples.velocity_nees);
}

}  // namespace

LandmarkMetrics landmark_metrics(const Sequence& sequence,
                                 const std::vector<LandmarkRecord>& landmarks) {
  std::set<int> known;
  for (const KnownLandmark& landmark : sequence.known) known.insert(landmark.track);
  Samples samples;
  for (const LandmarkRecord& record : landmarks) {
    const auto truth = sequence.landmarks.find(record.estimate.track);
    if (truth == sequence.landmarks.end() || known.contains(record.estimate.track)) continue;
    const TruePoint* point = truth->second.at(record.frame);
    if (point != nullptr) add(record.estimate, *point, truth->second.label, samples);
  }
  return {{summarise(samples.static_position), summarise(samples.moving_position),
           summarise(samples.moving_velocity)},
          {summarise_nees(samples.position_nees, 3), summarise_nees(samples.velocity_nees, 3)}};
}

}  // namespace slammot
