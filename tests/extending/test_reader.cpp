// A reader, as examples/extension/ adds one; its code stands there.
#include <gtest/gtest.h>

#include "datasets/readers/reader.h"
#include "datasets/sequence/sha256.h"
#include "datasets/text/text_table.h"
#include "examples/extension/pixel_list.h"
#include "tests/temporary_folder.h"

namespace slammot {
namespace {

TEST(ExtendingReader, ReadsAndRefusesWithTheLine) {
  const test::TemporaryFolder folder;
  EXPECT_FALSE(kPixelList.recognises(folder.path()));
  test::write_text(folder.path() / "pixels.txt", "0.0 3 100 200\n0.0 5 120 90\n0.1 3 101 201\n");
  ASSERT_TRUE(kPixelList.recognises(folder.path()));
  const Sequence sequence = kPixelList.read(folder.path());
  ASSERT_EQ(sequence.frames.size(), 2u);
  EXPECT_EQ(sequence.frames[0].observations.size(), 2u);
  EXPECT_EQ(sequence.frames[1].observations[0].track, 3);
  test::write_text(folder.path() / "pixels.txt", "0.1 3 100 200\n0.0 5 120 90\n");
  try {
    kPixelList.read(folder.path());
    FAIL() << "time went back";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("pixels.txt:2:"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace slammot
