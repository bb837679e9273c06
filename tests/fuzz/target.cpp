#include "tests/fuzz/target.h"

#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <stdexcept>

#include "datasets/text/input_error.h"

namespace slammot::fuzz {
namespace {

void write(const std::filesystem::path& file, std::string_view text) {
  std::ofstream(file, std::ios::binary)
      .write(text.data(), static_cast<std::streamsize>(text.size()));
}

// One line that says something.
std::string checked(std::string reason, const std::filesystem::path& folder, bool names_file) {
  const bool one_line = !reason.empty() && !has_control_character(reason) &&
                        invalid_utf8(reason) == std::string::npos;
  const bool named = !names_file || reason.starts_with(folder.string());
  if (!one_line || !named) throw std::logic_error("no message of one line with a file: " + reason);
  return reason;
}

}  // namespace

Bench::Bench(const Target& target) : target_(target) {
  const bool in_memory = std::filesystem::is_directory("/dev/shm");
  std::string pattern = std::string(in_memory ? "/dev/shm" : "/tmp") + "/slammot-fuzz-XXXXXX";
  root_ = ::mkdtemp(pattern.data());
  folder_ = root_ / "folder";
  for (const auto& [name, text] : target.files()) {
    std::filesystem::create_directories((folder_ / name).parent_path());
    write(folder_ / name, text);
  }
}

Bench::~Bench() { std::filesystem::remove_all(root_); }

std::string Bench::run(std::string_view input) const {
  write(folder_ / target_.file, input);
  try {
    target_.read(folder_);
  } catch (const InputError& error) {
    return checked(error.what(), folder_, true);
  } catch (const std::invalid_argument& error) {
    return checked(error.what(), folder_, false);
  }
  return {};
}

}  // namespace slammot::fuzz
