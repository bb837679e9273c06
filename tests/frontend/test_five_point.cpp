// Five-point odometry: exact without noise, the same twice, and never lost. Near the truth with
// noise: test_made_failures.cpp.
#include "frontend/odometry/five_point.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "datasets/simulation/scenario.h"
#include "eval/configuration/setup.h"
#include "frontend/odometry/two_view.h"

namespace slammot {
namespace {

Sequence static_circle(const char* noise) {
  return simulate("circle",
                  {{"frames", "60"},
                   {"static", "600"},
                   {"moving", "0"},
                   {"noise", noise},
                   {"stated_noise", "1"}},
                  7);
}

std::vector<CameraState> run(const Sequence& sequence) {
  const auto estimator = make_five_point(make_setup(sequence, Configuration{}));
  NoStages stages;
  std::vector<CameraState> cameras;
  for (const Frame& frame : sequence.frames) {
    estimator->process(frame, stages);
    const CameraEstimate camera = estimator->camera();
    EXPECT_TRUE(camera.state.position.allFinite());
    EXPECT_TRUE(camera.state.orientation.coeffs().allFinite());
    EXPECT_TRUE(camera.state.velocity.allFinite());
    EXPECT_TRUE(camera.covariance.array().isNaN().all());  // not stated
    cameras.push_back(camera.state);
  }
  return cameras;
}

TEST(TwoView, IsExactWithoutNoise) {
  const Sequence s = static_circle("0");
  for (const std::size_t first : {0u, 20u, 40u}) {
    const CameraState &a = *s.truth[first], &b = *s.truth[first + 8];
    const TrackMatches m = match_rays(rays_by_track(s.camera, s.frames[first]),
                                      rays_by_track(s.camera, s.frames[first + 8]));
    const auto pose = relative_pose(m.rays, ray_sigma(s.camera, 1.0));
    ASSERT_TRUE(pose);
    const Eigen::Quaterniond R = b.orientation.conjugate() * a.orientation;
    const Eigen::Vector3d t = b.orientation.conjugate() * (a.position - b.position);
    EXPECT_LT(Eigen::Quaterniond(pose->R).angularDistance(R), 1e-6);
    EXPECT_LT((pose->t - t.normalized()).norm(), 1e-6);
    EXPECT_EQ(pose->inliers.size(), m.tracks.size());
  }
}

std::vector<CameraState> truth(const Sequence& s) {
  std::vector<CameraState> cameras;
  for (const auto& camera : s.truth) cameras.push_back(*camera);
  return cameras;
}

// The first length is that of the stated speed, which changes: from the second key frame on the
// shape is that of the truth, and its scale one number.
constexpr std::size_t kKey = 20;
Eigen::Vector3d from_key(const std::vector<CameraState>& cameras, std::size_t i) {
  return cameras[i].position - cameras[kKey].position;
}

TEST(FivePoint, IsExactWithoutNoise) {
  const Sequence s = static_circle("0");
  const std::vector<CameraState> cameras = run(s);
  const std::size_t last = cameras.size() - 1;
  const double scale = from_key(cameras, last).norm() / from_key(truth(s), last).norm();
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    EXPECT_LT(cameras[i].orientation.angularDistance(s.truth[i]->orientation), 1e-6) << i;
    if (i <= kKey) continue;
    const Eigen::Vector3d d = from_key(cameras, i);
    EXPECT_LT((d - scale * from_key(truth(s), i)).norm(), 1e-6 * d.norm()) << i;
  }
}

TEST(FivePoint, IsTheSameTwice) {
  const Sequence s = static_circle("1");
  const std::vector<CameraState> once = run(s);
  cv::setRNGSeed(12345);
  const std::vector<CameraState> twice = run(s);
  for (std::size_t i = 0; i < once.size(); ++i) {
    EXPECT_EQ(once[i].position, twice[i].position);
    EXPECT_EQ(once[i].orientation.coeffs(), twice[i].orientation.coeffs());
  }
}

TEST(FivePoint, SurvivesWhatItCannotUse) {
  Sequence nothing = static_circle("1"), still = nothing, new_tracks = nothing, gap = nothing;
  int track = 0;
  for (std::size_t i = 0; i < nothing.frames.size(); ++i) {
    nothing.frames[i].observations.clear();
    still.frames[i].observations = still.frames[0].observations;
    if (i >= 20 && i < 23) gap.frames[i].observations.clear();
    for (Observation& z : new_tracks.frames[i].observations) z.track = ++track;
  }
  for (const Sequence* s : {&nothing, &new_tracks, &gap}) run(*s);
  EXPECT_LT(run(still).back().orientation.angularDistance(still.truth[0]->orientation), 1e-6);
}

TEST(FivePoint, RefusesTimeThatStandsStill) {
  const Sequence s = static_circle("1");
  const auto estimator = make_five_point(make_setup(s, Configuration{}));
  NoStages stages;
  estimator->process(s.frames[0], stages);
  EXPECT_THROW(estimator->process(s.frames[0], stages), std::invalid_argument);
}

}  // namespace
}  // namespace slammot
