#include "datasets/text/printable.h"

#include <fmt/format.h>

#include <algorithm>

namespace slammot {
namespace {

constexpr size_t kLongest = 2000;     // bytes of a message
constexpr size_t kLongestName = 200;  // bytes; file systems take 255

unsigned byte_at(std::string_view text, size_t i) { return static_cast<unsigned char>(text[i]); }

bool is_control(unsigned byte) { return byte < 0x20 || byte == 0x7f; }

// The bytes of the character that begins at `i`; 0 if none does. Overlong forms, surrogates and
// what lies beyond U+10FFFF are none.
size_t character_length(std::string_view text, size_t i) {
  const unsigned first = byte_at(text, i);
  if (first < 0x80) return 1;
  const size_t length = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  if (first < 0xc2 || first > 0xf4 || i + length > text.size()) return 0;
  unsigned lowest = 0x80, highest = 0xbf;  // of the second byte
  if (first == 0xe0) lowest = 0xa0;
  if (first == 0xed) highest = 0x9f;
  if (first == 0xf0) lowest = 0x90;
  if (first == 0xf4) highest = 0x8f;
  for (size_t k = 1; k < length; ++k) {
    const unsigned byte = byte_at(text, i + k);
    if (byte < lowest || byte > highest) return 0;
    lowest = 0x80;
    highest = 0xbf;
  }
  return length;
}

}  // namespace

size_t invalid_utf8(std::string_view text) {
  for (size_t i = 0; i < text.size();) {
    const size_t length = character_length(text, i);
    if (length == 0) return i;
    i += length;
  }
  return std::string_view::npos;
}

bool has_control_character(std::string_view text) {
  return std::any_of(text.begin(), text.end(),
                     [](char c) { return is_control(static_cast<unsigned char>(c)); });
}

std::string printable(std::string_view text) {
  std::string shown;
  for (size_t i = 0; i < text.size();) {
    if (shown.size() > kLongest) return shown + "...";
    const size_t length = character_length(text, i);
    if (length == 0 || is_control(byte_at(text, i))) {
      shown += fmt::format("\\x{:02x}", byte_at(text, i));
    } else {
      shown += text.substr(i, length);
    }
    i += std::max<size_t>(length, 1);
  }
  return shown;
}

std::string folder_name_fault(std::string_view name) {
  if (name.empty() || name == "." || name == "..") return "is no name";
  if (name.find('/') != std::string_view::npos) return "names a folder and has no '/'";
  if (has_control_character(name)) return "contains a control character";
  if (name.size() > kLongestName) return fmt::format("is longer than {} bytes", kLongestName);
  return "";
}

}  // namespace slammot
