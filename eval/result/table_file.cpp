#include "eval/result/table_file.h"

#include <charconv>
#include <cmath>
#include <fstream>
#include <utility>

#include "datasets/sequence/sequence.h"

namespace slammot {
namespace {

std::vector<std::string> split(const std::string& line, char separator) {
  std::vector<std::string> fields(1);
  for (const char c : line) {
    if (c == '\r') continue;
    if (c != separator) {
      fields.back() += c;
    } else if (separator != ' ' || !fields.back().empty()) {
      fields.emplace_back();
    }
  }
  if (separator == ' ' && fields.back().empty()) fields.pop_back();
  return fields;
}

template <typename T>
T parse(const std::filesystem::path& file, const TableRow& row, size_t field) {
  const std::string& text = row.fields[field];
  T value{};
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc{} || stop != end) {
    throw InputError(file, row.line, "'" + text + "' is not a number");
  }
  return value;
}

}  // namespace

std::vector<TableRow> read_table(const std::filesystem::path& file, char separator, size_t columns,
                                 bool has_header) {
  std::ifstream stream(file);
  if (!stream) throw InputError(file, 0, "cannot be read");
  std::vector<TableRow> rows;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    if (line.empty() || line == "\r" || line.front() == '#') continue;
    if (std::exchange(has_header, false)) continue;
    TableRow row{number, split(line, separator)};
    if (row.fields.size() != columns) {
      throw InputError(file, number,
                       "has " + std::to_string(row.fields.size()) + " fields instead of " +
                           std::to_string(columns));
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

double real_field(const std::filesystem::path& file, const TableRow& row, size_t field,
                  bool nan_allowed) {
  const double value = parse<double>(file, row, field);
  if (!std::isfinite(value) && !(nan_allowed && std::isnan(value))) {
    throw InputError(file, row.line, "'" + row.fields[field] + "' is not a finite number");
  }
  return value;
}

int integer_field(const std::filesystem::path& file, const TableRow& row, size_t field) {
  return parse<int>(file, row, field);
}

}  // namespace slammot
