// Text files of rows: read whole, cut into fields in place, numbers by from_chars. What is wrong is
// refused as InputError with file and line.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/text/number.h"

namespace slammot {

// The content of a file; throws InputError if it is missing, is a pipe or a folder, cannot be read,
// or has more than 4 GiB. What gzip has packed is unpacked, also FILE.gz where only that is there.
std::string read_text_file(const std::filesystem::path& file);

// Plain or packed.
bool is_there(const std::filesystem::path& file);

// Without the three bytes with which some editors begin a file of UTF-8.
std::string_view without_byte_order_mark(std::string_view text);

// Refuses what is not UTF-8, with its line.
void require_utf8(const std::filesystem::path& file, std::string_view text);

class TextTable {
 public:
  // `text` must outlive the table; its lines end in LF, CRLF or CR. Refuses what is not UTF-8.
  TextTable(std::filesystem::path file, std::string_view text);

  // Cuts the next line into exactly `count` fields; false after the last line.
  bool next_comma_row(size_t count);
  // The last field is the rest of the line, commas and all: the name of a file may have some.
  bool next_comma_row_and_rest(size_t count);
  // The same for fields between blanks, passing over empty lines and comments from '#'.
  bool next_blank_row(size_t count);
  bool next_blank_row();  // of any number of fields
  // Passes over empty lines and lines that begin with '#'; over one line of any kind.
  void pass_comments();
  void pass_line() { next_line(); }
  // The next line must be one of these; returns which.
  size_t expect_header(std::span<const std::string_view> headers);
  // The next line must be `first`, and after it some of `optional`, in their order; returns where
  // the fields of each begin, or 0. An optional one may be of several fields.
  std::vector<size_t> expect_header(std::string_view first,
                                    std::span<const std::string_view> optional);

  size_t fields() const { return fields_.size(); }
  std::string_view field(size_t i) const { return fields_[i]; }
  double real(size_t i) const;  // finite
  double real_or_nan(size_t i) const;
  double bounded(size_t i) const;   // at most kLargest in magnitude
  double positive(size_t i) const;  // from kSmallest to kLargest
  int count(size_t i) const;        // an integer >= 0

  int line() const { return line_; }
  void check_count(size_t count) const;  // refuses a line with another number of fields
  [[noreturn]] void refuse(const std::string& reason) const;
  void refuse_if(const std::optional<std::string>& reason) const {
    if (reason) refuse(*reason);
  }

 private:
  bool next_line();
  bool next_comma_row(size_t count, bool rest);
  std::string other_separators() const;  // that the line has, for a refusal
  double number(size_t i) const;

  std::filesystem::path file_;
  std::string_view rest_;
  std::string_view current_;
  std::vector<std::string_view> fields_;
  int line_ = 0;
  bool commas_ = false;  // between the fields of the line
};

// Three bounded numbers from field `i` on.
inline Eigen::Vector3d vector_at(const TextTable& table, size_t i) {
  return {table.bounded(i), table.bounded(i + 1), table.bounded(i + 2)};
}

}  // namespace slammot
