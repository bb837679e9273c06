// Text of unknown origin: whether it is UTF-8, and how it is shown in one line of a message.
#pragma once

#include <string>
#include <string_view>

namespace slammot {

// The index of the first byte that is not UTF-8 (RFC 3629); npos if there is none.
size_t invalid_utf8(std::string_view text);

bool has_control_character(std::string_view text);

// Control characters and what is not UTF-8 as `\xNN`, so that no message has two lines or moves a
// terminal's cursor; cut where it is too long to be read.
std::string printable(std::string_view text);

// Why a name cannot name a folder of the program's output; empty if it can.
std::string folder_name_fault(std::string_view name);

}  // namespace slammot
