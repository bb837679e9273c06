// The program itself: exit codes, and one line that names file, line and reason for bad input.
#include <fmt/format.h>
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
  for (int i = 0; i < 18; ++i) {
    rows += fmt::format("{},{},{},{}\n", i / 6, i % 6, 100 + 80 * (i % 6), 120 + 40 * (i % 3));
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
  EXPECT_THAT(outcome.error, testing::HasSubstr(part));
}

TEST(Cli, RunsAGoodSequenceQuietly) {
  const Outcome outcome = run_files(good_sequence());
  EXPECT_EQ(outcome.exit_code, 0) << outcome.error;
  EXPECT_EQ(outcome.error, "");  // no progress when piped
}

// What a reader refuses, and how, is in tests/datasets.
TEST(Cli, BadInputIsRefusedAtItsLine) {
  Files files = good_sequence();
  files["observations.csv"] += "2,7,100\n";
  expect_refused(run_files(files), "observations.csv:20: ");
  expect_refused(run_files(good_sequence(), "--set frames.first=10"), "frames.first");
  expect_refused(run_files(good_sequence(), "--config /nowhere.yaml"), "/nowhere.yaml");
}

TEST(Cli, UsageErrorsAreOneLineAndNameTheNearest) {
  for (const auto& [arguments, reason] : std::vector<std::pair<std::string, std::string>>{
           {"comprae", "unknown command 'comprae', the nearest are compare"},
           {"run /nowhere --sead 3", "has no option --sead, the nearest are --set"},
           {"--quite list scenarios", "no option --quite, the nearest are --quiet"},
           {"run", "SEQUENCE is required; see slammot run --help"},
           {"run /nowhere", "--estimator is required"},
           {"run /nowhere --estimator ekf", "/nowhere"},
           {"run /nowhere --estimator guess", "unknown estimator 'guess'"},
           {"draw /a /b", "no further argument '/b'"},
           {"", "see slammot --help"},
           {"list pancakes", "pancakes"},
           {"simulate nothing --output /tmp/slammot-never", "nothing"},
           {"simulate circle --seed -1 --output /nowhere", "--seed: '-1'"},
           {"compare --seed 1.5", "--seed: '1.5'"},
           {"study /nowhere --jobs 0", "--jobs: '0'"},
           {"study /nowhere --shard 2/2", "/nowhere: "}}) {
    expect_refused(slammot(arguments), reason);
  }
  // A number that no integer holds is not another.
  for (const char* shard : {"4294967297/4294967298", "1/4294967298", "3/2", "1/2/3", "1", "/"}) {
    expect_refused(slammot(std::string("study /nowhere --shard ") + shard), "--shard must be I/N");
  }
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

}  // namespace
}  // namespace slammot
