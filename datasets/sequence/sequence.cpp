#include "datasets/sequence/sequence.h"

namespace slammot {

InputError::InputError(const std::filesystem::path& file, int line, const std::string& reason)
    : std::runtime_error(file.string() + ":" + std::to_string(line) + ": " + reason) {}

}  // namespace slammot
