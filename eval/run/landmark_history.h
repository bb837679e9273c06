// Follows the landmarks of an estimator over the frames: the latest estimate of each, also after
// it has left the state, what was known when it was classified, and its errors.
#pragma once

#include <map>
#include <vector>

#include "datasets/sequence/sequence.h"
#include "eval/result/run_result.h"

namespace slammot {

class LandmarkHistory {
 public:
  explicit LandmarkHistory(const Sequence& sequence) : sequence_(sequence) {}

  // The landmarks in the state after `frame`. A track that was pruned and initialised again
  // replaces the landmark it was before.
  void add(int frame, const std::vector<LandmarkEstimate>& landmarks);

  // The final estimates of landmarks that leave the state in this frame; before add().
  void retire(int frame, const std::vector<LandmarkEstimate>& landmarks);

  // All landmarks once more, after smoothing: they replace the estimates, but are no new samples.
  void revise(int frame, const std::vector<LandmarkEstimate>& landmarks);

  // By track. Of a landmark that is gone it is the estimate after its newest measurement: what
  // follows until it is removed is extrapolation, into frames that may have no true position.
  std::vector<LandmarkRecord> latest() const;
  std::vector<ClassificationRecord> classification() const;  // by track
  const std::vector<LandmarkSample>& samples() const { return samples_; }

 private:
  struct Entry {
    bool gone = false;
    LandmarkRecord record;    // the newest
    LandmarkRecord measured;  // after its newest measurement
    int observations_at_decision = 0;
  };

  void remember(int frame, const LandmarkEstimate& landmark);
  void sample(int frame, const LandmarkEstimate& landmark);

  const Sequence& sequence_;
  int newest_frame_ = 0;
  std::map<int, Entry> entries_;
  std::vector<LandmarkSample> samples_;
};

}  // namespace slammot
