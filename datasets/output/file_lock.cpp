#include "datasets/output/file_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace slammot {

FileLock::FileLock(const std::filesystem::path& file)
    : descriptor_(::open(file.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0644)) {
  if (descriptor_ >= 0 && ::flock(descriptor_, LOCK_EX | LOCK_NB) == 0) return;
  const int error = errno;
  if (descriptor_ >= 0) ::close(descriptor_);
  if (descriptor_ >= 0 && error == EWOULDBLOCK) {
    throw std::invalid_argument(file.string() + ": another process is at work on it");
  }
  throw std::runtime_error(file.string() + ": " + std::strerror(error));
}

FileLock::~FileLock() { ::close(descriptor_); }

}  // namespace slammot
