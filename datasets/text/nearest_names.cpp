#include "datasets/text/nearest_names.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace slammot {

int edit_distance(std::string_view a, std::string_view b) {
  std::vector<int> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (size_t i = 0; i < a.size(); ++i) {
    int diagonal = std::exchange(row[0], static_cast<int>(i) + 1);
    for (size_t j = 0; j < b.size(); ++j) {
      const int substituted = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({substituted, row[j + 1] + 1, row[j] + 1});
    }
  }
  return row.back();
}

namespace {

// A key typed without its section is nearest to the keys that contain it.
int distance(std::string_view wrong, std::string_view name) {
  if (wrong.size() >= 3 && name.find(wrong) != std::string_view::npos) return 0;
  return edit_distance(wrong, name);
}

}  // namespace

std::string nearest_names(std::string_view wrong, const std::vector<std::string>& known) {
  std::vector<std::string> sorted = known;
  std::stable_sort(sorted.begin(), sorted.end(), [&](const auto& a, const auto& b) {
    return distance(wrong, a) < distance(wrong, b);
  });
  std::string text;
  for (size_t i = 0; i < std::min<size_t>(3, sorted.size()); ++i) {
    text += (i == 0 ? "" : ", ") + sorted[i];
  }
  return text;
}

}  // namespace slammot
