// What is not a sequence yet: images of 16 bits, plain folders, films, and how well it was tracked.
#include <fmt/format.h>

#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "datasets/native/native_reader.h"
#include "tests/frontend/images_fixture.h"

namespace slammot {
namespace {

using Sources = Images;

// The low byte is anything.
void write_16_bits(const Path& image, int shift, int channels = 1) {
  cv::Mat deep, noise(120, 160, CV_16U);
  scene(shift).convertTo(deep, CV_16U, 256.0);
  cv::randu(noise, 0, 256);
  deep += noise;
  if (channels > 1)
    cv::cvtColor(deep, deep, channels == 3 ? cv::COLOR_GRAY2BGR : cv::COLOR_GRAY2BGRA);
  cv::imwrite(image.string(), deep);
}

TEST_F(Sources, OfSixteenBitsTheHighByteIsTracked) {
  for (int i = 1; i < kCount; i += 2) {
    cv::imwrite((sequence() / fmt::format("i/{}.png", i)).string(), scene(2 * i));
  }
  std::string frames = "frame,timestamp,image\n";
  for (int i = 0; i < kCount; ++i) frames += fmt::format("{0},{1},i/{0}.png\n", i, 0.1 * i);
  test::write_text(sequence() / "frames.csv", frames);
  ASSERT_EQ(track(), 0) << error_;
  const std::string eight = test::read_text(output() / "observations.csv");
  for (const int channels : {1, 3, 4}) {
    for (int i = 0; i < kCount; ++i) {
      write_16_bits(sequence() / fmt::format("i/{}.png", i), 2 * i, channels);
    }
    ASSERT_EQ(track(), 0) << error_;
    EXPECT_EQ(error_, "");
    EXPECT_EQ(test::read_text(output() / "observations.csv"), eight) << channels;
  }
}

TEST_F(Sources, TwelveBitsInSixteenAreHinted) {
  const Path plain = folder_.path() / "plain";
  std::filesystem::create_directories(plain);
  for (int i = 0; i < kCount; ++i) {
    cv::Mat deep;
    scene(2 * i).convertTo(deep, CV_16U, 16.0);
    cv::imwrite((plain / fmt::format("{}.png", i)).string(), deep);
  }
  EXPECT_EQ(slammot("track '" + plain.string() + "' --rate 10 --camera '" + camera() +
                    "' --output '" + output().string() + "'"),
            2)
      << error_;
  EXPECT_NE(error_.find("the 16-bit images"), std::string::npos) << error_;
}

// Names without leading zeros, in the order of their numbers.
TEST_F(Sources, APlainFolderHasARateACameraAndATruth) {
  const Path plain = folder_.path() / "plain";
  std::filesystem::create_directories(plain);
  std::string truth;
  for (int i = 0; i < 12; ++i) {
    cv::imwrite((plain / fmt::format("{}.png", i + 1)).string(), scene(2 * i));
    truth += fmt::format("{} {} 0 0 0 0 0 1\n", 0.05 * i, 0.1 * i);
  }
  test::write_text(plain / "notes.txt", "no image");
  test::write_text(folder_.path() / "truth.tum", truth);
  const std::string on =
      "track '" + plain.string() + "' --force --output '" + output().string() + "' ";
  EXPECT_EQ(slammot(on), 2);
  EXPECT_NE(error_.find("state --rate HZ and --camera"), std::string::npos) << error_;
  EXPECT_EQ(slammot(on + "--rate 20"), 2);
  EXPECT_NE(error_.find("nobody states the camera"), std::string::npos) << error_;
  const std::string stated = on + "--rate 20 --camera '" + camera() + "' ";
  ASSERT_EQ(slammot(stated + "--truth '" + (folder_.path() / "truth.tum").string() + "'"), 0)
      << error_;
  EXPECT_EQ(error_, "");
  const Sequence tracked = read_native(output());
  ASSERT_EQ(tracked.frames.size(), 12u);
  EXPECT_EQ(Path(tracked.images[9]).filename(), "10.png");
  EXPECT_NEAR(tracked.frames[10].timestamp, 0.5, 1e-12);
  ASSERT_TRUE(tracked.truth[10]);
  EXPECT_NEAR(tracked.truth[10]->position.x(), 1.0, 1e-9);
  EXPECT_NE(out_.find("followed "), std::string::npos) << out_;
  test::write_text(folder_.path() / "truth.tum",
                   "1305031102.1 0 0 0 0 0 0 1\n1305031102.2 0 0 0 0 0 0 1\n");
  EXPECT_EQ(slammot(stated + "--truth '" + (folder_.path() / "truth.tum").string() + "'"), 2);
  EXPECT_NE(error_.find("truth.tum: no frame, of 0 to 0.55 s"), std::string::npos) << error_;
  std::filesystem::remove(plain / "7.png");
  ASSERT_EQ(slammot(stated), 0) << error_;
  EXPECT_NE(error_.find("8.png follows 6.png, but the numbers before go up by 1"),
            std::string::npos)
      << error_;
}

TEST_F(Sources, ARateIsForWhatStatesNoTimes) {
  EXPECT_EQ(track("--rate 10"), 2);
  EXPECT_NE(error_.find("states its times itself"), std::string::npos) << error_;
}

TEST_F(Sources, AFilmHasItsOwnTimes) {
  const Path film = folder_.path() / "film.avi";
  cv::VideoWriter writer(film.string(), cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 25.0,
                         {160, 120});
  for (int i = 0; i < 8; ++i) {
    cv::Mat colour;
    cv::cvtColor(scene(2 * i), colour, cv::COLOR_GRAY2BGR);
    writer.write(colour);
  }
  writer.release();
  const std::string on = "track '" + film.string() + "' --camera '" + camera() +
                         "' --force --output '" + output().string() + "' ";
  ASSERT_EQ(slammot(on), 0) << error_;
  EXPECT_EQ(error_, "");
  Sequence tracked = read_native(output());
  ASSERT_EQ(tracked.frames.size(), 8u);
  EXPECT_TRUE(tracked.images.empty());
  EXPECT_NEAR(tracked.frames[7].timestamp, 0.28, 1e-6);
  EXPECT_GT(tracked.frames[7].observations.size(), 10u);
  ASSERT_EQ(slammot(on + "--rate 10"), 0) << error_;
  EXPECT_NEAR(read_native(output()).frames[7].timestamp, 0.7, 1e-12);
  test::write_text(
      folder_.path() / "wide.yaml",
      "{model: pinhole, width: 640, height: 120, fx: 100, fy: 100, cx: 79.5, cy: 59.5}\n");
  EXPECT_EQ(slammot("track '" + film.string() + "' --force --output '" + output().string() +
                    "' --camera '" + (folder_.path() / "wide.yaml").string() + "'"),
            2);
  EXPECT_NE(error_.find("the images are 160 x 120, their camera is of 640 x 120 px"),
            std::string::npos)
      << error_;
  test::write_text(film, "no film");
  EXPECT_EQ(slammot(on), 2);
  EXPECT_EQ(error_, "slammot: " + film.string() + ": is no film that can be read\n");
}

TEST_F(Sources, NothingTrackedIsAnError) {
  for (int i = 0; i < kCount; ++i)
    cv::imwrite(image(i).string(), cv::Mat(120, 160, CV_8U, cv::Scalar(0)));
  EXPECT_EQ(track(), 2);
  EXPECT_NE(error_.find("nothing was tracked: 0 corners"), std::string::npos) << error_;
  EXPECT_FALSE(std::filesystem::exists(output()));
}

TEST_F(Sources, AScreenThatTurnsBlackAndFewTracksAreHinted) {
  cv::imwrite(image(2).string(), cv::Mat(120, 160, CV_8U, cv::Scalar(0)));
  ASSERT_EQ(track(), 0) << error_;
  EXPECT_NE(error_.find("no track is followed from frame 1 to the next"), std::string::npos)
      << error_;
  for (int i = 0; i < kCount; ++i) {
    cv::Mat few(120, 160, CV_8U, cv::Scalar(90));
    scene(2 * i)(cv::Rect(40, 30, 50, 40)).copyTo(few(cv::Rect(40, 30, 50, 40)));
    cv::imwrite(image(i).string(), few);
  }
  ASSERT_EQ(track("--points 20"), 0) << error_;
  EXPECT_NE(error_.find("fewer than 10"), std::string::npos) << error_;
  EXPECT_NE(test::read_text(output() / "track.yaml").find("fewer than 10"), std::string::npos);
}

TEST_F(Sources, AnAssumedCameraIsSaid) {
  std::filesystem::remove(sequence() / "frames.csv");
  std::filesystem::remove(sequence() / "sequence.yaml");
  std::string list;
  for (int i = 0; i < kCount; ++i) list += fmt::format("{} {}\n", 0.1 * i, name(i));
  test::write_text(sequence() / "rgb.txt", list);
  EXPECT_EQ(track(), 2);
  EXPECT_NE(error_.find("640 x 480 px of the usual one are an assumption: --camera replaces it"),
            std::string::npos)
      << error_;
  EXPECT_EQ(track("--camera '" + camera() + "'"), 0) << error_;
  EXPECT_EQ(error_, "");
  for (int i = 0; i < kCount; ++i) {
    cv::Mat large;
    cv::repeat(scene(2 * i), 4, 4, large);
    cv::imwrite(image(i).string(), large);
  }
  EXPECT_EQ(track(), 0) << error_;
  EXPECT_NE(error_.find("warning: nobody states the camera"), std::string::npos) << error_;
}

}  // namespace
}  // namespace slammot
