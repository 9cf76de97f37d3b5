#include "montecarlo/engine/result_store_disk.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/statvfs.h>

#include <cerrno>
#include <charconv>
#include <string>
#include <system_error>

#include "montecarlo/engine/result_store_error.h"

namespace credence::internal {
namespace {

constexpr off_t kSharedBytes = 32 * 1024;  ///< that SQLite makes the file at a time
constexpr double kLeastRoom = 128 * 1024;  ///< for it, the first pages and the log

[[noreturn]] void refuse(const std::filesystem::path& database) {
  throw StoreError(fmt::format("{}: {}", database.string(), kDiskIsFull));
}

}  // namespace

bool has_room(const std::filesystem::path& database) {
  struct statvfs room {};
  if (statvfs(database.parent_path().c_str(), &room) != 0 || room.f_blocks == 0) return true;
  return static_cast<double>(room.f_bavail) * static_cast<double>(room.f_frsize) >= kLeastRoom;
}

void require_room(const std::filesystem::path& database) {
  if (!has_room(database)) refuse(database);
}

// By the descriptor that SQLite has: closing one of our own would give up its locks on the file.
void reserve_shared_memory(const std::filesystem::path& database) {
  std::error_code none;
  const std::filesystem::path shared = std::filesystem::canonical(database, none).string() + "-shm";
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd", none)) {
    if (std::filesystem::read_symlink(entry.path(), none) != shared) continue;
    const std::string name = entry.path().filename().string();
    int descriptor = -1;
    std::from_chars(name.data(), name.data() + name.size(), descriptor);
    if (posix_fallocate(descriptor, 0, kSharedBytes) == ENOSPC) refuse(database);
  }
}

void require_regular_file(const std::filesystem::path& file) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status) || std::filesystem::is_regular_file(status)) return;
  throw StoreError(fmt::format("{}: is no regular file: remove it, or name another folder", file.string()));
}

}  // namespace credence::internal
