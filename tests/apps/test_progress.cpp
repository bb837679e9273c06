// What a long command says meanwhile, where stderr is no terminal, as in these tests.
#include <gtest/gtest.h>

#include "apps/support/progress.h"

namespace slammot {
namespace {

using namespace std::chrono_literals;

std::string said(const std::vector<std::chrono::seconds>& times) {
  const Progress::Clock::time_point start{};
  testing::internal::CaptureStderr();
  Progress progress;
  int done = 0;
  for (const auto t : times) progress.show("ekf", 10 * ++done, 100, "", start + t);
  progress.clear();
  return testing::internal::GetCapturedStderr();
}

TEST(Progress, ALineAMinuteWhereItIsRedirected) {
  EXPECT_EQ(said({0s, 10s, 59s}), "");
  EXPECT_EQ(said({0s, 30s, 60s, 90s, 119s}), "ekf: frame 30 of 100, 0.33 frames/s, 210 s left\n");
  EXPECT_EQ(said({0s, 60s, 121s}),
            "ekf: frame 20 of 100, 0.17 frames/s, 480 s left\n"
            "ekf: frame 30 of 100, 0.17 frames/s, 424 s left\n");
}

TEST(Progress, ManyShortRunsAreALineAMinuteToo) {
  testing::internal::CaptureStderr();
  Progress progress;
  const Progress::Clock::time_point start{};
  int second = 0;
  for (const char* label : {"a (run 1 of 3)", "b (run 2 of 3)", "c (run 3 of 3)"}) {
    for (const int done : {1, 40, 80}) {
      progress.show(label, done, 80, "", start + std::chrono::seconds(second += 10));
    }
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "c (run 3 of 3): frame 40 of 80, 3.9 frames/s, 10 s left\n");
}

TEST(Progress, OfRunsHasThePartsDone) {
  testing::internal::CaptureStderr();
  Progress progress("run", "runs");
  const Progress::Clock::time_point start{};
  progress.show("s", 2.0, 80, "", start);
  progress.show("s", 2.5, 80, ", frame 300 of 600", start + 61s);
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "s: run 2 of 80, frame 300 of 600, 0.0082 runs/s, 9455 s left\n");
}

}  // namespace
}  // namespace slammot
