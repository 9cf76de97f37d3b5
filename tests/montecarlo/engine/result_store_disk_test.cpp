#include "montecarlo/engine/result_store_disk.h"

#include <gtest/gtest.h>

#include <fcntl.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <string>

#include "montecarlo/engine/result_store.h"
#include "montecarlo/engine/result_store_error.h"
#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

/// An open file, as SQLite has its shared memory.
class OpenFile {
 public:
  explicit OpenFile(const std::filesystem::path& path)
      : descriptor_(open(path.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0600)) {}
  ~OpenFile() { close(descriptor_); }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  off_t size() const { return status().st_size; }
  off_t taken() const { return status().st_blocks * 512; }

 private:
  struct stat status() const {
    struct stat s {};
    EXPECT_EQ(fstat(descriptor_, &s), 0);
    return s;
  }
  int descriptor_;
};

constexpr off_t kShared = 32 * 1024;

TEST(ResultStoreDisk, SharedMemoryIsTakenWholeAsSoonAsItIsThere) {
  const TemporaryFolder folder;
  const auto database = folder.write("results.sqlite", "");
  const OpenFile shared(folder / "results.sqlite-shm"), log(folder / "results.sqlite-wal");
  ASSERT_EQ(shared.taken(), 0);
  reserve_shared_memory(database);
  EXPECT_EQ(shared.size(), kShared);
  EXPECT_GE(shared.taken(), kShared);
  EXPECT_EQ(log.size(), 0) << "no other file";
}

TEST(ResultStoreDisk, SharedMemoryIsFoundBehindALink) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "real");
  std::ofstream(folder / "real/results.sqlite").flush();
  std::filesystem::create_directory_symlink(folder / "real", folder / "link");
  const OpenFile shared(folder / "real/results.sqlite-shm");
  reserve_shared_memory(folder / "link/results.sqlite");
  EXPECT_EQ(shared.size(), kShared);
}

TEST(ResultStoreDisk, WhatNoOneHasOpenIsNotMade) {
  const TemporaryFolder folder;
  reserve_shared_memory(folder.write("results.sqlite", ""));
  EXPECT_EQ(folder.entries(), 1);
  reserve_shared_memory(folder / "absent.sqlite");
  EXPECT_EQ(folder.entries(), 1);
}

// /proc says of no room at all that it has none: of 0 blocks.
TEST(ResultStoreDisk, WhereTheSystemDoesNotSayThereIsRoom) {
  EXPECT_NO_THROW(require_room("/proc/results.sqlite"));
  EXPECT_NO_THROW(require_room("/no/such/folder/results.sqlite"));
  const TemporaryFolder folder;
  EXPECT_NO_THROW(require_room(folder / "results.sqlite"));
}

enum Ending : int { kFits, kFull, kSaysSomethingElse, kNoSmallDisk };

/// What `work` does in a disk of so many bytes, in a process of its own; it is given the folder.
int on_small_disk(const TemporaryFolder& folder, const std::string& size,
                  const std::function<void(const std::filesystem::path&)>& work) {
  const pid_t child = fork();
  if (child == 0) {
    if (unshare(CLONE_NEWNS) != 0 && unshare(CLONE_NEWUSER | CLONE_NEWNS) != 0) _exit(kNoSmallDisk);
    const std::string options = "size=" + size;
    if (mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
        mount("tmpfs", folder.path().c_str(), "tmpfs", 0, options.c_str()) != 0)
      _exit(kNoSmallDisk);
    try {
      work(folder.path());
    } catch (const StoreError& error) {
      const bool said =
          std::string(error.what())
              .starts_with((folder / "results.sqlite").string() + ": the disk is full: free some space");
      _exit(said ? kFull : kSaysSomethingElse);
    }
    _exit(kFits);
  }
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status));
  return WEXITSTATUS(status);
}

// 128 KB are asked for.
TEST(ResultStoreDisk, ADiskThatIsNearlyFullIsRefusedBeforeAnythingIsMade) {
  const TemporaryFolder folder;
  const auto ask = [](const std::filesystem::path& in) { require_room(in / "results.sqlite"); };
  const int large = on_small_disk(folder, "132k", ask);
  if (large == kNoSmallDisk) GTEST_SKIP() << "no disk of our own here";
  EXPECT_EQ(large, kFits);
  EXPECT_EQ(on_small_disk(folder, "124k", ask), kFull);
}

TEST(ResultStoreDisk, ADiskThatFillsUpBeforeSharedMemoryIsTakenIsSaidToBeFull) {
  const TemporaryFolder folder;
  const auto reserve = [](const std::filesystem::path& in) {
    std::ofstream(in / "results.sqlite").flush();
    const OpenFile shared(in / "results.sqlite-shm");
    reserve_shared_memory(in / "results.sqlite");
    if (shared.taken() < kShared) _exit(kSaysSomethingElse);
  };
  const int large = on_small_disk(folder, "64k", reserve);
  if (large == kNoSmallDisk) GTEST_SKIP() << "no disk of our own here";
  EXPECT_EQ(large, kFits);
  EXPECT_EQ(on_small_disk(folder, "16k", reserve), kFull);
}

TEST(ResultStoreDisk, WhatIsStoredCanBeReadFromAFullDisk) {
  const TemporaryFolder folder;
  const auto fill_and_read = [](const std::filesystem::path& in) {
    ResultStore::open_to_write(in, "1.0").require_same_scenario("[world]\n");
    std::ofstream(in / "fill") << std::string(1 << 20, 'x');
    if (has_room(in / "results.sqlite")) _exit(kFull);
    if (ResultStore::open_to_read(in).scenario() != "[world]\n") _exit(kSaysSomethingElse);
  };
  const int read = on_small_disk(folder, "512k", fill_and_read);
  if (read == kNoSmallDisk) GTEST_SKIP() << "no disk of our own here";
  EXPECT_EQ(read, kFits);
}

TEST(ResultStoreDisk, WhatIsNoRegularFileIsRefusedByItsName) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "folder");
  std::filesystem::create_symlink(folder.write("file", ""), folder / "link");
  for (const char* fine : {"file", "link", "absent"})
    EXPECT_NO_THROW(require_regular_file(folder / fine)) << fine;
  try {
    require_regular_file(folder / "folder");
    FAIL();
  } catch (const StoreError& error) {
    EXPECT_EQ(std::string(error.what()),
              (folder / "folder").string() + ": is no regular file: remove it, or name another folder");
  }
}

}  // namespace
}  // namespace credence::internal
