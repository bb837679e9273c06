// Where the tests find what is not their own; absolute paths.
#pragma once

namespace slammot::test {

extern const char* const kSourceDir;   // the checkout
extern const char* const kSharedData;  // recorded sequences, which may be absent
extern const char* const kBinary;      // the program

}  // namespace slammot::test
