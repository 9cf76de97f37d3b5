#include "montecarlo/engine/result_store_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string>

#include "montecarlo/engine/result_store_disk.h"
#include "montecarlo/engine/result_store_error.h"

namespace credence::internal {
namespace {

void write_own_number(int descriptor) {
  const std::string number = fmt::format("{}\n", getpid());
  // Only for the message to others: where it cannot be written, the lock holds all the same.
  if (ftruncate(descriptor, 0) != 0 || pwrite(descriptor, number.data(), number.size(), 0) < 0) return;
}

/// The number that stands in the file; empty: none yet.
std::string written_number(int descriptor) {
  char text[32] = {};
  const ssize_t size = pread(descriptor, text, sizeof text - 1, 0);
  std::string number(text, size > 0 ? static_cast<std::size_t>(size) : 0);
  return number.substr(0, number.find_first_not_of("0123456789"));
}

/// Whether the file still has its name: who takes a new store back removes its lock before giving it back.
bool has_name(int descriptor, const std::filesystem::path& file) {
  struct stat ours {
  }, named{};
  return fstat(descriptor, &ours) == 0 && stat(file.c_str(), &named) == 0 && ours.st_dev == named.st_dev &&
         ours.st_ino == named.st_ino;
}

/// Who holds the lock: as the system knows it, else (a lock of another machine) as it says in the file.
std::string holder(int descriptor, const std::filesystem::path& file) {
  const std::optional<std::int64_t> process = lock_holder(file);
  const std::string number = process.value_or(0) > 0 ? fmt::to_string(*process) : written_number(descriptor);
  return number.empty() ? "another process" : fmt::format("another process (pid {})", number);
}

/// The file, made where it is missing, with the lock on it.
int locked(const std::filesystem::path& file) {
  require_regular_file(file);
  const std::string directory = file.parent_path().string();
  const int descriptor = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor < 0) {
    throw StoreError(fmt::format("{}: cannot be written to ({})", directory, std::strerror(errno)));
  }
  if (flock(descriptor, LOCK_EX | LOCK_NB) == 0) return descriptor;
  const int reason = errno;
  const std::string text =
      reason == EWOULDBLOCK
          ? fmt::format("{} is writing there; wait for it, or name another folder", holder(descriptor, file))
          : fmt::format("cannot be locked ({})", std::strerror(reason));
  close(descriptor);
  throw StoreError(fmt::format("{}: {}", directory, text));
}

}  // namespace

std::optional<std::int64_t> lock_holder(const std::filesystem::path& file) {
  struct stat status {};
  if (stat(file.c_str(), &status) != 0) return std::nullopt;
  const std::string inode = fmt::format(":{}", status.st_ino);
  std::ifstream locks("/proc/locks");
  // "1: FLOCK ADVISORY WRITE 4711 fe:01:123456 0 EOF"
  for (std::string line; std::getline(locks, line);) {
    std::istringstream words(line);
    std::string number, kind, advisory, access, place;
    std::int64_t process = 0;
    if (!(words >> number >> kind >> advisory >> access >> process >> place)) continue;
    if (kind == "FLOCK" && access == "WRITE" && place.ends_with(inode)) return process;
  }
  return std::nullopt;
}

ResultStoreLock::ResultStoreLock(const std::filesystem::path& file) : descriptor_(locked(file)) {
  while (!has_name(descriptor_, file)) {
    close(descriptor_);
    descriptor_ = locked(file);
  }
  write_own_number(descriptor_);
}

ResultStoreLock::~ResultStoreLock() { close(descriptor_); }

}  // namespace credence::internal
