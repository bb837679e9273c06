// What is fuzzed: a folder of good files, of which one is replaced by the input, and its reader.
//
// A reader takes the input or refuses it by InputError, or std::invalid_argument, in one line. It
// never crashes, and no number of what it returns is NaN or infinite where none may be.
#pragma once

#include <filesystem>
#include <map>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

namespace slammot::fuzz {

using Files = std::map<std::string, std::string>;

struct Target {
  std::string_view name;
  Files (*files)();
  std::string_view file;  // that is replaced
  // Throws std::logic_error for a result that is none.
  void (*read)(const std::filesystem::path& folder);
};

// Of what a reader has returned.
inline void require(bool holds, const char* what) {
  if (!holds) throw std::logic_error(what);
}

std::span<const Target> dataset_targets();
std::span<const Target> result_targets();

// A folder in memory, written once, with one target's files.
class Bench {
 public:
  explicit Bench(const Target& target);
  ~Bench();
  Bench(const Bench&) = delete;
  Bench& operator=(const Bench&) = delete;

  // The reason of a refusal; empty where the input was taken.
  std::string run(std::string_view input) const;
  std::string good() const { return target_.files().at(std::string(target_.file)); }

 private:
  const Target& target_;
  std::filesystem::path root_;    // that is removed
  std::filesystem::path folder_;  // some layouts look beside the folder they read
};

}  // namespace slammot::fuzz
