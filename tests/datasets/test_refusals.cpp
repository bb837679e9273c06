// What a reader refuses, and that it names file, line and reason.
#include <gtest/gtest.h>

#include <filesystem>
#include <span>

#include "datasets/readers/reader.h"
#include "tests/datasets/fixture.h"

namespace slammot {
namespace {

namespace fs = std::filesystem;

std::string refusal(const fs::path& folder) {
  return test::refusal_of([&] { read_sequence(folder); });
}

TEST(NativeReader, RefusesAMissingFolderAndMissingFiles) {
  test::TemporaryFolder folder;
  const fs::path nowhere = folder.path() / "nowhere";
  EXPECT_EQ(refusal(nowhere), nowhere.string() + ": no such folder");
  EXPECT_NE(refusal(folder.path()).find("not a sequence"), std::string::npos);
  EXPECT_NE(refusal(folder.path()).find("groundTruth.txt"), std::string::npos);
  for (const char* name : {"sequence.yaml", "frames.csv", "observations.csv"}) {
    test::write_good(folder.path());
    fs::remove(folder.path() / name);
    EXPECT_EQ(refusal(folder.path()), (folder.path() / name).string() + ": no such file");
  }
  test::write_good(folder.path());
  fs::remove(folder.path() / "observations.csv");
  test::write_text(folder.path() / "frames.csv", "frame,timestamp,image\n0,0,a.png\n");
  EXPECT_NE(refusal(folder.path()).find("observations.csv: no such file; the images must be"),
            std::string::npos);
}

TEST(NativeReader, RefusesAFileThatFitsNoMemory) {
  test::TemporaryFolder folder;
  test::write_good(folder.path());
  const fs::path file = folder.path() / "observations.csv";
  fs::resize_file(file, std::uintmax_t{1} << 40);  // of holes
  EXPECT_EQ(refusal(folder.path()), file.string() + ": cannot be read: larger than 4 GiB");
}

// What lies just within the limits is read.
TEST(NativeReader, TakesWhatIsUnusual) {
  test::TemporaryFolder folder;
  test::write_good(folder.path());
  test::write_text(folder.path() / "observations.csv",
                   "frame,track,u,v\n0,5,-320,-240\n0,3,640,480\n");
  test::write_text(folder.path() / "frames.csv",
                   "frame,timestamp,image\n0,1e9,a, b.png\n1,1000000000.001,\xc3\xa9.png\n");
  fs::remove(folder.path() / "landmarks.csv");
  EXPECT_EQ(refusal(folder.path()), "accepted");
  EXPECT_EQ(read_sequence(folder.path()).images,
            (std::vector<std::string>{"a, b.png", "\xc3\xa9.png"}));
}

// One change of one good file, and what it must be refused with.
struct Fault {
  const char* name;
  const char* file;
  std::string from;
  std::string to;
  const char* message;  // after the folder
};

void expect_refused(std::span<const Fault> faults) {
  test::TemporaryFolder folder;
  test::write_good(folder.path());
  for (const Fault& fault : faults) {
    SCOPED_TRACE(fault.name);
    const std::string& good = test::kGood.at(fault.file);
    const size_t at = good.find(fault.from);
    ASSERT_NE(at, std::string::npos);
    test::write_text(folder.path() / fault.file,
                     std::string(good).replace(at, fault.from.size(), fault.to));
    const std::string reason = refusal(folder.path());
    EXPECT_EQ(reason.find((folder.path() / fault.message).string()), 0u) << reason;
    EXPECT_EQ(reason.find('\n'), std::string::npos) << reason;
    test::write_text(folder.path() / fault.file, good);
  }
}

TEST(NativeReader, RefusesARelativeSigmaThatIsNone) {
  test::TemporaryFolder folder;
  test::write_good(folder.path());
  for (const char* sigma : {"0", "-1", "nan", "inf", "x", ""}) {
    test::write_text(
        folder.path() / "observations.csv",
        std::string("frame,track,u,v,relative_sigma\n0,3,3.5,4,1\n2,3,5,6,") + sigma + "\n");
    const std::string where = (folder.path() / "observations.csv:3: '").string() + sigma + "' is";
    EXPECT_EQ(refusal(folder.path()).find(where), 0u) << refusal(folder.path());
  }
}

const Fault kTableFaults[] = {
    {"FewFields", "observations.csv", "2,3,5,6", "2,3,5",
     "observations.csv:4: expected 4 fields, found 3"},
    {"ManyFields", "observations.csv", "2,3,5,6", "2,3,5,6,7",
     "observations.csv:4: expected 4 fields, found 5"},
    {"BlankLine", "observations.csv", "0,3,3.5", "\n0,3,3.5",
     "observations.csv:3: expected 4 fields, found 1"},
    {"NotANumber", "observations.csv", "3.5", "3.5x", "observations.csv:3: '3.5x' is not a number"},
    {"Empty", "observations.csv", "3.5", "", "observations.csv:3: '' is not a number"},
    {"NaN", "observations.csv", "3.5", "nan", "observations.csv:3: 'nan' is not a finite number"},
    {"DuplicateTrack", "observations.csv", "0,3,", "0,5,",
     "observations.csv:3: track 5 stands twice in frame 0 (first in line 2)"},
    {"NegativeTrack", "observations.csv", "0,3,", "0,-3,", "observations.csv:3: '-3' is negative"},
    {"FractionalTrack", "observations.csv", "0,3,", "0,3.0,",
     "observations.csv:3: '3.0' is not a whole number"},
    {"NoSuchFrame", "observations.csv", "2,3,", "3,3,",
     "observations.csv:4: frame 3 does not exist (frames.csv ends at 2)"},
    {"ObservationsHeader", "observations.csv", "frame,track,u,v", "frame,track,x,y",
     "observations.csv:1: the first line must be 'frame,track,u,v'"},
    {"EqualTimestamps", "frames.csv", "2,0.2", "2,0.1",
     "frames.csv:4: timestamp 0.1 does not follow 0.1: they must increase"},
    {"FrameNumber", "frames.csv", "1,0.1", "3,0.1",
     "frames.csv:3: frame 3 stands where frame 1 must"},
    {"ZeroFrames", "frames.csv", "\n0,0\n1,0.1\n2,0.2\n", "\n", "frames.csv:1: there is no frame"},
    {"EmptyFrames", "frames.csv", "frame,timestamp\n0,0\n1,0.1\n2,0.2\n", "",
     "frames.csv:1: the first line must be 'frame,timestamp' or 'frame,timestamp,image'"},
    {"FramesHeader", "frames.csv", "frame,timestamp", "frame;timestamp",
     "frames.csv:1: the first line must be 'frame,timestamp' or 'frame,timestamp,image'"},
    {"PoseFields", "groundtruth.tum", "0.1 1 0 0 0 0 0 1", "0.1 1 0 0 0 0 0",
     "groundtruth.tum:3: expected 8 fields, found 7"},
    {"PoseOrder", "groundtruth.tum", "0.26 ", "0.05 ",
     "groundtruth.tum:4: timestamp 0.05 does not follow 0.1: they must increase"},
    {"PoseQuaternion", "groundtruth.tum", "0.1 1 0 0 0 0 0 1", "0.1 1 0 0 0 0 0 0",
     "groundtruth.tum:3: the quaternion has length zero"},
    {"UnknownClass", "landmarks.csv", "3,0,static", "3,0,parked",
     "landmarks.csv:2: unknown class 'parked' (known: static, moving)"},
    {"StaticTwice", "landmarks.csv", "5,0,moving", "3,1,static",
     "landmarks.csv:3: static track 3 has a second row"},
    {"BothClasses", "landmarks.csv", "5,0,moving", "3,1,moving",
     "landmarks.csv:3: track 3 is both static and moving"},
    {"MovingTwice", "landmarks.csv", "5,1,moving", "5,0,moving",
     "landmarks.csv:4: track 5 stands twice in frame 0"},
    {"LandmarkFrame", "landmarks.csv", "5,1,moving", "5,7,moving",
     "landmarks.csv:4: frame 7 does not exist"},
    {"LandmarksHeader", "landmarks.csv", "vx,vy,vz", "u,v,w",
     "landmarks.csv:1: the first line must be 'track,frame,class,x,y,z,vx,vy,vz'"},
    {"FarPixel", "observations.csv", "3.5,4", "1e9,4",
     "observations.csv:3: pixel 1000000000, 4 is more than one image size outside the image of 320 "
     "x "},
    {"PixelBelow", "observations.csv", "3.5,4", "3.5,480.5",
     "observations.csv:3: pixel 3.5, 480.5 is more than one image size outside"},
    {"NotUtf8", "observations.csv", "0,3,", "0,\xff,", "observations.csv:3: is not UTF-8"},
    {"ImageNotUtf8", "frames.csv", "frame,timestamp\n0,0\n",
     "frame,timestamp,image\n0,0,\xe9.png\n", "frames.csv:2: is not UTF-8"},
    {"ControlCharacter", "observations.csv", "0,3,", "0,\x1b[2J,",
     "observations.csv:3: '\\x1b[2J' is not a whole number"},
    {"DistantTime", "frames.csv", "2,0.2", "2,1e18",
     "frames.csv:4: a time of 1e+18 s is not plausible; are these nanoseconds (seconds times "
     "1e9)?"},
    {"TimeBelowTheClock", "frames.csv", "1,0.1\n2,0.2", "1,1e9\n2,1000000000.00001",
     "frames.csv:4: timestamp 1000000000.00001 follows 1000000000 too closely for its digits"},
    {"PicosecondStep", "frames.csv", "1,0.1", "1,1e-12",
     "frames.csv:3: timestamp 1e-12 follows 0 "},
    {"DistantPose", "groundtruth.tum", "0.1 1", "0.1 1e300",
     "groundtruth.tum:3: '1e300' is not plausible"},
    {"DistantPoseTime", "groundtruth.tum", "0.26 ", "1e18 ",
     "groundtruth.tum:4: a time of 1e+18 s is not plausible; are these nanoseconds (seconds times "
     "1e9)?"},
    {"LongQuaternion", "groundtruth.tum", "0.1 1 0 0 0 0 0 1", "0.1 1 0 0 0 0 0 2",
     "groundtruth.tum:3: the quaternion has length 2, not 1"},
    {"ShortQuaternion", "groundtruth.tum", "0.1 1 0 0 0 0 0 1", "0.1 1 0 0 0 0 0 0.001",
     "groundtruth.tum:3: the quaternion has length 0.001, not 1"},
    {"DistantLandmark", "landmarks.csv", "3,0,static,1,", "3,0,static,-1e10,",
     "landmarks.csv:2: '-1e10' is not plausible"},
    {"FastLandmark", "landmarks.csv", "5,0,moving,1,2,3,0,0,1", "5,0,moving,1,2,3,0,0,1e200",
     "landmarks.csv:3: '1e200' is not plausible"},
    {"KnownSigmaTooSmall", "known.csv", "0.001", "1e-300",
     "known.csv:2: '1e-300' is not plausible"},
    {"KnownSigma", "known.csv", "0.001", "0", "known.csv:2: '0' is not greater than zero"},
    {"KnownTwice", "known.csv", "3,1,2,3,0.001\n", "3,1,2,3,1\n3,1,2,3,1\n",
     "known.csv:3: track 3 stands twice"},
    {"KnownHeader", "known.csv", "sigma", "s",
     "known.csv:1: the first line must be 'track,x,y,z,sigma'"},
    {"OddsTwice", "priors.csv", "5,0", "3,0", "priors.csv:3: track 3 stands twice"},
    {"OddsAbove1", "priors.csv", "0.9", "1.01", "priors.csv:2: a probability is 0 to 1, not 1.01"},
    {"OddsBelow0", "priors.csv", "5,0", "5,-0.1",
     "priors.csv:3: a probability is 0 to 1, not -0.1"},
    {"OddsNaN", "priors.csv", "0.9", "nan", "priors.csv:2: 'nan' is not a finite number"},
    {"OddsText", "priors.csv", "0.9", "static", "priors.csv:2: 'static' is not a number"},
    {"OddsTrack", "priors.csv", "3,0.9", "-3,0.9", "priors.csv:2: '-3' is negative"},
    {"OddsHeader", "priors.csv", "p_static", "p",
     "priors.csv:1: the first line must be 'track,p_static'"},
};

const Fault kSettingsFaults[] = {
    {"Format", "sequence.yaml", "slammot-sequence-1", "slammot-sequence-9",
     "sequence.yaml:1: 'format' must be 'slammot-sequence-1'"},
    {"NoFormat", "sequence.yaml", "format: slammot-sequence-1\n", "",
     "sequence.yaml:1: 'format' is missing in the file"},
    {"UnknownKey", "sequence.yaml", "pixel_sigma: 1.5", "pixel_sigma: 1.5\npixle_sigma: 1",
     "sequence.yaml:5: unknown key 'pixle_sigma' in the file (known: "},
    {"UnknownCameraKey", "sequence.yaml", "fx: 170", "fx: 170, f: 1",
     "sequence.yaml:3: unknown key 'f' in 'camera' (known: "},
    {"RepeatedKey", "sequence.yaml", "name: small", "name: small\nname: big",
     "sequence.yaml:3: 'name' stands twice"},
    {"CameraModel", "sequence.yaml", "radtan", "fisheye62",
     "sequence.yaml:3: unknown camera model 'fisheye62'"},
    {"Distortion", "sequence.yaml", "[0.1, 0.2]", "[0.1, 0.2, 0, 0, 0, 1]",
     "sequence.yaml:3: camera model 'radtan' takes at most 5"},
    {"Focal", "sequence.yaml", "fx: 170", "fx: 0",
     "sequence.yaml:3: 'fx' must be greater than zero"},
    {"FocalNaN", "sequence.yaml", "fx: 170", "fx: nan",
     "sequence.yaml:3: 'fx' must be a finite number"},
    {"Width", "sequence.yaml", "width: 320", "width: 320.5",
     "sequence.yaml:3: 'width' must be a whole number"},
    {"ShortFocal", "sequence.yaml", "fx: 170", "fx: 1e-3",
     "sequence.yaml:3: a focal length of 0.001 px is not plausible for 320 x 240 px"},
    {"LongFocal", "sequence.yaml", "fy: 171", "fy: 1e9",
     "sequence.yaml:3: a focal length of 1000000000 px is not plausible"},
    {"PrincipalPoint", "sequence.yaml", "cx: 160", "cx: 700",
     "sequence.yaml:3: the principal point 700, 120 is far outside the image"},
    {"Coefficient", "sequence.yaml", "0.1, 0.2", "0.1, 1e6",
     "sequence.yaml:3: no lens has a coefficient 1000000"},
    {"LargeImage", "sequence.yaml", "width: 320", "width: 1e8", "sequence.yaml:3: no image is "},
    {"NameOfAnotherFolder", "sequence.yaml", "name: small", "name: a/../../x",
     "sequence.yaml:2: 'name' names a folder and has no '/'"},
    {"NameAbove", "sequence.yaml", "name: small", "name: ..", "sequence.yaml:2: 'name' is no name"},
    {"NameOfTwoLines", "sequence.yaml", "name: small", "name: \"a\\nb\"",
     "sequence.yaml:2: 'name' contains a control character"},
    {"NameNotUtf8", "sequence.yaml", "name: small", "name: caf\xe9",
     "sequence.yaml:2: is not UTF-8"},
    {"SmallSigma", "sequence.yaml", "pixel_sigma: 1.5", "pixel_sigma: 1e-300",
     "sequence.yaml:4: 'pixel_sigma' is not plausible"},
    {"LargeNumber", "sequence.yaml", "max_speed: 2", "max_speed: 1e300",
     "sequence.yaml:6: 'max_speed' is not plausible"},
    {"InitialLongQuaternion", "initial.yaml", "[0, 0, 0, 1]", "[0, 0, 3, 4]",
     "initial.yaml:2: the quaternion has length 5, not 1"},
    {"PixelSigma", "sequence.yaml", "pixel_sigma: 1.5", "pixel_sigma: -1",
     "sequence.yaml:4: 'pixel_sigma' must be greater than zero"},
    {"PixelSigmaText", "sequence.yaml", "pixel_sigma: 1.5", "pixel_sigma: one",
     "sequence.yaml:4: 'pixel_sigma' must be a number, not 'one'"},
    {"Motion", "sequence.yaml", "acceleration: 6,", "",
     "sequence.yaml:5: 'acceleration' is missing in 'motion'"},
    {"Prior", "sequence.yaml", "inverse_depth_sigma: 0.15", "inverse_depth_sigma: 0",
     "sequence.yaml:6: 'inverse_depth_sigma' must be greater than zero"},
    {"Points", "sequence.yaml", "pixel_sigma: 1.5", "pixel_sigma: 1.5\npoints: 2.5",
     "sequence.yaml:5: 'points' must be a whole number"},
    {"PriorMean", "sequence.yaml", "max_speed: 2", "mean_sigma: 0, max_speed: 2",
     "sequence.yaml:6: 'mean_sigma' must be greater than zero"},
    {"NotAMap", "sequence.yaml", "{acceleration: 6, angular_acceleration: 5}", "6",
     "sequence.yaml:5: 'motion' must be a map"},
    {"Syntax", "sequence.yaml", "name: small", "name: [small", "sequence.yaml:"},
    {"InitialKey", "initial.yaml", "velocity: [0, 0, 0.5]", "velocity: [0, 0, 0.5]\nspeed: 1",
     "initial.yaml:4: unknown key 'speed'"},
    {"InitialLength", "initial.yaml", "[0, 0, 0.5]", "[0, 0.5]",
     "initial.yaml:3: 'velocity' must have 3 numbers, not 2"},
    {"InitialQuaternion", "initial.yaml", "[0, 0, 0, 1]", "[0, 0, 0, 0]",
     "initial.yaml:2: the quaternion has length zero"},
    {"InitialSigma", "initial.yaml", "velocity: 0.1", "velocity: 0",
     "initial.yaml:5: 'velocity' must be greater than zero"},
};

TEST(NativeRefusal, NamesFileLineAndReasonOfATable) { expect_refused(kTableFaults); }
TEST(NativeRefusal, NamesFileLineAndReasonOfSettings) { expect_refused(kSettingsFaults); }

}  // namespace
}  // namespace slammot
