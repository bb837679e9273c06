// A metric: a function of a finished run, and its row.
#pragma once

#include <slammot/eval/metrics/metrics.h>
#include <slammot/eval/metrics/pose_pairs.h>

namespace slammot {

// Length of the estimated path over that of the true one. Noise lengthens a path, a scale that
// drifts down shortens it.
inline double path_ratio(const FinishedRun& finished) {
  double estimated = 0.0, truth = 0.0;
  const std::vector<PosePair> pairs = pair_with_truth(finished.sequence, finished.estimates);
  for (size_t i = 1; i < pairs.size(); ++i) {
    const CameraState &before = pairs[i - 1].estimate.state, &after = pairs[i].estimate.state;
    estimated += (after.position - before.position).norm();
    truth += (pairs[i].truth.position - pairs[i - 1].truth.position).norm();
  }
  return truth > 0.0 ? estimated / truth : kUndefined;
}

const Metric kPathRatio{.key = "path_ratio",
                        .unit = "",
                        .name = "path ratio",
                        .caption = "estimated over true length of the path",
                        .value = path_ratio,
                        .scope = Scope::kTrajectory,
                        .decimals = 4,
                        .better = Better::kNeither,
                        .shown = Shown::kTerminal};

}  // namespace slammot
