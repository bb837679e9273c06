// A file that one process at a time is at work on.
#pragma once

#include <filesystem>

namespace slammot {

// Of a folder whose other files are renamed when they are written: this one never is.
inline constexpr char kLockFile[] = ".slammot-lock";  // begins with kHidden of output_folder.h

class FileLock {
 public:
  // Opens the file to read and to append, and makes it if there is none. Throws
  // std::invalid_argument when another process has it, std::runtime_error when it cannot be opened.
  explicit FileLock(const std::filesystem::path& file);
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

  int descriptor() const { return descriptor_; }

 private:
  int descriptor_;
};

}  // namespace slammot
