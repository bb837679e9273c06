// Times the stages of one frame from outside the estimator, on the steady clock.
#pragma once

#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "estimation/estimator.h"

namespace slammot {

// Construct when the frame begins, call finish() when it ends. A stage that begins twice is one
// stage.
class StageClock : public StageListener {
 public:
  StageClock() : frame_start_(Clock::now()), stage_start_(frame_start_) {}

  void begin(std::string_view stage) override {
    close_stage();
    for (current_ = 0; current_ < stages_.size(); ++current_) {
      if (stages_[current_].first == stage) return;
    }
    stages_.emplace_back(stage, 0.0);
  }

  // The stages in the order of their first beginning, then `total`: the whole frame but
  // kPredictions. [ms]
  std::vector<std::pair<std::string, double>> finish() {
    close_stage();
    double total = milliseconds(frame_start_, stage_start_);
    for (const auto& [stage, time] : stages_) {
      if (stage == kPredictions) total -= time;
    }
    stages_.emplace_back("total", total);
    return std::move(stages_);
  }

 private:
  using Clock = std::chrono::steady_clock;

  static double milliseconds(Clock::time_point from, Clock::time_point to) {
    return std::chrono::duration<double, std::milli>(to - from).count();
  }

  void close_stage() {
    const Clock::time_point now = Clock::now();
    if (current_ < stages_.size()) stages_[current_].second += milliseconds(stage_start_, now);
    stage_start_ = now;
  }

  Clock::time_point frame_start_;
  Clock::time_point stage_start_;
  std::vector<std::pair<std::string, double>> stages_;
  size_t current_ = 0;
};

}  // namespace slammot
