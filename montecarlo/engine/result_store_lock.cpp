#include "montecarlo/engine/result_store_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "montecarlo/engine/result_store_error.h"

namespace credence {
namespace {

/// The process whose number stands in the file.
std::string holder(int descriptor) {
  char text[32] = {};
  const ssize_t size = pread(descriptor, text, sizeof text - 1, 0);
  std::string number(text, size > 0 ? static_cast<std::size_t>(size) : 0);
  number = number.substr(0, number.find_first_not_of("0123456789"));
  return number.empty() ? "another process" : fmt::format("another process (pid {})", number);
}

void write_own_number(int descriptor) {
  const std::string number = fmt::format("{}\n", getpid());
  // Only for the message to others: where it cannot be written, the lock holds all the same.
  if (ftruncate(descriptor, 0) != 0 || pwrite(descriptor, number.data(), number.size(), 0) < 0) return;
}

}  // namespace

ResultStoreLock::ResultStoreLock(const std::filesystem::path& file)
    : descriptor_(open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666)) {
  const std::string directory = file.parent_path().string();
  if (descriptor_ < 0) {
    throw StoreError(fmt::format("{}: cannot be written to ({})", directory, std::strerror(errno)));
  }
  if (flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
    const int reason = errno;
    const std::string text =
        reason == EWOULDBLOCK
            ? fmt::format("{} is writing there; wait for it, or use another --out", holder(descriptor_))
            : fmt::format("cannot be locked ({})", std::strerror(reason));
    close(descriptor_);
    throw StoreError(fmt::format("{}: {}", directory, text));
  }
  write_own_number(descriptor_);
}

ResultStoreLock::~ResultStoreLock() { close(descriptor_); }

}  // namespace credence
