#pragma once

#include <filesystem>

namespace credence {

/// The right to write to a result store, held by one process at a time through a lock file beside it.
///
/// The lock goes with the process, however it ends; the file stays and means nothing by itself.
class ResultStoreLock {
 public:
  /// Throws StoreError naming the process that holds it, or why the file cannot be made.
  explicit ResultStoreLock(const std::filesystem::path& file);
  ~ResultStoreLock();
  ResultStoreLock(const ResultStoreLock&) = delete;
  ResultStoreLock& operator=(const ResultStoreLock&) = delete;

 private:
  int descriptor_;
};

}  // namespace credence
