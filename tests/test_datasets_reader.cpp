// The native format: every refusal with its file and line, the round trip, truth, selection,
// SHA-256.
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>

#include "slammot/datasets/native_reader.h"
#include "slammot/datasets/native_writer.h"
#include "slammot/datasets/reader.h"
#include "slammot/datasets/sha256.h"

namespace slammot {
namespace {

namespace fs = std::filesystem;

class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = (fs::temp_directory_path() / "slammot-datasets-XXXXXX").string();
    path_ = mkdtemp(pattern.data());
  }
  ~TemporaryFolder() { fs::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

void write_text(const fs::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

std::string read_text(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

const std::map<std::string, std::string> kGood = {
    {"sequence.yaml",
     "format: slammot-sequence-1\n"
     "name: small\n"
     "camera: {model: radtan, width: 320, height: 240, fx: 170, fy: 171, cx: 160, cy: 120, "
     "distortion: [0.1, 0.2]}\n"
     "pixel_sigma: 1.5\n"
     "motion: {acceleration: 6, angular_acceleration: 5}\n"
     "prior: {inverse_depth: 0.3, inverse_depth_sigma: 0.15, max_speed: 2}\n"},
    {"frames.csv", "frame,timestamp\n0,0\n1,0.1\n2,0.2\n"},
    {"observations.csv", "frame,track,u,v\n0,5,1,2\n0,3,3.5,4\n2,3,5,6\n"},
    {"groundtruth.tum",
     "# timestamp tx ty tz qx qy qz qw\n"
     "0.001 0 0 0 0 0 0 1\n0.101 1 0 0 0 0 0 1\n0.26 3 0 0 0 0 0 1\n"},
    {"landmarks.csv",
     "track,frame,class,x,y,z,vx,vy,vz\n3,0,static,1,2,3,0,0,0\n"
     "5,0,moving,1,2,3,0,0,1\n5,1,moving,1,2,4,0,0,1\n"},
    {"known.csv", "track,x,y,z,sigma\n3,1,2,3,0.001\n"},
    {"initial.yaml",
     "position: [0, 0, 1]\nquaternion: [0, 0, 0, 1]\nvelocity: [0, 0, 0.5]\n"
     "angular_velocity: [0, 0.1, 0]\n"
     "sigma: {position: 1e-6, rotation: 1e-5, velocity: 0.1, angular_velocity: 0.2}\n"},
};

void write_good(const fs::path& folder) {
  for (const auto& [name, text] : kGood) write_text(folder / name, text);
}

std::string refusal(const fs::path& folder) {
  try {
    read_sequence(folder);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(NativeReader, ReadsEverything) {
  TemporaryFolder folder;
  write_good(folder.path());
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
  TemporaryFolder folder;
  write_good(folder.path());
  const Sequence s = read_native(folder.path());
  ASSERT_EQ(s.truth.size(), 3u);
  EXPECT_EQ(s.truth[1]->position.x(), 1.0);
  EXPECT_NEAR(s.truth[1]->velocity.x(), 10.0, 1e-9);
  EXPECT_FALSE(s.truth[2]);  // 0.06 s away
}

TEST(NativeReader, OptionalFilesMayBeAbsent) {
  TemporaryFolder folder;
  for (const char* name : {"sequence.yaml", "frames.csv", "observations.csv"}) {
    write_text(folder.path() / name, kGood.at(name));
  }
  const Sequence s = read_native(folder.path());
  EXPECT_TRUE(s.truth.empty());
  EXPECT_FALSE(s.initial);
  EXPECT_FALSE(s.exact_truth);
}

TEST(NativeReader, HashesTheFilesInTheOrderOfTheFormat) {
  TemporaryFolder folder;
  write_good(folder.path());
  Sha256 hash;
  for (const char* name : {"sequence.yaml", "frames.csv", "observations.csv", "groundtruth.tum",
                           "landmarks.csv", "known.csv", "initial.yaml"}) {
    hash.add(kGood.at(name));
  }
  EXPECT_EQ(read_native(folder.path()).sha256, hash.hex());
}

TEST(NativeReader, RefusesAMissingFolderAndMissingFiles) {
  TemporaryFolder folder;
  const fs::path nowhere = folder.path() / "nowhere";
  EXPECT_EQ(refusal(nowhere), nowhere.string() + ":0: no such folder");
  EXPECT_NE(refusal(folder.path()).find("not a sequence"), std::string::npos);
  EXPECT_NE(refusal(folder.path()).find("groundTruth.txt"), std::string::npos);
  for (const char* name : {"sequence.yaml", "frames.csv", "observations.csv"}) {
    write_good(folder.path());
    fs::remove(folder.path() / name);
    EXPECT_EQ(refusal(folder.path()), (folder.path() / name).string() + ":0: no such file");
  }
  write_good(folder.path());
  fs::remove(folder.path() / "observations.csv");
  write_text(folder.path() / "frames.csv", "frame,timestamp,image\n0,0,a.png\n");
  EXPECT_NE(refusal(folder.path()).find("observations.csv:0: no such file; the images must be"),
            std::string::npos);
}

// One change of one good file, and what it must be refused with.
struct Fault {
  const char* name;
  const char* file;
  std::string from;
  std::string to;
  const char* message;  // after the folder
};

std::ostream& operator<<(std::ostream& stream, const Fault& fault) { return stream << fault.name; }

class NativeRefusal : public testing::TestWithParam<Fault> {};

TEST_P(NativeRefusal, NamesFileLineAndReason) {
  const Fault& fault = GetParam();
  TemporaryFolder folder;
  write_good(folder.path());
  std::string text = kGood.at(fault.file);
  const size_t at = text.find(fault.from);
  ASSERT_NE(at, std::string::npos);
  write_text(folder.path() / fault.file, text.replace(at, fault.from.size(), fault.to));
  const std::string reason = refusal(folder.path());
  EXPECT_EQ(reason.find((folder.path() / fault.message).string()), 0u) << reason;
  EXPECT_EQ(reason.find('\n'), std::string::npos) << reason;
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
    {"Inf", "observations.csv", "3.5", "-inf", "observations.csv:3: '-inf' is not a finite number"},
    {"DuplicateTrack", "observations.csv", "0,3,", "0,5,",
     "observations.csv:3: track 5 stands twice in frame 0 (first in line 2)"},
    {"NegativeTrack", "observations.csv", "0,3,", "0,-3,", "observations.csv:3: '-3' is negative"},
    {"FractionalTrack", "observations.csv", "0,3,", "0,3.0,",
     "observations.csv:3: '3.0' is not a whole number"},
    {"NoSuchFrame", "observations.csv", "2,3,", "3,3,",
     "observations.csv:4: frame 3 does not exist (frames.csv ends at 2)"},
    {"ObservationsHeader", "observations.csv", "frame,track,u,v", "frame,track,x,y",
     "observations.csv:1: the first line must be 'frame,track,u,v'"},
    {"DecreasingTimestamps", "frames.csv", "2,0.2", "2,0.05",
     "frames.csv:4: timestamp 0.05 does not follow 0.1: they must increase"},
    {"EqualTimestamps", "frames.csv", "2,0.2", "2,0.1",
     "frames.csv:4: timestamp 0.1 does not follow 0.1: they must increase"},
    {"NaNTimestamp", "frames.csv", "0.2", "NaN", "frames.csv:4: 'NaN' is not a finite number"},
    {"FrameNumber", "frames.csv", "1,0.1", "3,0.1",
     "frames.csv:3: frame 3 stands where frame 1 must"},
    {"ZeroFrames", "frames.csv", "\n0,0\n1,0.1\n2,0.2\n", "\n", "frames.csv:1: there is no frame"},
    {"EmptyFrames", "frames.csv", "frame,timestamp\n0,0\n1,0.1\n2,0.2\n", "",
     "frames.csv:1: the first line must be 'frame,timestamp' or 'frame,timestamp,image'"},
    {"FramesHeader", "frames.csv", "frame,timestamp", "frame;timestamp",
     "frames.csv:1: the first line must be 'frame,timestamp' or 'frame,timestamp,image'"},
    {"PoseFields", "groundtruth.tum", "0.101 1 0 0 0 0 0 1", "0.101 1 0 0 0 0 0",
     "groundtruth.tum:3: expected 8 fields, found 7"},
    {"PoseOrder", "groundtruth.tum", "0.26 ", "0.1 ",
     "groundtruth.tum:4: timestamp 0.1 does not follow 0.101: they must increase"},
    {"PoseQuaternion", "groundtruth.tum", "0.101 1 0 0 0 0 0 1", "0.101 1 0 0 0 0 0 0",
     "groundtruth.tum:3: the quaternion has length zero"},
    {"PoseNaN", "groundtruth.tum", "0.101 1", "0.101 nan",
     "groundtruth.tum:3: 'nan' is not a finite number"},
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
    {"KnownSigma", "known.csv", "0.001", "0", "known.csv:2: '0' is not greater than zero"},
    {"KnownTwice", "known.csv", "3,1,2,3,0.001\n", "3,1,2,3,1\n3,1,2,3,1\n",
     "known.csv:3: track 3 stands twice"},
    {"KnownHeader", "known.csv", "sigma", "s",
     "known.csv:1: the first line must be 'track,x,y,z,sigma'"},
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
    {"Distortion", "sequence.yaml", "[0.1, 0.2]", "[0.1, 0.2, 0, 0, 0]",
     "sequence.yaml:3: camera model 'radtan' takes at most 4"},
    {"Focal", "sequence.yaml", "fx: 170", "fx: 0",
     "sequence.yaml:3: 'fx' must be greater than zero"},
    {"FocalNaN", "sequence.yaml", "fx: 170", "fx: nan",
     "sequence.yaml:3: 'fx' must be a finite number"},
    {"Width", "sequence.yaml", "width: 320", "width: 320.5",
     "sequence.yaml:3: 'width' must be a whole number"},
    {"PixelSigma", "sequence.yaml", "pixel_sigma: 1.5", "pixel_sigma: -1",
     "sequence.yaml:4: 'pixel_sigma' must be greater than zero"},
    {"PixelSigmaText", "sequence.yaml", "pixel_sigma: 1.5", "pixel_sigma: one",
     "sequence.yaml:4: 'pixel_sigma' must be a number, not 'one'"},
    {"Motion", "sequence.yaml", "acceleration: 6,", "",
     "sequence.yaml:5: 'acceleration' is missing in 'motion'"},
    {"Prior", "sequence.yaml", "inverse_depth_sigma: 0.15", "inverse_depth_sigma: 0",
     "sequence.yaml:6: 'inverse_depth_sigma' must be greater than zero"},
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

const auto kName = [](const auto& parameter) { return std::string(parameter.param.name); };
INSTANTIATE_TEST_SUITE_P(Tables, NativeRefusal, testing::ValuesIn(kTableFaults), kName);
INSTANTIATE_TEST_SUITE_P(Settings, NativeRefusal, testing::ValuesIn(kSettingsFaults), kName);

void expect_equal(const Sequence& a, const Sequence& b) {
  ASSERT_EQ(a.frames.size(), b.frames.size());
  for (size_t i = 0; i < a.frames.size(); ++i) {
    EXPECT_EQ(a.frames[i].timestamp, b.frames[i].timestamp);
    ASSERT_EQ(a.frames[i].observations.size(), b.frames[i].observations.size());
    for (size_t j = 0; j < a.frames[i].observations.size(); ++j) {
      EXPECT_EQ(a.frames[i].observations[j].track, b.frames[i].observations[j].track);
      EXPECT_EQ(a.frames[i].observations[j].pixel, b.frames[i].observations[j].pixel);
    }
    EXPECT_EQ(a.truth[i]->position, b.truth[i]->position);
    EXPECT_EQ(a.truth[i]->orientation.coeffs(), b.truth[i]->orientation.coeffs());
  }
}

TEST(NativeWriter, RoundTripIsExact) {
  TemporaryFolder folder;
  write_good(folder.path());
  Sequence a = read_native(folder.path());
  a.name = "say \"x\": \\ 1";
  a.images = {"a.png", "b.png", "c d.png"};
  a.camera.fx = 170.0 + 1.0 / 3.0;
  a.frames[1].observations = {{7, {1.0 / 3.0, -1e-300}}};
  a.frames[2].timestamp = 0.1 + 0.2;
  for (auto& truth : a.truth) {
    truth.emplace();
    truth->position = Eigen::Vector3d(0.1, 1e22, std::numeric_limits<double>::denorm_min());
    truth->orientation = exp_so3(Eigen::Vector3d(0.3, -2.0, 0.7));
  }
  a.initial->state.orientation = a.truth[0]->orientation;
  write_native(a, folder.path() / "new" / "folder");
  const Sequence b = read_native(folder.path() / "new" / "folder");
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.images, b.images);
  EXPECT_EQ(a.camera.fx, b.camera.fx);
  EXPECT_EQ(a.initial->state.orientation.coeffs(), b.initial->state.orientation.coeffs());
  EXPECT_EQ(a.landmarks.at(5).at(1)->velocity, b.landmarks.at(5).at(1)->velocity);
  expect_equal(a, b);
  write_native(b, folder.path() / "again");
  for (const auto& [name, text] : kGood) {
    EXPECT_EQ(read_text(folder.path() / "new" / "folder" / name),
              read_text(folder.path() / "again" / name));
  }
}

TEST(NativeWriter, RemovesWhatTheSequenceDoesNotHave) {
  TemporaryFolder folder;
  write_good(folder.path());
  Sequence s = read_native(folder.path());
  s.known.clear();
  s.initial.reset();
  write_native(s, folder.path());
  EXPECT_FALSE(fs::exists(folder.path() / "known.csv"));
  EXPECT_FALSE(fs::exists(folder.path() / "initial.yaml"));
  EXPECT_TRUE(fs::exists(folder.path() / "landmarks.csv"));
}

TEST(NativeReader, ReadsALongSequenceFast) {
  TemporaryFolder folder;
  Sequence s;
  s.camera.fx = s.camera.fy = 100.0;
  for (int i = 0; i < 20000; ++i) {
    Frame frame{i, i / 15.0, {}};
    for (int track = 0; track < 30; ++track) frame.observations.push_back({track, {i / 7.0, 2.5}});
    s.frames.push_back(frame);
  }
  write_native(s, folder.path());
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(read_native(folder.path()).frames.back().observations.size(), 30u);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
  RecordProperty("seconds", std::to_string(seconds.count()));
  EXPECT_LT(seconds.count(), 20.0);  // about 0.1 in a release build
}

TEST(SelectFrames, KeepsIndicesTruthAndWhatIsStated) {
  TemporaryFolder folder;
  write_good(folder.path());
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

TEST(Sha256, StandardVectors) {
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

TEST(Readers, TableNamesAndDescribes) {
  ASSERT_GE(reader_table().size(), 2u);
  for (const ReaderRow& row : reader_table()) {
    EXPECT_FALSE(row.name.empty());
    EXPECT_FALSE(row.description.empty());
  }
}

}  // namespace
}  // namespace slammot
