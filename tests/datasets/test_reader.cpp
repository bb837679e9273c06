// Reading the native format: what stands where, truth, the hash, a long sequence.
#include <gtest/gtest.h>

#include <chrono>

#include "datasets/native/native_reader.h"
#include "datasets/native/native_writer.h"
#include "datasets/readers/reader.h"
#include "datasets/sequence/sha256.h"
#include "tests/datasets/fixture.h"

namespace slammot {
namespace {

TEST(NativeReader, ReadsEverything) {
  test::TemporaryFolder folder;
  test::write_good(folder.path());
  const Sequence s = read_sequence(folder.path());
  EXPECT_EQ(s.name, "small");
  EXPECT_EQ(lens_name(s.camera.lens), "radtan");
  EXPECT_EQ(lens_distortion(s.camera.lens)[1], 0.2);
  EXPECT_EQ(s.camera.fy, 171.0);
  EXPECT_EQ(s.pixel_sigma, 1.5);
  EXPECT_EQ(s.motion->angular_acceleration, 5.0);
  EXPECT_EQ(s.prior->inverse_depth_sigma, 0.15);
  EXPECT_EQ(s.prior->acceleration, 1.0);  // not stated: the default
  ASSERT_EQ(s.frames.size(), 3u);
  ASSERT_EQ(s.frames[0].observations.size(), 2u);
  EXPECT_EQ(s.frames[0].observations[0].track, 3);  // sorted
  EXPECT_EQ(s.frames[0].observations[0].pixel, Eigen::Vector2d(3.5, 4.0));
  EXPECT_TRUE(s.frames[1].observations.empty());
  EXPECT_EQ(s.landmarks.at(5).at(1)->position, Eigen::Vector3d(1, 2, 4));
  EXPECT_EQ(s.landmarks.at(5).at(2), nullptr);
  EXPECT_EQ(s.landmarks.at(3).at(2)->position, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(s.known.at(0).sigma, 0.001);
  EXPECT_EQ(s.initial->state.velocity, Eigen::Vector3d(0, 0, 0.5));
  EXPECT_EQ(s.initial->angular_velocity_sigma, 0.2);
  EXPECT_TRUE(s.exact_truth);
}

TEST(NativeReader, MatchesTruthWithinHalfAFrame) {
  test::TemporaryFolder folder;
  test::write_good(folder.path());
  const Sequence s = read_native(folder.path());
  ASSERT_EQ(s.truth.size(), 3u);
  EXPECT_EQ(s.truth[1]->position.x(), 1.0);
  EXPECT_NEAR(s.truth[1]->velocity.x(), 10.0, 1e-9);
  EXPECT_FALSE(s.truth[2]);  // 0.06 s away
}

TEST(NativeReader, OptionalFilesMayBeAbsent) {
  test::TemporaryFolder folder;
  for (const char* name : {"sequence.yaml", "frames.csv", "observations.csv"}) {
    test::write_text(folder.path() / name, test::kGood.at(name));
  }
  const Sequence s = read_native(folder.path());
  EXPECT_TRUE(s.truth.empty());
  EXPECT_FALSE(s.initial);
  EXPECT_FALSE(s.exact_truth);
}

TEST(NativeReader, HashesTheFilesInTheOrderOfTheFormat) {
  test::TemporaryFolder folder;
  test::write_good(folder.path());
  Sha256 hash;
  for (const char* name : {"sequence.yaml", "frames.csv", "observations.csv", "groundtruth.tum",
                           "landmarks.csv", "known.csv", "initial.yaml"}) {
    hash.add(test::kGood.at(name));
  }
  EXPECT_EQ(read_native(folder.path()).sha256, hash.hex());
}

TEST(NativeReader, ReadsALongSequenceFast) {
  test::TemporaryFolder folder;
  Sequence s;
  s.name = "long";
  s.camera.fx = s.camera.fy = 100.0;
  for (int i = 0; i < 20000; ++i) {
    Frame frame{i, i / 15.0, {}};
    for (int track = 0; track < 30; ++track)
      frame.observations.push_back({track, {i % 600 + 1.0 / 7.0, 2.5}});
    s.frames.push_back(frame);
  }
  write_native(s, folder.path());
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(read_native(folder.path()).frames.back().observations.size(), 30u);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
  RecordProperty("seconds", std::to_string(seconds.count()));
  EXPECT_LT(seconds.count(), 20.0);  // about 0.1 in a release build
}

TEST(Readers, TableNamesAndDescribes) {
  ASSERT_GE(reader_table().size(), 2u);
  for (const ReaderRow& row : reader_table()) {
    EXPECT_FALSE(row.name.empty());
    EXPECT_FALSE(row.description.empty());
  }
}

}  // namespace
}  // namespace slammot
