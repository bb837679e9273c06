#include "tests/paths.h"

namespace slammot::test {

const char* const kSourceDir = SLAMMOT_SOURCE_DIR;
const char* const kSharedData = SLAMMOT_SHARED_DATA;
const char* const kBinary = SLAMMOT_BINARY;

}  // namespace slammot::test
