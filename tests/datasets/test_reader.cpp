// Reading the native format: what stands where, truth, the hash, a long sequence; and which of its
// frames are used.
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
  EXPECT_EQ(s.p_static, (std::map<int, double>{{3, 0.9}, {5, 0.0}}));
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

// A line of a track that the sequence does not have is no error, as in landmarks.csv; a file of
// another tracking is hinted.
TEST(NativeReader, HintsAtOddsOfTracksThatNobodyMeasures) {
  test::TemporaryFolder folder;
  test::write_good(folder.path());
  const auto hints = [&](const std::string& rows) {
    test::write_text(folder.path() / "priors.csv", "track,p_static\n" + rows);
    std::vector<std::string> found = read_native(folder.path()).hints;
    std::erase_if(found, [](const std::string& hint) { return !hint.starts_with("priors.csv"); });
    return found;
  };
  EXPECT_EQ(hints("").size(), 0u);
  EXPECT_EQ(hints("3,1\n5,1\n7,1\n").size(), 0u);
  EXPECT_EQ(
      hints("5,1\n7,1\n9,1\n"),
      std::vector<std::string>{"priors.csv: 2 of 3 tracks, as track 7, are measured in no frame"});
}

TEST(NativeReader, HashesTheFilesInTheOrderOfTheFormat) {
  test::TemporaryFolder folder;
  test::write_good(folder.path());
  Sha256 hash;
  for (const char* name : {"sequence.yaml", "frames.csv", "observations.csv", "groundtruth.tum",
                           "landmarks.csv", "known.csv", "priors.csv", "initial.yaml"}) {
    hash.add(test::kGood.at(name));
  }
  EXPECT_EQ(read_native(folder.path()).sha256, hash.hex());
}

TEST(NativeReader, ReadsALongSequenceFast) {
  test::TemporaryFolder folder;
  Sequence s;
  s.name = "long";
  s.camera.fx = s.camera.fy = 100.0;
  for (int i = 0; i < 5000; ++i) {
    Frame frame{i, i / 15.0, {}, {}};
    for (int track = 0; track < 30; ++track)
      frame.observations.push_back({track, {i % 600 + 1.0 / 7.0, 2.5}});
    s.frames.push_back(frame);
  }
  write_native(s, folder.path());
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(read_native(folder.path()).frames.back().observations.size(), 30u);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
  EXPECT_LT(seconds.count(), 5.0);  // about 0.03 in a release build
}

TEST(SelectFrames, KeepsIndicesTruthAndWhatIsStated) {
  test::TemporaryFolder folder;
  test::write_good(folder.path());
  const Sequence s = read_native(folder.path());
  const Sequence even = select_frames(s, 0, -1, 2);
  ASSERT_EQ(even.frames.size(), 2u);
  EXPECT_EQ(even.frames[1].index, 2);
  EXPECT_EQ(even.truth.size(), 2u);
  EXPECT_EQ(even.initial->state.position.z(), 1.0);
  const Sequence later = select_frames(s, 1, 1, 1);
  ASSERT_EQ(later.frames.size(), 1u);
  EXPECT_EQ(later.initial->state.position, s.truth[1]->position);
  EXPECT_EQ(later.initial->velocity_sigma, s.initial->velocity_sigma);
  EXPECT_TRUE(select_frames(s, 5, -1, 1).frames.empty());
  EXPECT_THROW(select_frames(s, 0, -1, 0), std::invalid_argument);
}

TEST(Sha256, IsThatOfTheStandardsExamples) {
  const auto of = [](std::string_view text) {
    Sha256 hash;
    hash.add(text);
    return hash.hex();
  };
  EXPECT_EQ(of(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(of("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(of(std::string(1000000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

}  // namespace
}  // namespace slammot
