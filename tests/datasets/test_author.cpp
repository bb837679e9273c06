// The thesis author's format: a small file, its refusals, and synth19 against synth19_1px.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "datasets/readers/reader.h"
#include "eval/statistics/statistics.h"
#include "tests/datasets/fixture.h"
#include "tests/paths.h"

namespace slammot {
namespace {

namespace fs = std::filesystem;

fs::path shared_data() {
  const char* set = std::getenv("SLAMMOT_DATA");
  return set ? set : test::kSharedData;
}

const std::string kGood =
    "numOfFrames: 3\r\n\r\nCam Extrinsic Parameters:\r\n"
    "0, (0, 0, 0), (1, 0, 0, 0)\r\n1, (0, 0, 0.1), (1, 0, 0, 0)\r\n2, (0, 0, 0.2), (1, 0, 0, 0)\r\n"
    "\r\nPoint 9: Static\r\nPosition: (-1.5, 2, 5.5)\r\nProjections:\r\n\t0, (205, 59)\r\n"
    "\t2, (-1, -1)\r\n\r\n"
    "Point 3: Moving\r\nProjections:\r\n\t0, (1, 2, 3), (10, 11)\r\n\t1, (1, 2, 3.1), (12, 13)\r\n"
    "\t2, (1, 2, 3.4), (14, 15)\r\n\r\n";

class Author : public testing::Test {
 protected:
  Sequence read(const std::string& text) {
    test::write_text(folder_.path() / "groundTruth.txt", text);
    return read_sequence(folder_.path());
  }
  std::string refusal(const std::string& from, const std::string& to) {
    std::string text = kGood;
    text.replace(text.find(from), from.size(), to);
    const std::string reason = test::refusal_of([&] { read(text); });
    return reason.substr(reason.find("groundTruth.txt"));
  }

  test::TemporaryFolder folder_;
};

TEST_F(Author, ReadsASmallFile) {
  const Sequence s = read(kGood);
  ASSERT_EQ(s.frames.size(), 3u);
  ASSERT_EQ(s.frames[0].observations.size(), 2u);
  EXPECT_EQ(s.frames[0].observations[0].track, 3);
  EXPECT_EQ(s.frames[2].observations.size(), 1u);  // (-1, -1) is not seen
  EXPECT_NEAR((s.landmarks.at(3).at(1)->velocity - Eigen::Vector3d(0, 0, 6)).norm(), 0.0, 1e-9);
  EXPECT_NEAR(s.landmarks.at(3).at(2)->velocity.z(), 9.0, 1e-9);
  EXPECT_EQ(s.known.at(0).track, 9);
  EXPECT_FALSE(s.exact_truth);
  // Left of the author's camera is right of ours.
  EXPECT_NEAR(
      (s.truth[0]->orientation * Eigen::Vector3d::UnitX() + Eigen::Vector3d::UnitX()).norm(), 0.0,
      1e-15);
}

TEST_F(Author, Refuses) {
  EXPECT_EQ(refusal("(205, 59)", "(205, x)"), "groundTruth.txt:11: 'x' is not a number");
  EXPECT_EQ(refusal("(205, 59)", "(nan, 59)"), "groundTruth.txt:11: 'nan' is not a finite number");
  EXPECT_EQ(refusal("(205, 59)", "(205)"), "groundTruth.txt:11: expected 3 fields, found 2");
  EXPECT_EQ(refusal("Static", "Parked"),
            "groundTruth.txt:8: unknown class 'Parked' (known: Static, Moving)");
  EXPECT_EQ(refusal("\t2, (-1", "\t7, (-1"), "groundTruth.txt:12: frame 7 does not exist");
  EXPECT_EQ(refusal("\t2, (-1, -1)", "\t0, (1, 1)"),
            "groundTruth.txt:12: point 9 stands twice in frame 0");
  EXPECT_EQ(refusal("Point 3", "Point 9"), "groundTruth.txt:14: point 9 stands twice");
  EXPECT_EQ(refusal("numOfFrames: 3", "numOfFrames: 0"), "groundTruth.txt:1: there is no frame");
  EXPECT_EQ(refusal("\n1, (0,", "\n5, (0,"), "groundTruth.txt:5: frame 1 must stand here");
  EXPECT_EQ(refusal("(1, 0, 0, 0)", "(0, 0, 0, 0)"),
            "groundTruth.txt:4: the quaternion has length zero");
}

// One test, since it reads two large sequences.
TEST(Synth19, AgreesWithTheExactOne) {
  if (!fs::exists(shared_data() / "synth19") || !fs::exists(shared_data() / "synth19_1px")) {
    GTEST_SKIP() << "no " << shared_data();
  }
  const Sequence author = select_frames(read_sequence(shared_data() / "synth19"), 0, -1, 2);
  const Sequence exact = read_sequence(shared_data() / "synth19_1px");
  ASSERT_EQ(author.frames.size(), exact.frames.size());
  for (size_t i = 0; i < exact.frames.size(); ++i) {
    EXPECT_NEAR(author.frames[i].timestamp, exact.frames[i].timestamp, 1e-6);
    const auto error = boxminus(*author.truth[i], *exact.truth[i]);
    EXPECT_LT(error.head<6>().norm(), 1e-5) << i;
  }
  EXPECT_LT(boxminus(author.initial->state, exact.initial->state).norm(), 1e-12);
  EXPECT_TRUE(exact.exact_truth);
  EXPECT_FALSE(author.exact_truth);

  EXPECT_EQ(author.landmarks.size(), 214u);
  EXPECT_EQ(author.landmarks.at(9).at(0)->position, Eigen::Vector3d(-0.6, 0, 5.4));
  ASSERT_EQ(author.known.size(), 4u);
  for (size_t i = 0; i < 4; ++i) EXPECT_EQ(author.known[i].position, exact.known[i].position);
  int compared = 0;
  for (const auto& [track, landmark] : exact.landmarks) {
    const TrueLandmark& ours = author.landmarks.at(track);
    EXPECT_EQ(ours.label, landmark.label);
    for (const auto& [frame, point] : landmark.by_frame) {
      const TruePoint* other = ours.at(2 * frame);  // the exact one is numbered anew
      if (!other) continue;
      ++compared;
      EXPECT_LT((other->position - point.position).norm(), 1e-5);
      EXPECT_LT((other->velocity - point.velocity).norm(), 0.3);  // theirs are forward differences:
      const TruePoint* next = ours.at(2 * frame + 1);
      if (landmark.label == Label::kStatic || !next) continue;
      const Eigen::Vector3d forward = 30.0 * (next->position - other->position);
      EXPECT_LT((forward - point.velocity).norm(), 1e-3);
    }
  }
  EXPECT_GT(compared, 1000);

  std::vector<double> errors;  // of static points, as published
  for (size_t i = 0; i < author.frames.size(); ++i) {
    for (const Observation& z : author.frames[i].observations) {
      if (author.landmarks.at(z.track).label != Label::kStatic) continue;
      const auto pixel = test::true_pixel(author, i, z.track);
      ASSERT_TRUE(pixel);
      errors.push_back((*pixel - z.pixel).norm());
    }
  }
  EXPECT_NEAR(median(errors), 1.8, 0.1);
}

}  // namespace
}  // namespace slammot
