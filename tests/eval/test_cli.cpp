// The program itself: exit codes, and one line that names file, line and reason for bad input.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>

#include "tests/eval/fixture.h"
#include "tests/paths.h"

namespace slammot {
namespace {

struct Outcome {
  int exit_code = -1;
  std::string out;
  std::string error;
};

Outcome slammot(const std::string& arguments) {
  const test::TemporaryFolder folder;
  const auto out = folder.path() / "out";
  const auto error = folder.path() / "error";
  const std::string command = std::string("'") + test::kBinary + "' " + arguments + " >'" +
                              out.string() + "' 2>'" + error.string() + "'";
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, test::read_text(out),
          test::read_text(error)};
}

using Files = std::map<std::string, std::string>;

// Three frames of six points before a camera at rest.
Files good_sequence() {
  Files files;
  files["sequence.yaml"] =
      "format: slammot-sequence-1\nname: three\n"
      "camera: {model: pinhole, width: 640, height: 480, fx: 400, fy: 400, cx: 320, cy: 240}\n"
      "pixel_sigma: 1.0\n";
  files["frames.csv"] = "frame,timestamp\n0,0.0\n1,0.1\n2,0.2\n";
  std::string& rows = files["observations.csv"] = "frame,track,u,v\n";
  for (int frame = 0; frame < 3; ++frame) {
    for (int track = 0; track < 6; ++track) {
      rows += std::to_string(frame) + "," + std::to_string(track) + "," +
              std::to_string(100 + 80 * track) + "," + std::to_string(120 + 40 * (track % 3)) +
              "\n";
    }
  }
  return files;
}

Outcome run_files(const Files& files, const std::string& more = "") {
  const test::TemporaryFolder folder;
  for (const auto& [name, text] : files) test::write_text(folder.path() / "sequence" / name, text);
  return slammot("run '" + (folder.path() / "sequence").string() + "' --estimator ekf --output '" +
                 (folder.path() / "run").string() + "' " + more);
}

void expect_refused(const Outcome& outcome, const std::string& part) {
  EXPECT_EQ(outcome.exit_code, 2) << outcome.error;
  EXPECT_EQ(std::count(outcome.error.begin(), outcome.error.end(), '\n'), 1) << outcome.error;
  EXPECT_NE(outcome.error.find(part), std::string::npos) << outcome.error;
}

TEST(Cli, RunsAGoodSequenceQuietly) {
  const Outcome outcome = run_files(good_sequence());
  EXPECT_EQ(outcome.exit_code, 0) << outcome.error;
  EXPECT_EQ(outcome.error, "");  // no progress when piped
}

TEST(Cli, BadLine) {
  Files files = good_sequence();
  files["observations.csv"] += "2,7,100\n";
  expect_refused(run_files(files), "observations.csv:20: ");
}

TEST(Cli, MissingFile) {
  Files files = good_sequence();
  files.erase("observations.csv");
  expect_refused(run_files(files), "observations.csv");
  expect_refused(slammot("run /nowhere --estimator ekf"), "/nowhere");
}

TEST(Cli, NotANumber) {
  Files files = good_sequence();
  files["observations.csv"] += "2,7,nan,100\n";
  expect_refused(run_files(files), "observations.csv:20: ");
}

TEST(Cli, DuplicateTrackInAFrame) {
  Files files = good_sequence();
  files["observations.csv"] += "2,5,100,100\n";
  expect_refused(run_files(files), "observations.csv:20: ");
}

TEST(Cli, DecreasingTimestamps) {
  Files files = good_sequence();
  files["frames.csv"] = "frame,timestamp\n0,0.0\n1,0.2\n2,0.1\n";
  expect_refused(run_files(files), "frames.csv:4: ");
}

TEST(Cli, UnknownCameraModel) {
  Files files = good_sequence();
  std::string& text = files["sequence.yaml"];
  text.replace(text.find("pinhole"), 7, "cubist!");
  expect_refused(run_files(files), "sequence.yaml:3: ");
}

TEST(Cli, ZeroFrames) {
  Files files = good_sequence();
  files["frames.csv"] = "frame,timestamp\n";
  files["observations.csv"] = "frame,track,u,v\n";
  expect_refused(run_files(files), "frames.csv");
  expect_refused(run_files(good_sequence(), "--set frames.first=10"), "frames.first");
}

TEST(Cli, UsageErrorsAreOneLineAndNameTheNearest) {
  expect_refused(slammot("comprae"), "unknown command 'comprae', the nearest are compare");
  expect_refused(slammot("run /nowhere --sead 3"), "has no option --sead, the nearest are --set");
  expect_refused(slammot("--quite list scenarios"), "no option --quite, the nearest are --quiet");
  expect_refused(slammot("run"), "SEQUENCE is required; see slammot run --help");
  expect_refused(slammot("draw /a /b"), "no further argument '/b'");
  expect_refused(slammot(""), "see slammot --help");
  expect_refused(slammot("simulate circle --seed -1 --output /nowhere"), "--seed: '-1'");
  expect_refused(slammot("compare --seed 1.5"), "--seed: '1.5'");
  expect_refused(slammot("study /nowhere --jobs 0"), "--jobs: '0'");
}

TEST(Cli, ANumberThatNoIntegerHoldsIsNotAnother) {
  for (const char* shard : {"4294967297/4294967298", "1/4294967298", "3/2", "1/2/3", "1", "/"}) {
    expect_refused(slammot(std::string("study /nowhere --shard ") + shard), "--shard must be I/N");
  }
  expect_refused(slammot("study /nowhere --shard 2/2"), "/nowhere: ");
}

TEST(Cli, AFolderThatCannotBeWrittenIsRefusedBeforeAnythingIsComputed) {
  expect_refused(slammot("simulate circle --output /proc/x/y"), "/proc/x/y: cannot be written: ");
  expect_refused(slammot("simulate circle --output /dev/null/x"), "cannot be written: ");
  const test::TemporaryFolder folder;
  test::write_text(folder.path() / "trajectory.tum", "0 0 0 0 0 0 0 1\n");
  expect_refused(slammot("evaluate '" + folder.path().string() + "' --json /proc/x.json"),
                 "/proc/x.json: cannot be written: ");
  const auto output = folder.path() / "new" / "folder/";
  EXPECT_EQ(slammot("run /nowhere --estimator ekf --output '" + output.string() + "'").exit_code,
            2);
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "new"));
}

