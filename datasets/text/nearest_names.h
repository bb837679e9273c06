// "Did you mean": the known names nearest to a mistyped one, by edit distance.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace slammot {

int edit_distance(std::string_view a, std::string_view b);

// At most three names, nearest first, joined by ", ".
std::string nearest_names(std::string_view wrong, const std::vector<std::string>& known);

}  // namespace slammot
