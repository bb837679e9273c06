// Writing the native format: what is replaced, removed and left alone. The round trip:
// test_laws.cpp.
#include <gtest/gtest.h>

#include <filesystem>

#include "datasets/native/native_reader.h"
#include "datasets/native/native_writer.h"
#include "datasets/output/output_files.h"
#include "datasets/text/input_error.h"
#include "datasets/text/text_table.h"
#include "tests/datasets/fixture.h"

namespace slammot {
namespace {

namespace fs = std::filesystem;

// Where all are 1 the table has its four columns.
TEST(NativeWriter, WritesRelativeSigmasWhereTheyDiffer) {
  test::TemporaryFolder folder;
  test::write_good(folder.path());
  Sequence sequence = read_native(folder.path());
  const auto header = [&](const char* name) {
    write_native(sequence, folder.path() / name);
    const std::string text = test::read_text(folder.path() / name / "observations.csv");
    return text.substr(0, text.find('\n'));
  };
  EXPECT_EQ(header("equal"), "frame,track,u,v");
  sequence.frames[0].observations[1].relative_sigma = 2.5;
  EXPECT_EQ(header("uneven"), "frame,track,u,v,relative_sigma");
}

// All or nothing: what the reader would refuse is not written, and what stood there stays.
TEST(NativeWriter, WritesNothingThatTheReaderRefuses) {
  test::TemporaryFolder folder;
  test::write_good(folder.path());
  const Sequence good = read_native(folder.path());
  const auto refused = [&](const std::function<void(Sequence&)>& spoil) {
    Sequence s = good;
    spoil(s);
    EXPECT_THROW(write_native(s, folder.path()), std::invalid_argument);
    for (const auto& [name, text] : test::kGood) {
      EXPECT_EQ(test::read_text(folder.path() / name), text) << name;
    }
  };
  refused([](Sequence& s) { s.camera.fx = 0.0; });
  refused([](Sequence& s) { s.name = "a\nb"; });
  refused([](Sequence& s) { s.images = {"a.png", "b\n.png", "c.png"}; });
  refused([](Sequence& s) { s.images = {"a.png", "b.png\r", "c.png"}; });
  refused([](Sequence& s) { s.frames[0].observations[0].pixel.x() = 1e9; });
  refused([](Sequence& s) { s.frames[1].timestamp = s.frames[0].timestamp; });
  refused([](Sequence& s) { s.known[0].position.x() = std::nan(""); });
}

TEST(NativeWriter, RemovesWhatTheSequenceDoesNotHave) {
  test::TemporaryFolder folder;
  test::write_good(folder.path());
  Sequence s = read_native(folder.path());
  write_native(s, folder.path() / "own");
  s.known.clear();
  s.initial.reset();
  write_native(s, folder.path() / "own");
  EXPECT_FALSE(fs::exists(folder.path() / "own" / "known.csv"));
  EXPECT_FALSE(fs::exists(folder.path() / "own" / "initial.yaml"));
  EXPECT_TRUE(fs::exists(folder.path() / "own" / "landmarks.csv"));
}

// A folder that is left between two renames says so, until it is written again. The settings, which
// name the files, are the first to be renamed: the others are ours all the same.
TEST(NativeWriter, HalfAReplacementIsNotReadButWrittenAgain) {
  test::TemporaryFolder folder;
  test::write_good(folder.path());
  Sequence s = read_native(folder.path());
  const fs::path own = folder.path() / "own";
  write_native(s, own);
  ASSERT_TRUE(fs::exists(own / "known.csv"));
  s.known.clear();
  {
    fs::create_directories(own / "blocked" / "by");
    OutputFiles files;
    add_native(s, own, NativeParts::kWithoutObservations, files);
    files.write(own / "blocked", "cannot be renamed to a folder");
    EXPECT_THROW(files.put_in_place(), std::runtime_error);
  }
  ASSERT_TRUE(fs::exists(own / "known.csv"));
  EXPECT_THROW(read_native(own), InputError);
  write_native(s, own);
  EXPECT_TRUE(read_native(own).known.empty());
}

// Not what this program wrote: neither removed nor replaced.
TEST(NativeWriter, LeavesFilesOfOthersAlone) {
  test::TemporaryFolder folder;
  test::write_good(folder.path());
  Sequence s = read_native(folder.path());
  EXPECT_THROW(write_native(s, folder.path()), std::invalid_argument);
  s.known.clear();
  write_native(s, folder.path() / "own");
  test::write_text(folder.path() / "own" / "known.csv", "mine");
  EXPECT_THROW(write_native(s, folder.path() / "own"), std::invalid_argument);
  EXPECT_EQ(read_text_file(folder.path() / "own" / "known.csv"), "mine");
}

}  // namespace
}  // namespace slammot
