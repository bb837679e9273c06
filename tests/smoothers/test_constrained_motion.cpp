// The motion of a static landmark, constrained to zero in the window (constrained_motion.cpp).
#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "datasets/simulation/scenario.h"
#include "tests/smoothers/fixture/looped_window.h"

namespace slammot {
namespace {

class WindowOf {
 public:
  WindowOf(const Sequence& sequence, int frames) : run_(sequence, of(frames)) {
    for (const Frame& frame : sequence.frames) run_.process(frame);
  }

  // Of those that a classifier has found static by this frame.
  std::map<int, MotionBelief> constrained_since(int frame) {
    std::vector<int> tracks;
    for (const auto& [track, record] : run_.loop->records()) {
      const bool is_old = record.decision_frame && *record.decision_frame <= frame;
      if (record.label == Label::kStatic && is_old) tracks.push_back(track);
    }
    std::vector<MotionBelief> motions;
    run_.window->constrained_motions(tracks, motions);
    std::map<int, MotionBelief> result;
    for (const MotionBelief& motion : motions) result[motion.track] = motion;
    return result;
  }

 private:
  static Configuration of(int frames) {
    Configuration configuration;
    configuration.window.frames = frames;
    return configuration;
  }

  LoopedWindow run_;
};

TEST(ConstrainedMotion, IsKnownAsWellAsIfNothingHadLeftIt) {
  constexpr int kEnd = 40, kShort = 8;
  const Sequence sequence = simulate("circle", {{"frames", std::to_string(kEnd)}}, 3);
  WindowOf whole(sequence, kEnd), window(sequence, kShort);
  int compared = 0;
  const auto expected = whole.constrained_since(kEnd - 2 * kShort);
  for (const auto& [track, motion] : window.constrained_since(kEnd - 2 * kShort)) {
    if (!expected.contains(track)) continue;
    const MotionBelief& all = expected.at(track);
    const Eigen::LLT<Eigen::MatrixXd> P(all.covariance);
    const Eigen::VectorXd difference = P.matrixL().solve(Eigen::VectorXd(motion.w - all.w));
    EXPECT_LT(difference.norm(), 0.5) << track;  // [sigma]
    const double ratio = std::cbrt(motion.covariance.determinant() / all.covariance.determinant());
    EXPECT_NEAR(ratio, 1.0, 0.1) << track;
    ++compared;
  }
  EXPECT_GE(compared, 5);
}

}  // namespace
}  // namespace slammot
