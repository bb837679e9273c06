// Rigs of cameras, and depths: what is written is read back, what is refused, and what a simulated
// second camera sees.
#include <gtest/gtest.h>

#include "datasets/native/native_reader.h"
#include "datasets/native/native_writer.h"
#include "datasets/readers/image_reader.h"
#include "datasets/simulation/scenario.h"
#include "tests/datasets/fixture.h"

namespace slammot {
namespace {

const ScenarioOverrides kRig = {
    {"frames", "20"}, {"stereo", "0.4"}, {"depth_sigma", "0.05"}, {"noise", "0"}};

TEST(Rigs, AreReadAsTheyWereWritten) {
  const test::TemporaryFolder folder;
  Sequence written = simulate("circle", kRig, 3);
  written.other_cameras[0].R = exp_so3<double>({0.01, 0.02, 0.03});
  write_native(written, folder.path());
  const Sequence read = read_native(folder.path());
  ASSERT_EQ(read.other_cameras.size(), 1u);
  EXPECT_EQ(read.other_cameras[0].t, written.other_cameras[0].t);
  EXPECT_LT(read.other_cameras[0].R.angularDistance(written.other_cameras[0].R), 1e-12);
  EXPECT_EQ(read.other_cameras[0].lens.fx, written.camera.fx);
  int depths = 0;
  for (std::size_t i = 0; i < read.frames.size(); ++i) {
    const Frame &a = written.frames[i], &b = read.frames[i];
    ASSERT_EQ(a.other_views.size(), b.other_views.size());
    for (std::size_t k = 0; k < a.other_views.size(); ++k) {
      EXPECT_TRUE(is_same_view(a.other_views[k], b.other_views[k]));
      EXPECT_EQ(a.other_views[k].pixel, b.other_views[k].pixel);
    }
    for (std::size_t k = 0; k < a.observations.size(); ++k) {
      EXPECT_EQ(a.observations[k].depth, b.observations[k].depth);
      EXPECT_EQ(a.observations[k].depth_sigma, b.observations[k].depth_sigma);
      depths += b.observations[k].has_depth() ? 1 : 0;
    }
  }
  EXPECT_GT(depths, 20);
  EXPECT_TRUE(measures_scale(read));
}

// Without noise: of one row, and as far apart as the depth says.
TEST(Rigs, ASimulatedSecondCameraStandsToTheRight) {
  const Sequence s = simulate("square", kRig, 4);
  int seen = 0;
  for (std::size_t i = 0; i < s.frames.size(); ++i) {
    for (const Observation& right : s.frames[i].other_views) {
      const auto left =
          std::ranges::find(s.frames[i].observations, right.track, &Observation::track);
      ASSERT_NE(left, s.frames[i].observations.end());
      const TruePoint& point = *s.landmarks.at(right.track).at(s.frames[i].index);
      const CameraState& camera = *s.truth[i];
      const double depth =
          (camera.orientation.conjugate() * (point.position - camera.position)).z();
      EXPECT_NEAR(left->pixel.y(), right.pixel.y(), 1e-9);
      EXPECT_NEAR(left->pixel.x() - right.pixel.x(), s.camera.fx * 0.4 / depth, 1e-9);
      ++seen;
    }
  }
  EXPECT_GT(seen, 100);
}

// Camera 0 measures the same with a second one beside it and without.
TEST(Rigs, ChangeNothingOfTheFirstCamera) {
  for (const char* scenario : {"circle", "model_matched"}) {
    const Sequence one = simulate(scenario, {{"frames", "20"}}, 3);
    const Sequence two = simulate(scenario, {{"frames", "20"}, {"stereo", "0.4"}}, 3);
    for (std::size_t i = 0; i < one.frames.size(); ++i) {
      ASSERT_EQ(one.frames[i].observations.size(), two.frames[i].observations.size());
      for (std::size_t k = 0; k < one.frames[i].observations.size(); ++k) {
        EXPECT_EQ(one.frames[i].observations[k].pixel, two.frames[i].observations[k].pixel);
      }
    }
  }
}

constexpr char kCamera[] =
    "{model: pinhole, width: 320, height: 240, fx: 170, fy: 171, cx: 160, cy: 120";

std::string settings(const std::string& second) {
  return std::string("format: slammot-sequence-1\nname: small\ncameras:\n  - ") + kCamera +
         "}\n  - " + second + "\npixel_sigma: 1.5\n";
}

std::string mounted(const std::string& pose) {
  return std::string(kCamera) + ", T_C0_C: {" + pose + "}}";
}

constexpr char kGoodPose[] = "position: [0.5, 0, 0], quaternion: [0, 0, 0, 1]";

// Settings, observations, and what is said behind the folder.
struct BadRig {
  std::string settings, observations, reason;
};

TEST(Rigs, BadOnesAreRefused) {
  const std::string good = settings(mounted(kGoodPose));
  const std::string row = "frame,track,u,v,camera\n0,3,3.5,4,0\n";
  const std::string depths = "frame,track,u,v,depth,depth_sigma\n";
  const BadRig bad[] = {
      {settings(mounted("position: [0, 0, 0], quaternion: [0, 0, 0, 1]")), row,
       "sequence.yaml:5: cameras 0 and 1 stand at the same place"},
      {settings(mounted("position: [0.5, 0, 0], quaternion: [0, 0, 0, 0]")), row,
       "sequence.yaml:5: the quaternion has length zero"},
      {settings(std::string(kCamera) + "}"), row, "sequence.yaml:5: 'T_C0_C' is missing"},
      {settings("{model: pinhole, width: 321, height: 240, fx: 170, fy: 171, cx: 160, cy: 120, "
                "T_C0_C: {position: [0.5, 0, 0], quaternion: [0, 0, 0, 1]}}"),
       row, "sequence.yaml:5: camera 1 has 321x240 pixels, camera 0 320x240"},
      {good, row + "0,3,3.5,4,2\n",
       "observations.csv:3: camera 2 does not exist (sequence.yaml ends at 1)"},
      {good, row + "0,3,3.5,4,1\n0,3,8,4,1\n",
       "observations.csv:4: track 3 stands twice in frame 0 of camera 1 (first in line 3)"},
      {good, row + "0,3,3.5,4,-1\n", "observations.csv:3: '-1' is negative"},
      {good, depths + "0,3,3.5,4,0.01,0.1\n", "observations.csv:2: a depth is 0.05 to 1000 m"},
      {good, depths + "0,3,3.5,4,2000,0.1\n", "observations.csv:2: a depth is 0.05 to 1000 m"},
      {good, depths + "0,3,3.5,4,2,0\n", "observations.csv:2: the sigma of a depth is above zero"},
      {good, depths + "0,3,3.5,4,2,\n", "observations.csv:2: '' is not a number"},
      {good, "frame,track,u,v,camera,depth,depth_sigma\n0,3,3.5,4,1,2,0.1\n",
       "observations.csv:2: a depth is that of camera 0"},
      {good, "frame,track,u,v,depth\n", "observations.csv:1: the first line must be"},
  };
  test::TemporaryFolder folder;
  test::write_good(folder.path());
  for (const BadRig& rig : bad) {
    test::write_text(folder.path() / "sequence.yaml", rig.settings);
    test::write_text(folder.path() / "observations.csv", rig.observations);
    const std::string said = test::refusal_of([&] { read_native(folder.path()); });
    EXPECT_EQ(said.find((folder.path() / rig.reason).string()), 0u) << said;
  }
  test::write_text(folder.path() / "sequence.yaml", good);
  test::write_text(folder.path() / "observations.csv", row + "0,3,1,4,1\n");
  EXPECT_EQ(read_native(folder.path()).frames[0].other_views.size(), 1u);
}

// As in frames.csv the name is the rest of the line; frames may have none.
TEST(Rigs, NameTheImagesOfTheOtherCameras) {
  test::TemporaryFolder folder;
  test::write_good(folder.path());
  test::write_text(folder.path() / "sequence.yaml", settings(mounted(kGoodPose)));
  test::write_text(folder.path() / "frames.csv",
                   "frame,timestamp,image\n0,0,a.png\n1,0.1,b.png\n2,0.2,c.png\n");
  const auto read = [&](const std::string& rows) {
    test::write_text(folder.path() / "other_images.csv", "frame,camera,image\n" + rows);
    Sequence images = read_images(folder.path());
    EXPECT_TRUE(images.other_images.empty());  // of camera 0 until asked for
    add_other_images(images);
    EXPECT_EQ(images.other_images, read_native(folder.path()).other_images);
    return images.other_images;
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(read("2,1,right/c, d.png\n0,1,a.png\n"),
            (std::vector<Names>{{"a.png", "", "right/c, d.png"}}));
  const std::pair<const char*, const char*> bad[] = {
      {"0,0,a.png\n", "2: the images of camera 0 stand in frames.csv"},
      {"0,2,a.png\n", "2: camera 2 does not exist (sequence.yaml ends at 1)"},
      {"3,1,a.png\n", "2: frame 3 does not exist (frames.csv ends at 2)"},
      {"0,1,a.png\n0,1,b.png\n", "3: frame 0 has a second image of camera 1"},
      {"0,1,\n", "2: names no image"}};
  for (const auto& [rows, reason] : bad) {
    EXPECT_EQ(test::refusal_of([&] { read(rows); }),
              (folder.path() / "other_images.csv").string() + ":" + reason);
  }
}

}  // namespace
}  // namespace slammot
