#include "eval/python/child_process.h"

#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "eval/python/spawn.h"

namespace slammot {

ChildProcess::ChildProcess(std::vector<std::string> words, std::vector<std::string> environment) {
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) {
    throw ChildEnded(std::string("no socket: ") + std::strerror(errno));
  }
  const int error = spawn(words, std::move(environment), ends[1], child_);
  ::close(ends[1]);
  socket_ = ends[0];
  if (error == 0) return;
  ::close(socket_);
  throw ChildEnded(words[0] + ": " + std::strerror(error));
}

ChildProcess::~ChildProcess() { end(); }

std::string ChildProcess::end() {
  if (child_ < 0) return "";
  ::close(socket_);
  int status = 0;
  while (::waitpid(child_, &status, 0) < 0 && errno == EINTR) {
  }
  child_ = -1;
  return WIFSIGNALED(status) ? "by signal " + std::to_string(WTERMSIG(status))
                             : "with exit code " + std::to_string(WEXITSTATUS(status));
}

void ChildProcess::report_end() { throw ChildEnded("the process ended " + end()); }

void ChildProcess::send(const std::string& text) {
  for (std::size_t sent = 0; sent < text.size();) {
    const ssize_t n = ::send(socket_, text.data() + sent, text.size() - sent, MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) report_end();
    sent += static_cast<std::size_t>(n);
  }
}

std::string ChildProcess::ask(const std::string& line) {
  if (child_ < 0) throw ChildEnded("the process has ended");
  send(line + "\n");
  return read_line();
}

std::string ChildProcess::read_line() {
  for (;;) {
    const std::size_t newline = received_.find('\n');
    if (newline != std::string::npos) {
      std::string line = received_.substr(0, newline);
      received_.erase(0, newline + 1);
      return line;
    }
    char buffer[1 << 16];
    const ssize_t n = ::recv(socket_, buffer, sizeof buffer, 0);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) report_end();
    received_.append(buffer, static_cast<std::size_t>(n));
  }
}

}  // namespace slammot
