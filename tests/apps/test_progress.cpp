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
  for (const auto t : times) progress.show("ekf", 10 * ++done, 100, start + t);
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

}  // namespace
}  // namespace slammot
