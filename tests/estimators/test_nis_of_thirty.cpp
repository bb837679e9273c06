// In both families: the NIS of thirty innovations is 2 where errors are new in each frame, and a
// run says so where they last, though each frame's own NIS is right.
#include <gmock/gmock.h>

#include <random>

#include "datasets/simulation/scenario.h"
#include "eval/run/run.h"

namespace slammot {
namespace {

using testing::Contains;
using testing::Field;
using testing::HasSubstr;
using testing::Not;

class NisOfThirty : public testing::TestWithParam<std::string> {
 protected:
  // Pixels of the stated sigma of 1 px, of which each keeps the share `lasting` of its track's
  // last.
  Sequence sequence(double lasting) const {
    Sequence s = simulate(
        "circle", {{"frames", "200"}, {"moving", "0"}, {"noise", "0.001"}, {"stated_noise", "1"}},
        4);
    std::mt19937 engine(8);
    std::normal_distribution<double> normal;
    std::map<int, Eigen::Vector2d> errors;
    for (Frame& frame : s.frames) {
      for (Observation& z : frame.observations) {
        const double u = normal(engine), v = normal(engine);
        const auto [error, is_first] = errors.try_emplace(z.track, u, v);
        if (!is_first) {
          error->second =
              lasting * error->second + std::sqrt(1.0 - lasting * lasting) * Eigen::Vector2d(u, v);
        }
        z.pixel += error->second;
      }
    }
    return s;
  }
};

TEST_P(NisOfThirty, IsTwoUnlessErrorsLast) {
  const auto says_so = Contains(Field(&RunWarning::reason, HasSubstr("errors last")));
  const auto nis = [](const RunResult& run) {
    EXPECT_GT(run.totals.lasting_sums, 60);
    return run.totals.lasting_nis / run.totals.lasting_sums;
  };
  const RunResult fresh = run_estimator(sequence(0.0), {}, GetParam());
  EXPECT_NEAR(nis(fresh), 2.0, 0.7);
  EXPECT_THAT(fresh.warnings, Not(says_so));
  const RunResult lasting = run_estimator(sequence(0.97), {}, GetParam());
  EXPECT_GT(nis(lasting), 4.0);
  EXPECT_THAT(lasting.warnings, says_so);
  EXPECT_LT(lasting.totals.joint_nis / lasting.totals.accepted, 2.5);
}

INSTANTIATE_TEST_SUITE_P(Families, NisOfThirty, testing::Values("ekf", "window"),
                         [](const auto& family) { return family.param; });

}  // namespace
}  // namespace slammot
