// The rendered basement: a loop that closes and a person who passes three times; and what both
// rendered scenarios promise.
#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/core.hpp>

#include "datasets/readers/image_reader.h"
#include "frontend/rendering/render.h"
#include "frontend/rendering/rendered_scenario.h"
#include "frontend/tracking/track_images.h"

namespace slammot {
namespace {

constexpr double kStep = 1e-5;  // [s]

TEST(Basement, VelocitiesAreThoseOfThePath) {
  const Room room(basement_options(), 3);
  for (double time = 1.0; time < 137.0; time += 4.7) {
    const CameraState before = room.camera_at(time - kStep), at = room.camera_at(time),
                      after = room.camera_at(time + kStep);
    const Eigen::Vector3d v = (after.position - before.position) / (2.0 * kStep);
    const Eigen::Vector3d omega =
        log_so3(before.orientation.conjugate() * after.orientation) / (2.0 * kStep);
    EXPECT_LT((v - at.velocity).norm(), 1e-7) << time;
    EXPECT_LT((omega - at.angular_velocity).norm(), 1e-7) << time;
  }
}

TEST(Basement, TheLoopIsClosedAndPassesItsStart) {
  const RoomOptions options = basement_options();
  const Room room(options, 3);
  const CameraState start = room.camera_at(0.0);
  double nearest = 100.0;
  for (int frame = options.frames / 2; frame < options.frames; ++frame) {
    const CameraState at = room.camera_at(frame / options.rate);
    nearest = std::min(nearest, (at.position - start.position).norm() +
                                    at.orientation.angularDistance(start.orientation));
  }
  EXPECT_LT(nearest, 0.02);
  EXPECT_GT((room.camera_at(60.0).position - start.position).norm(), 4.0);
}

// Pixels of a coarse grid whose rays meet a body.
std::vector<Eigen::Vector2d> pixels_on_person(const Room& room, const RoomOptions& options,
                                              int frame) {
  const Camera camera = room.camera();
  const double time = frame / options.rate;
  const CameraState at = room.camera_at(time);
  std::vector<Eigen::Vector2d> pixels;
  for (int v = 4; v < camera.height; v += 8) {
    for (int u = 4; u < camera.width; u += 8) {
      const Eigen::Vector3d ray = at.orientation * camera.unproject(Eigen::Vector2d(u, v))->ray;
      if (room.cast(at.position, ray, time).box->moves()) pixels.emplace_back(u, v);
    }
  }
  return pixels;
}

// It comes into view at the image's edge, and leaves there.
TEST(Basement, ThePersonPassesThreeTimesAndWalksIntoTheImage) {
  const RoomOptions options = basement_options();
  const Room room(options, 2);
  const auto seen = [&](int frame) { return pixels_on_person(room, options, frame); };
  const double middle = room.camera().width / 2.0;
  int passages = 0;
  bool is_seen = false;
  for (int frame = 0; frame < options.frames; frame += 6) {
    if (seen(frame).empty() != is_seen) continue;
    is_seen = !is_seen;
    passages += is_seen ? 1 : 0;
    int first = frame;  // in which it is so
    while (first > 0 && seen(first - 1).empty() != is_seen) --first;
    for (const Eigen::Vector2d& pixel : seen(is_seen ? first : first - 1)) {
      EXPECT_GT(std::abs(pixel.x() - middle), 0.8 * middle) << "frame " << first;
    }
  }
  EXPECT_EQ(passages, 3);
  for (const int frame : {330, 950, 1350}) EXPECT_GT(seen(frame).size(), 50u) << frame;
}

// Of the same pixels: nothing but the first pose and four points. That tracks are where truth says:
// test_rendered.cpp.
TEST(RenderedScenarios, DependOnTheirSeedAndMayStateTheScaleOnly) {
  for (const ScenarioRow& row : rendered_scenarios()) {
    SCOPED_TRACE(row.name);
    ScenarioOverrides small{{"frames", "4"}, {"width", "240"}, {"height", "180"}};
    const Sequence all = row.simulate(row.name, small, 5), other = row.simulate(row.name, small, 6);
    small.emplace("scale_only", "1");
    const Sequence scale = row.simulate(row.name, small, 5);
    EXPECT_TRUE(all.exact_truth && all.images.empty());
    EXPECT_EQ(all.known.size(), 4u);
    EXPECT_TRUE(all.motion && all.prior);
    EXPECT_FALSE(scale.motion || scale.prior);
    EXPECT_EQ(scale.known.size(), 4u);
    ASSERT_TRUE(scale.initial);
    EXPECT_EQ(scale.initial->state.position, all.initial->state.position);
    EXPECT_EQ(scale.initial->state.velocity, Eigen::Vector3d::Zero());
    EXPECT_EQ(scale.initial->velocity_sigma, InitialCamera{}.velocity_sigma);
    const auto pixel = [](const Sequence& s) -> Eigen::Vector2d {
      return s.frames.back().observations.at(0).pixel;
    };
    EXPECT_EQ(pixel(scale), pixel(all));
    EXPECT_NE(pixel(other), pixel(all));
    EXPECT_THROW(row.simulate(row.name, {{"bodys", "1"}}, 5), std::invalid_argument);
  }
}

// Camera 0 is as it is alone, and of most points the second pixel is where the truth lies. Those of
// an edge are between two surfaces.
TEST(RenderedScenarios, ASecondCameraStandsToTheRight) {
  for (const ScenarioRow& row : rendered_scenarios()) {
    SCOPED_TRACE(row.name);
    ScenarioOverrides small{{"frames", "4"}, {"width", "240"}, {"height", "180"}};
    const Sequence alone = row.simulate(row.name, small, 5);
    EXPECT_TRUE(alone.other_cameras.empty());
    small.emplace("stereo", "0.1");
    const Sequence both = row.simulate(row.name, small, 5);
    ASSERT_EQ(both.other_cameras.size(), 1u);
    EXPECT_TRUE(both.other_images.empty());
    const MountedCamera& right = both.other_cameras[0];
    EXPECT_EQ(right.t, Eigen::Vector3d(0.1, 0.0, 0.0));
    int seen = 0, near = 0;
    for (std::size_t i = 0; i < both.frames.size(); ++i) {
      const auto &a = alone.frames[i].observations, &b = both.frames[i].observations;
      ASSERT_EQ(a.size(), b.size());
      for (std::size_t k = 0; k < a.size(); ++k) EXPECT_EQ(a[k].pixel, b[k].pixel);
      const CameraState& camera = *both.truth[i];
      for (const Observation& z : both.frames[i].other_views) {
        const TruePoint& point = *both.landmarks.at(z.track).at(both.frames[i].index);
        const Eigen::Vector3d at =
            camera.orientation.conjugate() * (point.position - camera.position);
        near += (right.lens.project(right.ray(at, 1.0))->pixel - z.pixel).norm() < 0.5 ? 1 : 0;
        ++seen;
      }
    }
    EXPECT_GT(seen, 80);
    EXPECT_GT(near, 8 * seen / 10);
    EXPECT_THROW(row.simulate(row.name, {{"stereo", "20"}}, 5), std::invalid_argument);
  }
}

// `slammot simulate --render` and `slammot track` make the same of the images in files.
TEST(RenderedScenarios, AreTheSameThroughFiles) {
  const ScenarioOverrides small{
      {"frames", "4"}, {"width", "240"}, {"height", "180"}, {"stereo", "0.1"}};
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("slammot-rendered-" + std::to_string(getpid()));
  cv::setNumThreads(1);  // as in test_rendered.cpp
  TrackOptions options;
  options.threads = 1;
  for (const ScenarioRow& row : rendered_scenarios()) {
    SCOPED_TRACE(row.name);
    const bool is_basement = row.name == std::string_view("basement");
    write_room(is_basement ? basement_options() : RoomOptions{}, small, 5, folder);
    Sequence images = read_images(folder);
    add_other_images(images);
    Sequence tracked = track_images(images, options).sequence;
    add_room_truth(folder, tracked);
    std::filesystem::remove_all(folder);
    const Sequence direct = row.simulate(row.name, small, 5);
    ASSERT_EQ(tracked.frames.size(), direct.frames.size());
    for (std::size_t i = 0; i < direct.frames.size(); ++i) {
      const auto& a = tracked.frames[i].observations;
      const auto& b = direct.frames[i].observations;
      ASSERT_EQ(a.size(), b.size());
      for (std::size_t k = 0; k < a.size(); ++k) EXPECT_EQ(a[k].pixel, b[k].pixel);
      const auto &c = tracked.frames[i].other_views, &d = direct.frames[i].other_views;
      ASSERT_EQ(c.size(), d.size());
      for (std::size_t k = 0; k < c.size(); ++k) EXPECT_EQ(c[k].pixel, d[k].pixel);
    }
    ASSERT_EQ(tracked.landmarks.size(), direct.landmarks.size());
    for (const auto& [track, landmark] : direct.landmarks) {
      EXPECT_EQ(tracked.landmarks.at(track).label, landmark.label);
      EXPECT_LT((tracked.landmarks.at(track).by_frame.begin()->second.position -
                 landmark.by_frame.begin()->second.position)
                    .norm(),
                1e-9);
    }
    EXPECT_EQ(tracked.pixel_sigma, direct.pixel_sigma);
  }
  cv::setNumThreads(-1);
}

}  // namespace
}  // namespace slammot
