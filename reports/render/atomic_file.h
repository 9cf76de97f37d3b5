#pragma once

#include <filesystem>
#include <string_view>

#include "reports/render/output_error.h"

/// @file
/// Output files appear whole or not at all.

namespace credence::internal {

/// A file written beside its target and renamed onto it by commit(); without commit() the target keeps what
/// it had. A target that exists must be a regular file (or a link to one). Every failure throws OutputError.
class AtomicFile {
 public:
  explicit AtomicFile(const std::filesystem::path& target);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(std::string_view bytes);
  /// Flushes to the disk and replaces the target.
  void commit();
  /// The same, but OutputError where the target came meanwhile; without hard links that is not known.
  void commit_new();

 private:
  [[noreturn]] void fail(int error) const;
  void synchronise() const;
  void close_committed();

  std::filesystem::path target_;
  std::filesystem::path temporary_;
  int descriptor_ = -1;
};

/// Writes `bytes` as the whole content of `target`; OutputError when it cannot.
void write_file(const std::filesystem::path& target, std::string_view bytes);

/// The same of a file that is not there; OutputError when it came meanwhile.
void write_new_file(const std::filesystem::path& target, std::string_view bytes);

/// Makes a folder and those it lies in; OutputError when it cannot.
void make_directories(const std::filesystem::path& directory);

/// Removes from a folder what processes that are gone, killed while they wrote, have left of files
/// that are a minute old or more: a younger one may be another machine's.
void remove_abandoned(const std::filesystem::path& directory);

}  // namespace credence::internal
