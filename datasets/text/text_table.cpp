#include "datasets/text/text_table.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <memory>

#include "datasets/text/input_error.h"

namespace slammot {
namespace {

constexpr std::uintmax_t kMostBytes = std::uintmax_t{4} << 30;  // of a file that is read whole

std::filesystem::path packed(std::filesystem::path file) { return file += ".gz"; }

std::string unpacked(const std::filesystem::path& file) {
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> stream(gzopen(file.c_str(), "rb"), gzclose);
  if (!stream) throw InputError(file, 0, "cannot be read");
  std::string text;
  char part[1 << 16];
  int got = 0, fault = Z_OK;
  while (text.size() <= kMostBytes && (got = gzread(stream.get(), part, sizeof part)) > 0) {
    text.append(part, static_cast<std::size_t>(got));
  }
  gzerror(stream.get(), &fault);  // also of a file that ends too early
  if (got < 0 || fault < 0) throw InputError(file, 0, "cannot be unpacked: damaged or cut off");
  if (text.size() > kMostBytes) throw InputError(file, 0, "cannot be read: larger than 4 GiB");
  return text;
}

}  // namespace

bool is_there(const std::filesystem::path& file) {
  return std::filesystem::exists(file) || std::filesystem::exists(packed(file));
}

std::string read_text_file(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) {
    if (!std::filesystem::exists(packed(file), ignored)) throw InputError(file, 0, "no such file");
    return read_text_file(packed(file));
  }
  if (!std::filesystem::is_regular_file(file, ignored)) {
    throw InputError(file, 0, "cannot be read: not a regular file");  // a pipe would block
  }
  std::ifstream stream(file, std::ios::binary);
  std::string text;
  if (stream) {
    const std::uintmax_t bytes = std::filesystem::file_size(file);
    if (bytes > kMostBytes) throw InputError(file, 0, "cannot be read: larger than 4 GiB");
    text.resize(bytes);
    stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  }
  if (!stream) throw InputError(file, 0, "cannot be read");
  return text.starts_with("\x1f\x8b") ? unpacked(file) : text;
}

std::string_view without_byte_order_mark(std::string_view text) {
  constexpr std::string_view kMark = "\xef\xbb\xbf";
  return text.starts_with(kMark) ? text.substr(kMark.size()) : text;
}

void require_utf8(const std::filesystem::path& file, std::string_view text) {
  const size_t bad = invalid_utf8(text);
  if (bad == std::string_view::npos) return;
  const auto line = std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(bad), '\n');
  throw InputError(file, static_cast<int>(line) + 1, "is not UTF-8");
}

TextTable::TextTable(std::filesystem::path file, std::string_view text)
    : file_(std::move(file)), rest_(without_byte_order_mark(text)) {
  require_utf8(file_, text);
}

void TextTable::refuse(const std::string& reason) const { throw InputError(file_, line_, reason); }

bool TextTable::next_line() {
  if (rest_.empty()) return false;
  const size_t newline = rest_.find('\n');
  const size_t end = std::min(rest_.substr(0, newline).find('\r'), newline);
  current_ = rest_.substr(0, end);
  rest_.remove_prefix(std::min(end, rest_.size()));
  rest_.remove_prefix(rest_.starts_with("\r\n") ? 2 : std::min<size_t>(1, rest_.size()));
  ++line_;
  return true;
}

std::string TextTable::other_separators() const {
  std::string others;
  for (const auto& [mark, name] : {std::pair(',', "commas"), {';', "semicolons"}, {'\t', "tabs"}}) {
    const bool is_right = commas_ ? mark == ',' : mark == '\t';
    if (!is_right && current_.find(mark) != std::string_view::npos) others = name;
  }
  if (others.empty() && commas_ && current_.find(' ') != std::string_view::npos) others = "blanks";
  if (others.empty()) return "";
  return fmt::format("; {} are expected between fields where there are {}",
                     commas_ ? "commas" : "blanks", others);
}

void TextTable::check_count(size_t count) const {
  if (fields_.size() == count) return;
  refuse(fmt::format("expected {} fields, found {}{}", count, fields_.size(), other_separators()));
}

