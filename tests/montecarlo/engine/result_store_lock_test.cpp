#include "montecarlo/engine/result_store_lock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <filesystem>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "montecarlo/engine/result_store_error.h"
#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string lock_refusal(const std::filesystem::path& file) {
  try {
    const ResultStoreLock lock(file);
  } catch (const StoreError& error) {
    return error.what();
  }
  return "taken";
}

TEST(ResultStoreLock, is_held_once_and_given_back) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder / "store.lock";
  {
    const ResultStoreLock lock(file);
    EXPECT_EQ(folder.read("store.lock"), std::to_string(getpid()) + "\n");
    EXPECT_THAT(lock_refusal(file), AllOf(StartsWith(folder.path().string() + ": another process (pid " +
                                                     std::to_string(getpid()) + ") is writing there"),
                                          HasSubstr("another folder")));
    EXPECT_THAT(lock_refusal(file), HasSubstr("is writing there")) << "a refusal takes nothing away";
  }
  EXPECT_EQ(lock_refusal(file), "taken");
  EXPECT_TRUE(std::filesystem::exists(file)) << "the file stays, and means nothing by itself";
}

// Who takes back a store removes the file of its lock, which others may have open already.
TEST(ResultStoreLock, is_held_once_where_its_file_goes_and_comes) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder / "store.lock";
  std::atomic<int> holders = 0, overlaps = 0, held = 0;
  const auto hold_and_remove = [&] {
    for (int round = 0; round < 3000; ++round) {
      try {
        const ResultStoreLock lock(file);
        overlaps += holders.fetch_add(1);
        ++held;
        std::this_thread::yield();
        --holders;
        std::filesystem::remove(file);
      } catch (const StoreError&) {  // another has it
      }
    }
  };
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 4; ++i) threads.emplace_back(hold_and_remove);
  }
  EXPECT_EQ(overlaps, 0) << "of " << held;
  EXPECT_GT(held, 0);
}

TEST(ResultStoreLock, a_file_that_was_left_over_is_no_lock) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.write("store.lock", "4711000 and more than the number of now\n");
  EXPECT_EQ(lock_holder(file), std::nullopt);
  const ResultStoreLock lock(file);
  EXPECT_EQ(folder.read("store.lock"), std::to_string(getpid()) + "\n") << "nothing of before is left";
}

TEST(ResultStoreLock, goes_with_the_process_however_it_ends) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder / "store.lock";
  int ends[2] = {};
  ASSERT_EQ(pipe(ends), 0);
  const pid_t child = fork();
  if (child == 0) {
    const ResultStoreLock lock(file);
    if (write(ends[1], "x", 1) != 1) _exit(1);
    pause();
    _exit(0);
  }
  char byte = 0;
  ASSERT_EQ(read(ends[0], &byte, 1), 1);
  EXPECT_THAT(lock_refusal(file), HasSubstr("(pid " + std::to_string(child) + ")"));
  if (std::filesystem::exists("/proc/locks")) {
    EXPECT_EQ(lock_holder(file), child);
  }
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  EXPECT_EQ(lock_refusal(file), "taken");
  close(ends[0]);
  close(ends[1]);
}

TEST(ResultStoreLock, names_the_folder_in_which_no_file_can_be_made) {
  const TemporaryFolder folder;
  folder.write("plain", "x");
  EXPECT_THAT(lock_refusal(folder / "missing/store.lock"),
              AllOf(StartsWith((folder / "missing").string() + ": cannot be written to ("),
                    HasSubstr("No such file")));
  EXPECT_THAT(lock_refusal(folder / "plain/store.lock"), HasSubstr("Not a directory"));
}

TEST(ResultStoreLock, what_is_no_file_is_named_and_not_waited_for) {
  const TemporaryFolder folder;
  const std::filesystem::path pipe = folder / "pipe.lock";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(lock_refusal(pipe), pipe.string() + ": is no regular file: remove it, or name another folder");
  std::filesystem::create_directories(folder / "folder.lock");
  EXPECT_THAT(lock_refusal(folder / "folder.lock"), HasSubstr("folder.lock: is no regular file"));
}

TEST(LockHolder, knows_nothing_of_what_is_not_there_or_not_locked) {
  const TemporaryFolder folder;
  EXPECT_EQ(lock_holder(folder / "missing"), std::nullopt);
  EXPECT_EQ(lock_holder(folder.write("plain", "")), std::nullopt);
  if (!std::filesystem::exists("/proc/locks")) GTEST_SKIP() << "the system does not tell";
  const ResultStoreLock lock(folder / "one.lock");
  EXPECT_EQ(lock_holder(folder / "one.lock"), getpid());
  EXPECT_EQ(lock_holder(folder / "plain"), std::nullopt) << "of another file";
}

}  // namespace
}  // namespace credence::internal
