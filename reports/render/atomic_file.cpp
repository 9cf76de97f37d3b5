#include "reports/render/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <system_error>

namespace credence::internal {
namespace {

// Threads of one process and several processes may write into one folder.
// A process that was killed may have left a file of any number, and this one may have got its process number;
// the target's name may be as long as names can be.
std::filesystem::path temporary_beside(const std::filesystem::path& target) {
  static std::atomic<unsigned> count{0};
  return target.parent_path() / fmt::format(".credence.{}.{}.tmp", getpid(), count++);
}

/// The process that writes a file of this name; 0: it is none of temporary_beside.
pid_t writer_of(const std::string& name) {
  int process = 0;
  unsigned number = 0;
  int end = 0;
  const bool named = std::sscanf(name.c_str(), ".credence.%d.%u.tmp%n", &process, &number, &end) == 2;
  return named && process > 0 && end == static_cast<int>(name.size()) ? process : 0;
}

/// Else a loss of power may undo the rename; where a folder cannot be synchronised there is nothing to be
/// done.
void sync_folder(const std::filesystem::path& folder) {
  const int descriptor = open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  fsync(descriptor);
  close(descriptor);
}

}  // namespace

AtomicFile::AtomicFile(const std::filesystem::path& target) : target_(target) {
  std::error_code error;
  const auto status = std::filesystem::status(target, error);
  // Renaming onto /dev/stdout or a pipe would destroy it.
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    throw OutputError(fmt::format("cannot write '{}': it exists and is {}", target.string(),
                                  std::filesystem::is_directory(status) ? "a directory" : "no regular file"));
  }
  if (std::filesystem::is_regular_file(status)) {
    const auto resolved = std::filesystem::canonical(target, error);
    if (!error) target_ = resolved;
  }
  do {
    temporary_ = temporary_beside(target_);
    descriptor_ = open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  } while (descriptor_ < 0 && errno == EEXIST);
  if (descriptor_ < 0) fail(errno);
}

AtomicFile::~AtomicFile() {
  if (descriptor_ < 0) return;
  close(descriptor_);
  unlink(temporary_.c_str());
}

void AtomicFile::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(errno);
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

void AtomicFile::synchronise() const {
  if (fsync(descriptor_) != 0) fail(errno);
}

void AtomicFile::close_committed() {
  close(descriptor_);
  sync_folder(target_.parent_path());
  descriptor_ = -1;
}

void AtomicFile::commit() {
  synchronise();
  if (rename(temporary_.c_str(), target_.c_str()) != 0) fail(errno);
  close_committed();
}

void AtomicFile::commit_new() {
  synchronise();
  if (link(temporary_.c_str(), target_.c_str()) == 0) {
    unlink(temporary_.c_str());
  } else if (errno == EEXIST || rename(temporary_.c_str(), target_.c_str()) != 0) {
    fail(errno);
  }
  close_committed();
}

void AtomicFile::fail(int error) const {
  if (error == ENOSPC || error == EDQUOT) {
    throw OutputError(fmt::format(
        "cannot write '{}': the disk is full; no file is half written: free some space and run the "
        "same command again",
        target_.string()));
  }
  throw OutputError(
      fmt::format("cannot write '{}': {}", target_.string(), std::generic_category().message(error)));
}

void write_file(const std::filesystem::path& target, std::string_view bytes) {
  AtomicFile file(target);
  file.write(bytes);
  file.commit();
}

void write_new_file(const std::filesystem::path& target, std::string_view bytes) {
  AtomicFile file(target);
  file.write(bytes);
  file.commit_new();
}

void remove_abandoned(const std::filesystem::path& directory) {
  namespace fs = std::filesystem;
  constexpr std::chrono::minutes kAge{1};
  std::error_code error;
  for (fs::directory_iterator entry(directory, error), end; !error && entry != end; entry.increment(error)) {
    const pid_t writer = writer_of(entry->path().filename().string());
    if (writer == 0 || !entry->is_regular_file(error)) continue;
    const bool gone = kill(writer, 0) != 0 && errno == ESRCH;
    if (gone && fs::file_time_type::clock::now() - entry->last_write_time(error) > kAge)
      unlink(entry->path().c_str());
  }
}

void make_directories(const std::filesystem::path& directory) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error)
    throw OutputError(fmt::format("cannot make the folder {}: {}", directory.string(), error.message()));
}

}  // namespace credence::internal
