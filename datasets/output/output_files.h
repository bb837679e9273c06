// Files that the program writes: each aside, checked when it is closed, and renamed when all of
// them are whole. What stands under a name is therefore complete, and a full device loses nothing.
#pragma once

#include <filesystem>
#include <functional>
#include <ostream>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

namespace slammot {

class OutputFiles {
 public:
  OutputFiles() = default;
  ~OutputFiles();  // what was not put in place is gone
  OutputFiles(const OutputFiles&) = delete;
  OutputFiles& operator=(const OutputFiles&) = delete;

  // A device or a pipe is written to directly. Throws std::runtime_error that names the file.
  void write(const std::filesystem::path& file, const std::function<void(std::ostream&)>& write);
  void write(const std::filesystem::path& file, std::string_view text);
  // For what somebody else writes: the name to write to.
  std::filesystem::path aside(const std::filesystem::path& file);
  // Not part of this output, unless it is written too; an earlier one is removed.
  void leave_out(std::filesystem::path file) { left_out_.push_back(std::move(file)); }

  // Renames and removes, in the order of the calls. Several files are of the first one's folder:
  // one that is left between two of them, by a kill or an error, is known by require_whole().
  void put_in_place();

 private:
  std::vector<std::pair<std::filesystem::path, std::filesystem::path>> files_;  // aside, name
  std::vector<std::filesystem::path> left_out_;
};

// One file alone.
void write_file(const std::filesystem::path& file, const std::function<void(std::ostream&)>& write);
void write_file(const std::filesystem::path& file, std::string_view text);

// Throws InputError if files of this folder were being replaced when a program was stopped: some
// may be of the earlier output, some of the later. Writing again makes it whole.
void require_whole(const std::filesystem::path& folder);

// The files that were then being replaced or removed; none of a folder that is whole.
std::set<std::filesystem::path> being_replaced(const std::filesystem::path& folder);

// Whether this is the name of a file that was being written when a program was killed.
bool is_unfinished(const std::filesystem::path& file);

}  // namespace slammot
