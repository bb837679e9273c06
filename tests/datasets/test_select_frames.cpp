// Which frames of a sequence are used, and what is stated of the camera before the first of them.
#include <gtest/gtest.h>

#include "datasets/native/native_reader.h"
#include "tests/datasets/fixture.h"

namespace slammot {
namespace {

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

}  // namespace
}  // namespace slammot