TEST(Cli, QuietSaysNothingButErrors) {
  const Outcome outcome = run_files(good_sequence(), "--quiet");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.error;
  EXPECT_EQ(outcome.out + outcome.error, "");
  EXPECT_EQ(slammot("--quiet list scenarios").out, "");
  expect_refused(run_files(good_sequence(), "--quiet --set window.frame=3"), "window.frames");
}

TEST(Cli, VersionSaysCommitAndCompiler) {
  EXPECT_THAT(
      slammot("--version").out,
      testing::ContainsRegex("^slammot [0-9.]+ \\(commit [0-9a-z]+(, modified)?; .+\\)\n$"));
}

TEST(Cli, BadConfigurationAndUsage) {
  expect_refused(run_files(good_sequence(), "--set window.frame=3"), "window.frames");
  expect_refused(run_files(good_sequence(), "--config /nowhere.yaml"), "/nowhere.yaml");
  EXPECT_EQ(slammot("run /nowhere").exit_code, 2);
  EXPECT_EQ(slammot("juggle").exit_code, 2);
  EXPECT_EQ(slammot("").exit_code, 2);
  EXPECT_EQ(slammot("list pancakes").exit_code, 2);
  expect_refused(slammot("run /nowhere --estimator guess"), "unknown estimator 'guess'");
  expect_refused(slammot("simulate nothing --output /tmp/slammot-never"), "nothing");
}

TEST(Cli, HelpEverywhere) {
  for (const char* command : {"", "compare", "run", "simulate", "evaluate", "list"}) {
    const Outcome outcome = slammot(std::string(command) + " --help");
    EXPECT_EQ(outcome.exit_code, 0) << command;
    EXPECT_NE(outcome.out.find("Usage"), std::string::npos) << command;
  }
  EXPECT_NE(slammot("run --help").out.find("window.linearisation"), std::string::npos);
}

TEST(Cli, ListsEveryTable) {
  for (const char* what :
       {"estimators", "landmarks", "motions", "classifiers", "metrics", "scenarios", "readers"}) {
    const Outcome outcome = slammot(std::string("list ") + what);
    EXPECT_EQ(outcome.exit_code, 0) << what;
    EXPECT_NE(outcome.out, "") << what;
  }
}

TEST(Cli, EvaluateAgreesWithTheRun) {
  const test::TemporaryFolder folder;
  const std::string sequence = (folder.path() / "sequence").string();
  const std::string run = (folder.path() / "run").string();
  const Outcome simulated = slammot("simulate helix --seed 3 --output '" + sequence + "'");
  ASSERT_EQ(simulated.exit_code, 0) << simulated.error;
  const Outcome ran = slammot("run '" + sequence + "' --estimator ekf --output '" + run + "'");
  ASSERT_EQ(ran.exit_code, 0) << ran.error;
  const Outcome evaluated = slammot("evaluate '" + run + "' --against '" + sequence + "'");
  ASSERT_EQ(evaluated.exit_code, 0) << evaluated.error;
  const auto first_lines = [](const std::string& text) {
    return text.substr(0, text.find('\n', text.find('\n') + 1));
  };
  EXPECT_EQ(first_lines(evaluated.out), first_lines(ran.out));
}

}  // namespace
}  // namespace slammot
