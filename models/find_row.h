// Tables of rows that have a name: landmarks, classifiers, estimators, readers, scenarios. A row is
// looked up by it, and rows of a user's own program are added at its start.
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

// Throws std::invalid_argument for a name that is taken.
template <typename Table, typename Rows>
void add_rows(Table& table, const Rows& rows, const char* kind) {
  for (const auto& added : rows) {
    for (const auto& row : table) {
      if (row.name != added.name) continue;
      throw std::invalid_argument("there is a " + std::string(kind) + " '" + std::string(row.name) +
                                  "' already");
    }
    table.push_back(added);
  }
}

}  // namespace slammot
