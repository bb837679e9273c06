// Looks a name up in a table of rows that have one: landmarks, classifiers, estimators, scenarios.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace slammot {

// Throws std::invalid_argument naming what there is; `kind` is what a row is called.
template <typename Table>
const auto& find_row(const Table& table, std::string_view name, const char* kind) {
  std::string known;
  for (const auto& row : table) {
    if (row.name == name) return row;
    known += (known.empty() ? "" : ", ") + std::string(row.name);
  }
  throw std::invalid_argument("unknown " + std::string(kind) + " '" + std::string(name) +
                              "' (known: " + known + ")");
}

}  // namespace slammot
