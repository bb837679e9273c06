// By how much a frame has changed the size of the world, as the past cameras in the state say.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "estimation/modules/scale_change.h"

namespace slammot {
namespace {

const Eigen::Vector3d kOrigin(3.0, -1.0, 2.0);

// Two landmarks of each of the first frames, whose camera began at the origin and has moved on.
class ScaleChangeOf : public testing::Test {
 protected:
  ScaleChangeOf() {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> step(-1.0, 1.0);
    Eigen::Vector3d anchor = kOrigin;
    for (int frame = 0; frame < 20; ++frame) {
      for (const int track : {2 * frame, 2 * frame + 1}) {
        points_.push_back({track, anchor, Eigen::Vector3d::Random()});
        records_[track] = initialised(track, frame, Label::kStatic, {});
      }
      anchor += Eigen::Vector3d(step(random), 0.2 * step(random), 1.0);
    }
    camera_ = anchor;
  }
  double next() { return change_(points_, records_, camera_); }
  void move(double scale, const Eigen::Matrix3d& turn = Eigen::Matrix3d::Identity()) {
    for (LandmarkPoint& p : points_) p.anchor = kOrigin + scale * turn * (p.anchor - kOrigin);
    camera_ = kOrigin + scale * turn * (camera_ - kOrigin);
  }

  std::vector<LandmarkPoint> points_;
  TrackRecords records_;
  Eigen::Vector3d camera_;
  ScaleChange change_{kOrigin};
};

TEST_F(ScaleChangeOf, IsThatOfAWorldThatGrows) {
  EXPECT_EQ(next(), 0.0);  // of the first frame
  for (const double t : {0.3, -1.2, 1e-6, 0.0}) {
    move(std::exp(t));
    EXPECT_NEAR(next(), t, 1e-12);
  }
}

TEST_F(ScaleChangeOf, IsNotThatOfDepthsNorOfATurn) {
  next();
  for (LandmarkPoint& p : points_) p.y *= 1.5;
  EXPECT_EQ(next(), 0.0);
  move(1.0, exp_so3(Eigen::Vector3d(0.1, -0.4, 0.2)).toRotationMatrix());
  EXPECT_NEAR(next(), 0.0, 1e-12);
}

// A track that begins anew has another anchor; what was born or has left tells nothing.
TEST_F(ScaleChangeOf, AsksOnlyCamerasThatStay) {
  next();
  move(2.0);
  for (std::size_t i = 0; i < 20; ++i) {
    records_[points_[i].track].first_frame = 100;
    points_[i].anchor.setConstant(50.0);
  }
  points_.erase(points_.begin() + 30, points_.begin() + 35);
  EXPECT_NEAR(next(), std::log(2.0), 1e-12);
}

// The first camera is where the path began but for rounding.
TEST_F(ScaleChangeOf, IsNoneWhereOnlyTheFirstCameraIsLeft) {
  points_.resize(2);
  for (LandmarkPoint& p : points_) p.anchor.x() += 1e-10;
  next();
  move(3.0);
  EXPECT_EQ(next(), 0.0);
  points_.clear();
  EXPECT_TRUE(std::isnan(next()));  // nothing tells
  EXPECT_EQ(next(), 0.0);
}

}  // namespace
}  // namespace slammot
