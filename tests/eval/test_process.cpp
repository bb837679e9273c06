// How a program sets up its process.
#include "eval/run/process.h"

#include <gtest/gtest.h>

namespace slammot {
namespace {

// A processor with AVX-512 that OpenBLAS takes for a Haswell one; what the user states decides.
TEST(Process, BetterKernelsWhereOpenBlasDoesNotKnowTheProcessor) {
  EXPECT_EQ(better_kernels(true, "Haswell", false), "SkylakeX");
  EXPECT_EQ(better_kernels(true, "Haswell", true), std::nullopt);
  EXPECT_EQ(better_kernels(true, "SkylakeX", false), std::nullopt);  // as after the new start
  EXPECT_EQ(better_kernels(false, "Haswell", false), std::nullopt);
  EXPECT_EQ(better_kernels(false, "Zen", false), std::nullopt);
}

}  // namespace
}  // namespace slammot
