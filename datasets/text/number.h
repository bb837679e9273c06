// The one way in which text becomes a number, whatever the file or option it stands in.
#pragma once

#include <charconv>
#include <optional>
#include <string_view>

namespace slammot {

// No metre, second, pixel or sigma of a real camera lies beyond; the squares, cubes and inverses of
// what does are no numbers any more.
inline constexpr double kLargest = 1e9;
inline constexpr double kSmallest = 1e-9;

// The whole text as a number, `nan` and `inf` included; nothing if it is none or out of range.
template <typename T>
std::optional<T> parse_number(std::string_view text) {
  T value{};
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc{} || stop != end || text.empty()) return std::nullopt;
  return value;
}

}  // namespace slammot
