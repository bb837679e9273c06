// The one way in which text becomes a number, whatever the file or option it stands in.
#pragma once

#include <charconv>
#include <optional>
#include <string_view>
#include <utility>

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

// What stands before and after the first `mark`; nothing after it where there is none.
inline std::pair<std::string_view, std::string_view> cut_at(char mark, std::string_view text) {
  const std::size_t at = text.find(mark);
  if (at == std::string_view::npos) return {text, {}};
  return {text.substr(0, at), text.substr(at + 1)};
}

}  // namespace slammot