bool TextTable::next_comma_row(size_t count, bool rest) {
  if (!next_line()) return false;
  commas_ = true;
  fields_.clear();
  for (std::string_view left = current_;;) {
    const bool last = rest && fields_.size() + 1 == count;
    const size_t comma = last ? std::string_view::npos : left.find(',');
    fields_.push_back(left.substr(0, comma));
    if (comma == std::string_view::npos) break;
    left.remove_prefix(comma + 1);
  }
  check_count(count);
  return true;
}

bool TextTable::next_comma_row(size_t count) { return next_comma_row(count, false); }

bool TextTable::next_comma_row_and_rest(size_t count) { return next_comma_row(count, true); }

bool TextTable::next_blank_row() {
  constexpr std::string_view blanks = " \t";
  do {
    if (!next_line()) return false;
    current_ = current_.substr(0, current_.find('#'));
  } while (current_.find_first_not_of(blanks) == std::string_view::npos);
  commas_ = false;
  fields_.clear();
  for (size_t begin = current_.find_first_not_of(blanks); begin != std::string_view::npos;) {
    const size_t end = current_.find_first_of(blanks, begin);
    fields_.push_back(current_.substr(begin, end - begin));
    begin = current_.find_first_not_of(blanks, end);
  }
  return true;
}

bool TextTable::next_blank_row(size_t count) {
  if (!next_blank_row()) return false;
  check_count(count);
  return true;
}

void TextTable::pass_comments() {
  while (!rest_.empty() && (rest_[0] == '#' || rest_[0] == '\n' || rest_[0] == '\r')) {
    next_line();
  }
}

size_t TextTable::expect_header(std::span<const std::string_view> headers) {
  const bool any = next_line();
  for (size_t i = 0; i < headers.size(); ++i) {
    if (any && current_ == headers[i]) return i;
  }
  line_ = 1;
  refuse(fmt::format("the first line must be '{}'", fmt::join(headers, "' or '")));
}

std::vector<size_t> TextTable::expect_header(std::string_view first,
                                             std::span<const std::string_view> optional) {
  const auto fields_of = [](std::string_view text) {
    return static_cast<size_t>(std::ranges::count(text, ',')) + 1;
  };
  std::vector<size_t> places;
  std::string_view rest = next_line() ? current_ : std::string_view();
  bool is_known = rest.starts_with(first);
  if (is_known) rest.remove_prefix(first.size());
  size_t next = fields_of(first);
  for (const std::string_view column : optional) {
    const std::string with_comma = fmt::format(",{}", column);
    const bool is_here = is_known && rest.starts_with(with_comma) &&
                         (rest.size() == with_comma.size() || rest[with_comma.size()] == ',');
    places.push_back(is_here ? next : 0);
    if (!is_here) continue;
    rest.remove_prefix(with_comma.size());
    next += fields_of(column);
  }
  if (is_known && rest.empty()) return places;
  line_ = 1;
  refuse(fmt::format("the first line must be '{}', and after it what there is of ',{}'", first,
                     fmt::join(optional, "' ',")));
}

double TextTable::number(size_t i) const {
  const auto value = parse_number<double>(fields_[i]);
  if (!value) {
    const bool has_mark = fields_[i].find_first_of(",;") != std::string_view::npos;
    refuse(fmt::format("'{}' is not a number{}", fields_[i], has_mark ? other_separators() : ""));
  }
  return *value;
}

double TextTable::real(size_t i) const {
  const double value = number(i);
  if (!std::isfinite(value)) refuse(fmt::format("'{}' is not a finite number", fields_[i]));
  return value;
}

double TextTable::real_or_nan(size_t i) const {
  const double value = number(i);
  return std::isnan(value) ? value : real(i);
}

double TextTable::bounded(size_t i) const {
  const double value = real(i);
  if (!(std::abs(value) <= kLargest)) refuse(fmt::format("'{}' is not plausible", fields_[i]));
  return value;
}

double TextTable::positive(size_t i) const {
  const double value = bounded(i);
  if (!(value > 0.0)) refuse(fmt::format("'{}' is not greater than zero", fields_[i]));
  if (value < kSmallest) refuse(fmt::format("'{}' is not plausible", fields_[i]));
  return value;
}

int TextTable::count(size_t i) const {
  const auto value = parse_number<int>(fields_[i]);
  if (!value) refuse(fmt::format("'{}' is not a whole number", fields_[i]));
  if (*value < 0) refuse(fmt::format("'{}' is negative", fields_[i]));
  return *value;
}

}  // namespace slammot
