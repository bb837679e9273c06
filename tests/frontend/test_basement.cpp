// The rendered basement: a loop that closes, a person who passes three times, and the way from its
// pixels to a sequence with truth; that of the rendered room as well.
#include <gtest/gtest.h>

#include <filesystem>
#include <limits>
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

TEST(Basement, ThePersonPassesThreeTimes) {
  const RoomOptions options = basement_options();
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const Room room(options, seed);
    int passages = 0;
    bool was_seen = false;
    for (int frame = 0; frame < options.frames; frame += 6) {
      const bool is_seen = !pixels_on_person(room, options, frame).empty();
      passages += is_seen && !was_seen ? 1 : 0;
      was_seen = is_seen;
    }
    EXPECT_EQ(passages, 3) << seed;
    for (const int frame : {330, 950, 1350}) {
      EXPECT_GT(pixels_on_person(room, options, frame).size(), 50u) << seed << ", " << frame;
    }
  }
}

// It comes into view at the image's edge, and leaves there.
TEST(Basement, ThePersonWalksIntoTheImage) {
  const RoomOptions options = basement_options();
  const Room room(options, 2);
  const double middle = room.camera().width / 2.0;
  std::vector<Eigen::Vector2d> before;
  for (int frame = 0; frame < options.frames; ++frame) {
    std::vector<Eigen::Vector2d> now = pixels_on_person(room, options, frame);
    if (before.empty() != now.empty()) {
      for (const Eigen::Vector2d& pixel : now.empty() ? before : now) {
        EXPECT_GT(std::abs(pixel.x() - middle), 0.8 * middle) << "frame " << frame;
      }
    }
    before = std::move(now);
  }
}

Sequence small_basement(int frames, std::uint64_t seed) {
  return rendered_scenarios().front().simulate(
      "basement",
      {{"frames", std::to_string(frames)}, {"rate", "13"}, {"width", "240"}, {"height", "180"}},
      seed);
}

// Small images, and a loop in so few that the camera moves by a quarter of a metre from one to the
// next. Truth belongs to the tracks: it is where an earlier frame saw the point.
TEST(Basement, GoesFromPixelsToASequenceWithTruth) {
  const Sequence sequence = small_basement(200, 5);
  ASSERT_EQ(sequence.frames.size(), 200u);
  EXPECT_TRUE(sequence.images.empty());
  EXPECT_TRUE(sequence.exact_truth);
  EXPECT_EQ(sequence.known.size(), 4u);
  std::vector<double> errors;
  for (std::size_t i = 1; i < 40; ++i) {
    const CameraState& camera = *sequence.truth[i];
    for (const Observation& z : sequence.frames[i].observations) {
      const TrueLandmark& landmark = sequence.landmarks.at(z.track);
      const auto& [born, state] = *landmark.by_frame.begin();
      if (landmark.label != Label::kStatic || born == sequence.frames[i].index) continue;
      const Eigen::Vector3d ray =
          camera.orientation.conjugate() * (state.position - camera.position);
      const auto projection = sequence.camera.project(ray);
      errors.push_back(projection ? (projection->pixel - z.pixel).norm()
                                  : std::numeric_limits<double>::infinity());
    }
  }
  std::ranges::sort(errors);
  ASSERT_GT(errors.size(), 100u);
  EXPECT_LT(errors[errors.size() / 2], 0.3);
}

TEST(Basement, DependsOnItsSeed) {
  const auto first_pixel = [](std::uint64_t seed) -> Eigen::Vector2d {
    return small_basement(8, seed).frames[7].observations.front().pixel;
  };
  EXPECT_EQ(first_pixel(5), first_pixel(5));
  EXPECT_NE(first_pixel(5), first_pixel(6));
}

TEST(Basement, KnowsItsParameters) {
  EXPECT_THROW(rendered_scenarios().front().simulate("basement", {{"bodys", "1"}}, 5),
               std::invalid_argument);
}

// Of the same pixels: nothing but the first pose and four points.
TEST(RenderedScenarios, MayStateTheScaleOnly) {
  for (const ScenarioRow& row : rendered_scenarios()) {
    SCOPED_TRACE(row.name);
    ScenarioOverrides small{{"frames", "4"}, {"width", "240"}, {"height", "180"}};
    const Sequence all = row.simulate(row.name, small, 5);
    small["scale_only"] = "1";
    const Sequence scale = row.simulate(row.name, small, 5);
    EXPECT_TRUE(all.motion && all.prior);
    EXPECT_FALSE(scale.motion || scale.prior);
    EXPECT_EQ(scale.known.size(), 4u);
    ASSERT_TRUE(scale.initial);
    EXPECT_EQ(scale.initial->state.position, all.initial->state.position);
    EXPECT_EQ(scale.initial->state.velocity, Eigen::Vector3d::Zero());
    EXPECT_EQ(scale.initial->velocity_sigma, InitialCamera{}.velocity_sigma);
    ASSERT_FALSE(all.frames.back().observations.empty());
    EXPECT_EQ(scale.frames.back().observations.front().pixel,
              all.frames.back().observations.front().pixel);
  }
}

// `slammot simulate --render` and `slammot track` make the same of the images in files.
TEST(RenderedScenarios, AreTheSameThroughFiles) {
  const ScenarioOverrides small{{"frames", "4"}, {"width", "240"}, {"height", "180"}};
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("slammot-rendered-" + std::to_string(getpid()));
  cv::setNumThreads(1);  // as in test_rendered.cpp
  TrackOptions options;
  options.threads = 1;
  for (const ScenarioRow& row : rendered_scenarios()) {
    SCOPED_TRACE(row.name);
    const bool is_basement = row.name == std::string_view("basement");
    write_room(is_basement ? basement_options() : RoomOptions{}, small, 5, folder);
    Sequence tracked = track_images(read_images(folder), options).sequence;
    add_room_truth(folder, tracked);
    std::filesystem::remove_all(folder);
    const Sequence direct = row.simulate(row.name, small, 5);
    ASSERT_EQ(tracked.frames.size(), direct.frames.size());
    for (std::size_t i = 0; i < direct.frames.size(); ++i) {
      const auto& a = tracked.frames[i].observations;
      const auto& b = direct.frames[i].observations;
      ASSERT_EQ(a.size(), b.size());
      for (std::size_t k = 0; k < a.size(); ++k) EXPECT_EQ(a[k].pixel, b[k].pixel);
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
