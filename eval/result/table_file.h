// Lines of a text table split into fields, with the line number for errors. `#` starts a comment
// line.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace slammot {

struct TableRow {
  int line = 0;
  std::vector<std::string> fields;
};

// Throws InputError if the file cannot be read or a row has not `columns` fields. A separator of '
// ' stands for any run of spaces.
std::vector<TableRow> read_table(const std::filesystem::path& file, char separator, size_t columns,
                                 bool has_header);

// Throw InputError naming the line. A real may be `nan` only where that is allowed.
double real_field(const std::filesystem::path& file, const TableRow& row, size_t field,
                  bool nan_allowed = false);
int integer_field(const std::filesystem::path& file, const TableRow& row, size_t field);

}  // namespace slammot
