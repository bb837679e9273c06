// What the frames cost: milliseconds per stage and in all, frames a second, and the state's size.
#pragma once

#include <string>
#include <vector>

#include "eval/result/run_result.h"

namespace slammot {

struct StageCost {
  std::string stage;
  double median_ms = 0.0;
  double p95_ms = 0.0;
  double total_ms = 0.0;  // over all frames
};

struct RuntimeMetrics {
  std::vector<StageCost> stages;  // in order of first appearance; the last is `total`
  double frame_median_ms = 0.0;   // of a batch with its share of the smoothing
  double frame_p95_ms = 0.0;
  double frames_per_second = 0.0;  // with the smoothing after the last frame
  double smoothing_ms = 0.0;
  double state_size_median = 0.0;
  double state_size_max = 0.0;
};

// `batch`: the smoothing after the last frame is what makes its result (RunResult::batch). It is a
// stage then, `solution`, of which each frame has the same share.
RuntimeMetrics runtime_metrics(const std::vector<StageTime>& timing, double smoothing_ms,
                               bool batch);

}  // namespace slammot
