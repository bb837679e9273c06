#include "datasets/output/output_files.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>

#include "datasets/text/input_error.h"

namespace slammot {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kUnfinished = ".unfinished";
constexpr std::string_view kReplacing = ".slammot-replacing";  // stands while files are renamed

[[noreturn]] void refuse(const fs::path& file, int error) {
  throw std::runtime_error(fmt::format("{}: cannot be written: {}", file.string(),
                                       error != 0 ? std::strerror(error) : "unknown reason"));
}

// Checked after it is closed: the last bytes are written then.
void write_checked(const fs::path& to, const fs::path& name,
                   const std::function<void(std::ostream&)>& write) {
  errno = 0;
  std::ofstream stream(to, std::ios::binary);
  if (stream) write(stream);
  stream.close();
  if (!stream) refuse(name, errno);
}

bool is_special(const fs::path& file) {
  std::error_code ignored;
  const fs::file_status status = fs::status(file, ignored);
  return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

}  // namespace

OutputFiles::~OutputFiles() {
  std::error_code ignored;
  for (const auto& [unfinished, file] : files_) fs::remove(unfinished, ignored);
}

fs::path OutputFiles::aside(const fs::path& file) {
  // The program's number keeps two programs apart; the suffix stays last, where it says the format.
  const fs::path name = fmt::format("{}.{}{}{}", file.stem().string(), static_cast<int>(::getpid()),
                                    kUnfinished, file.extension().string());
  files_.emplace_back(file.parent_path() / name, file);
  return files_.back().first;
}

void OutputFiles::write(const fs::path& file, const std::function<void(std::ostream&)>& write) {
  write_checked(is_special(file) ? file : aside(file), file, write);
}

void OutputFiles::write(const fs::path& file, std::string_view text) {
  write(file, [&](std::ostream& out) {
    out.write(text.data(), static_cast<std::streamsize>(text.size()));
  });
}

void OutputFiles::put_in_place() {
  const bool several = files_.size() + left_out_.size() > 1 && !files_.empty();
  const fs::path folder = several ? files_.front().second.parent_path() : fs::path();
  const fs::path replacing = folder / kReplacing;
  std::set<fs::path> written;
  for (const auto& [unfinished, file] : files_) written.insert(file);
  if (several) {
    std::set<fs::path> all = being_replaced(folder);  // before a program was stopped
    all.insert(written.begin(), written.end());
    all.insert(left_out_.begin(), left_out_.end());
    write_checked(replacing, replacing, [&](std::ostream& out) {
      for (const fs::path& file : all) out << file.lexically_relative(folder).string() << '\n';
    });
  }
  for (const auto& [unfinished, file] : files_) {
    std::error_code error;
    fs::rename(unfinished, file, error);
    if (error) refuse(file, error.value());
  }
  files_.clear();
  for (const fs::path& file : left_out_) {
    if (!written.contains(file)) fs::remove(file);
  }
  if (several) fs::remove(replacing);
}

void write_file(const fs::path& file, const std::function<void(std::ostream&)>& write) {
  OutputFiles files;
  files.write(file, write);
  files.put_in_place();
}

void write_file(const fs::path& file, std::string_view text) {
  OutputFiles files;
  files.write(file, text);
  files.put_in_place();
}

void require_whole(const fs::path& folder) {
  if (!fs::exists(folder / kReplacing)) return;
  throw InputError(folder, 0,
                   "its files were being replaced when a program was stopped, and may be of two "
                   "outputs: write it again");
}

std::set<fs::path> being_replaced(const fs::path& folder) {
  std::set<fs::path> files;
  std::ifstream in(folder / kReplacing);
  for (std::string name; std::getline(in, name);) files.insert(folder / name);
  return files;
}

bool is_unfinished(const fs::path& file) {
  return file.filename().string().find(kUnfinished) != std::string::npos;
}

}  // namespace slammot
