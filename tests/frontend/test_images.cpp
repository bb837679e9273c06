// Images as they come: the program names what is wrong in one line and ends with 2, or leaves the
// frame out and counts it; and the same measurements come from any number of threads.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "datasets/native/native_reader.h"
#include "frontend/tracking/noise.h"
#include "tests/frontend/images_fixture.h"

namespace slammot {
namespace {

TEST_F(Images, BecomeASequenceOfTheSameBytesWithAnyNumberOfThreads) {
  ASSERT_EQ(track("--threads 1"), 0) << error_;
  EXPECT_EQ(error_, "");
  const Sequence tracked = read_native(output());
  ASSERT_EQ(tracked.frames.size(), static_cast<size_t>(kCount));
  EXPECT_TRUE(std::filesystem::exists(output() / tracked.images.back()));
  EXPECT_GT(tracked.frames.back().observations.size(), 10u);
  const std::string one = test::read_text(output() / "observations.csv");
  ASSERT_EQ(track("--threads 3"), 0);
  EXPECT_EQ(test::read_text(output() / "observations.csv"), one);
}

void cut_short(const Path& image) {
  std::filesystem::resize_file(image, std::filesystem::file_size(image) / 2);
}
void make_colour(const Path& image) {
  cv::Mat colour;
  cv::cvtColor(scene(4), colour, cv::COLOR_GRAY2BGR);
  cv::imwrite(image.string(), colour);
}
void make_real(const Path& image) {
  cv::Mat real;
  scene(4).convertTo(real, CV_32F);
  cv::imwrite(image.string() + ".tiff", real);
  std::filesystem::rename(image.string() + ".tiff", image);
}
void make_narrow(const Path& image) { cv::imwrite(image.string(), scene(0).colRange(0, 100)); }

// A PNG and a JPEG that are cut short, and others: one line with the frame's file and the reason,
// exit code 2; skipped and counted when told so.
TEST_F(Images, ABadOneIsNamedOrSkippedAndCounted) {
  struct Bad {
    int frame;
    void (*spoil)(const Path& image);
    const char* reason;
  };
  for (const auto& [frame, spoil, reason] :
       {Bad{2, cut_short, "truncated"}, Bad{3, cut_short, "truncated"},
        Bad{4, [](const Path& p) { std::filesystem::remove(p); }, "frame 4 of 6 is missing"},
        Bad{1, [](const Path& p) { test::write_text(p, "this is text"); }, "no image"},
        Bad{2, make_narrow, "the image is 100x120, not 160x120"},
        Bad{2, make_real, "neither 8 nor 16 bits"},
        Bad{2, make_colour,
            "the image is colour, those before it are grey; --mixed-colours takes both"}}) {
    spoil(image(frame));
    EXPECT_EQ(track(), 2);
    EXPECT_EQ(std::count(error_.begin(), error_.end(), '\n'), 1) << error_;
    EXPECT_NE(error_.find(name(frame) + ": "), std::string::npos) << error_;
    EXPECT_NE(error_.find(reason), std::string::npos) << error_;
    EXPECT_EQ(track("--skip-bad-frames"), 0) << error_;
    EXPECT_NE(out_.find("5 frames, 1 skipped"), std::string::npos) << out_;
    EXPECT_EQ(read_native(output()).frames.size(), 5u);
    cv::imwrite(image(frame).string(), scene(2 * frame));
  }
}

TEST_F(Images, OfBothColoursOrPaddedWithZerosAreTaken) {
  make_colour(image(2));
  std::filesystem::resize_file(image(3), std::filesystem::file_size(image(3)) + 5000);
  EXPECT_EQ(track("--mixed-colours"), 0) << error_;
  EXPECT_NE(out_.find("6 frames, 0 skipped"), std::string::npos);
}

TEST_F(Images, NothingUsable) {
  for (int i = 0; i < kCount; ++i) std::filesystem::remove(image(i));
  EXPECT_EQ(track("--skip-bad-frames"), 2);
  EXPECT_NE(error_.find("no image can be read"), std::string::npos) << error_;
}

// Then the first one is the odd one out, not the others.
TEST_F(Images, MostAreOfAnotherSize) {
  make_narrow(image(0));
  test::write_text(sequence() / "sequence.yaml",
                   "format: slammot-sequence-1\nname: small\npixel_sigma: 1\ncamera: {model: "
                   "pinhole, width: 100, height: 120, fx: 100, fy: 100, cx: 49.5, cy: 59.5}\n");
  EXPECT_EQ(track("--skip-bad-frames"), 2);
  EXPECT_NE(error_.find("5 of 6 images cannot be used"), std::string::npos) << error_;
}

TEST_F(Images, OfWhichAllAreTheSame) {
  for (int i = 0; i < kCount; ++i)
    cv::imwrite(image(i).replace_extension(".png").string(), scene(0));
  std::string frames = "frame,timestamp,image\n";
  for (int i = 0; i < kCount; ++i) {
    frames += fmt::format("{},{},i/{}.png\n", i, 0.1 * i, i);
  }
  test::write_text(sequence() / "frames.csv", frames);
  ASSERT_EQ(track(), 0) << error_;
  EXPECT_EQ(read_native(output()).pixel_sigma, kLeastStated);  // measured: none
}

TEST_F(Images, AreNotReplacedByTheirMeasurements) {
  const std::string frames = test::read_text(sequence() / "frames.csv");
  EXPECT_EQ(slammot("track '" + sequence().string() + "' --output '" + sequence().string() + "'"),
            2);
  EXPECT_NE(error_.find("would replace"), std::string::npos) << error_;
  EXPECT_EQ(test::read_text(sequence() / "frames.csv"), frames);
}

TEST_F(Images, UnreadableFolder) {
  std::filesystem::remove_all(sequence());
  EXPECT_EQ(track(), 2);
  test::write_text(sequence(), "a file");
  EXPECT_EQ(track(), 2);
  EXPECT_EQ(std::count(error_.begin(), error_.end(), '\n'), 1) << error_;
}

TEST_F(Images, WhatCannotBeAskedOfThemIsRefused) {
  const std::pair<const char*, const char*> faults[] = {
      {"--chessboard 9x6,0.04", "no chessboard"},     {"--chessboard 9by6", "expected COLSxROWS"},
      {"--chessboard 9x6,inf", "expected COLSxROWS"}, {"--velocity-sigma 0.1", "no true pose"},
      {"--initial-velocity 1,2", "VX,VY,VZ"},         {"--initial-velocity 1,2,x", "VX,VY,VZ"},
      {"--initial-velocity 1,2,3,4", "VX,VY,VZ"},     {"--initial-velocity 1,2,nan", "VX,VY,VZ"}};
  for (const auto& [option, reason] : faults) {
    EXPECT_EQ(track(option), 2) << option;
    EXPECT_NE(error_.find(reason), std::string::npos) << error_;
  }
}

TEST_F(Images, AMovingStartHasNoMeasurements) {
  ASSERT_EQ(track("--moving-start"), 0) << error_;
  const Sequence tracked = read_native(output());
  EXPECT_TRUE(tracked.frames[0].observations.empty());
  EXPECT_FALSE(tracked.frames[1].observations.empty());
}

TEST_F(Images, AVelocityThatIsStated) {
  ASSERT_EQ(track("--initial-velocity 0.5,-1,2e-1 --velocity-sigma 0.3"), 0) << error_;
  const Sequence tracked = read_native(output());
  ASSERT_TRUE(tracked.initial);
  EXPECT_EQ(tracked.initial->state.velocity, Eigen::Vector3d(0.5, -1.0, 0.2));
  EXPECT_EQ(tracked.initial->velocity_sigma, 0.3);
}

TEST_F(Images, LandmarksThatAreKnown) {
  const auto known = folder_.path() / "known.csv";
  test::write_text(known, "track,x,y,z,sigma\n3,1,2,3,0.01\n");
  ASSERT_EQ(track("--known '" + known.string() + "'"), 0) << error_;
  const Sequence tracked = read_native(output());
  ASSERT_EQ(tracked.known.size(), 1u);
  EXPECT_EQ(tracked.known[0].track, 3);
  EXPECT_EQ(tracked.known[0].position, Eigen::Vector3d(1.0, 2.0, 3.0));
  test::write_text(known, "track,x,y,z,sigma\n123456,1,2,3,0.01\n");
  EXPECT_EQ(track("--force --known '" + known.string() + "'"), 2);
  EXPECT_NE(error_.find("track 123456 is measured in no image"), std::string::npos) << error_;
  test::write_text(known, "track,x,y,z,sigma\n3,1,2,3,-1\n");
  EXPECT_EQ(track("--force --known '" + known.string() + "'"), 2);
  EXPECT_NE(error_.find("known.csv:2"), std::string::npos) << error_;
}

TEST_F(Images, ARunIsDrawnOverThem) {
  ASSERT_EQ(track(), 0);
  const std::string run = "run '" + output().string() + "' --estimator ekf --force --output '" +
                          (folder_.path() / "run").string() + "' --set labels.births=static_first ";
  const std::string draw = "draw '" + (folder_.path() / "run").string() + "'";
  ASSERT_EQ(slammot(run), 0) << error_;
  EXPECT_EQ(slammot(draw), 2);
  EXPECT_NE(error_.find("every-frame"), std::string::npos) << error_;
  ASSERT_EQ(slammot(run + "--landmarks every-frame"), 0) << error_;
  ASSERT_EQ(slammot(draw), 0) << error_;
  const Path pictures = folder_.path() / "run" / "pictures";
  cv::VideoCapture film((pictures / "film.mp4").string());
  int frames = 0;
  for (cv::Mat picture; film.read(picture); ++frames) EXPECT_GT(picture.cols, 2 * 160);
  EXPECT_EQ(frames, kCount);
  const cv::Mat last = cv::imread((pictures / "frames" / "000005.png").string());
  ASSERT_FALSE(last.empty());
  // All its landmarks are static: there is blue on the grey image, and no red but in the legend.
  cv::Mat blue, red;
  const cv::Mat seen = last(cv::Rect(0, 0, 2 * 160, 2 * 120));
  cv::inRange(seen, cv::Scalar(160, 95, 0), cv::Scalar(200, 135, 20), blue);
  cv::inRange(seen, cv::Scalar(0, 75, 195), cv::Scalar(20, 115, 235), red);
  EXPECT_GT(cv::countNonZero(blue), 20);
  EXPECT_EQ(cv::countNonZero(red), 0);
}

}  // namespace
}  // namespace slammot
