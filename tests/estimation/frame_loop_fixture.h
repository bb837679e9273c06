// A frame loop over a belief that is told what to say.
#pragma once

#include <gtest/gtest.h>

#include "estimation/loop/frame_loop.h"
#include "tests/estimation/fake_belief.h"

namespace slammot::test {

class FrameLoopOf : public testing::Test {
 protected:
  FrameLoopOf() {
    setup_.camera.fx = setup_.camera.fy = 400.0;
    setup_.camera.cx = 320.0;
    setup_.camera.cy = 240.0;
  }

  // Landmarks of the first frame are static by rule.
  void start(ModelOptions models) {
    models.labels.first_frame = FirstFrameLabels::kStatic;
    models.labels.sightings = 2;
    start_with(models);
  }
  void start_with(const ModelOptions& models) {
    const auto make = [this] {
      auto belief = std::make_unique<FakeBelief>(calls_);
      belief->remembers_all = remembers_all_;
      belief_ = belief.get();
      return belief;
    };
    loop_ = std::make_unique<FrameLoop>(setup_, models, make);
  }

  FrameReport frame(std::vector<int> tracks) {
    Frame frame{index_, 0.1 * index_, {}};
    ++index_;
    for (const int track : tracks) frame.observations.push_back({track, {320.0, 240.0}});
    calls_.clear();
    return loop_->process(frame, stages_);
  }

  Label label(int track) const { return loop_->records().at(track).label; }

  slammot::Setup setup_;
  std::vector<std::string> calls_;
  FakeBelief* belief_ = nullptr;
  std::unique_ptr<FrameLoop> loop_;
  NoStages stages_;
  int index_ = 0;
  bool remembers_all_ = false;
};

}  // namespace slammot::test
