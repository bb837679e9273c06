// An output that cannot be written is found before anything is computed.
#pragma once

#include <filesystem>

namespace slammot {

// Throws std::invalid_argument with the reason. What is made to find out is removed again.
void require_writable_folder(const std::filesystem::path& folder);
void require_writable_file(const std::filesystem::path& file);

}  // namespace slammot
