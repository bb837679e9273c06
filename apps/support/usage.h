// What is said of a command line that cannot be understood: one line, with the nearest names.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>

namespace slammot {

// `app` as it was left by the parse that threw `error`.
std::string usage_error(const CLI::App& app, const CLI::ParseError& error);

// A whole number, at least this one. CLI11's own checks take -1 for a very large number, or name a
// range of 300 digits.
CLI::Validator whole_number_from(std::uint64_t least);

}  // namespace slammot
