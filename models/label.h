// The three labels of a landmark (thesis 3.1.3).
#pragma once

#include <string_view>

namespace slammot {

enum class Label { kUnknown, kStatic, kMoving };

constexpr std::string_view to_string(Label label) {
  constexpr std::string_view names[] = {"unknown", "static", "moving"};
  return names[static_cast<int>(label)];
}

}  // namespace slammot
