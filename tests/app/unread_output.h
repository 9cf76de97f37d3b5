#pragma once

#include <fcntl.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <string>

#include "tests/temporary_folder.h"

namespace credence::internal {

/// Standard output of the next process of a CommandTest, which nobody reads yet: the process waits in the
/// midst of more than a pipe holds. It is to be ended with waitpid, since its output is no file.
class UnreadOutput {
 public:
  explicit UnreadOutput(const TemporaryFolder& folder) {
    const std::string name = folder / "stdout";
    if (mkfifo(name.c_str(), 0600) == 0) pipe_ = open(name.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  }
  ~UnreadOutput() { close(pipe_); }
  UnreadOutput(const UnreadOutput&) = delete;
  UnreadOutput& operator=(const UnreadOutput&) = delete;

  /// Whether something has been written.
  bool has_begun() const {
    int size = 0;
    return ioctl(pipe_, FIONREAD, &size) == 0 && size > 0;
  }

  /// All of it, to its end.
  std::string read_all() const {
    fcntl(pipe_, F_SETFL, 0);
    std::string text;
    std::array<char, 1 << 16> buffer{};
    while (true) {
      const ssize_t size = read(pipe_, buffer.data(), buffer.size());
      if (size <= 0) return text;
      text.append(buffer.data(), static_cast<std::size_t>(size));
    }
  }

 private:
  int pipe_ = -1;
};

}  // namespace credence::internal
