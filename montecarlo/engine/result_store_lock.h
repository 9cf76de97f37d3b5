#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

namespace credence::internal {

/// The process that holds the lock of this file now, as far as the system tells (/proc/locks). Takes no lock
/// itself.
std::optional<std::int64_t> lock_holder(const std::filesystem::path& file);

/// The right to write to a result store or a folder of logs, held by one process at a time through a lock
/// file there.
///
/// The lock goes with the process, however it ends; the file stays and means nothing by itself.
class ResultStoreLock {
 public:
  /// Throws StoreError naming the process that holds it, or what is wrong with the file.
  explicit ResultStoreLock(const std::filesystem::path& file);
  ~ResultStoreLock();
  ResultStoreLock(const ResultStoreLock&) = delete;
  ResultStoreLock& operator=(const ResultStoreLock&) = delete;

 private:
  int descriptor_;
};

}  // namespace credence::internal
