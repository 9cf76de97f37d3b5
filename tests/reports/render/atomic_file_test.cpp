#include "reports/render/atomic_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <climits>
#include <string>

#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string message_of_writing(const std::filesystem::path& path) {
  try {
    write_file(path, "text");
  } catch (const OutputError& error) {
    return error.what();
  }
  return "no error";
}

/// What writing so many bytes into a folder on a disk of 64 KB says, "no error", or "no disk" where none can
/// be had.
std::string message_on_small_disk(const TemporaryFolder& folder, std::size_t bytes) {
  int pipe_ends[2];
  EXPECT_EQ(pipe(pipe_ends), 0);
  const pid_t child = fork();
  if (child == 0) {
    std::string said = "no disk";
    const bool own = unshare(CLONE_NEWNS) == 0 || unshare(CLONE_NEWUSER | CLONE_NEWNS) == 0;
    if (own && mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
        mount("tmpfs", folder.path().c_str(), "tmpfs", 0, "size=64k") == 0) {
      said = "no error";
      write_file(folder / "a.txt", "first");
      try {
        write_file(folder / "a.txt", std::string(bytes, 'x'));
      } catch (const OutputError& error) {
        said = error.what();
        if (folder.read("a.txt") != "first" || folder.entries() != 1) said = "something is left half-written";
      }
    }
    const bool told = write(pipe_ends[1], said.data(), said.size()) == std::ssize(said);
    _exit(told ? 0 : 1);
  }
  close(pipe_ends[1]);
  std::string said(1000, ' ');
  const ssize_t length = read(pipe_ends[0], said.data(), said.size());
  close(pipe_ends[0]);
  EXPECT_EQ(waitpid(child, nullptr, 0), child);
  return said.substr(0, static_cast<std::size_t>(std::max<ssize_t>(0, length)));
}

TEST(AtomicFile, AFullDiskIsSaidWithWhatToDoAndKeepsTheOldFile) {
  const TemporaryFolder folder;
  const std::string small = message_on_small_disk(folder, 1000);
  if (small == "no disk") GTEST_SKIP() << "no disk of our own here";
  EXPECT_EQ(small, "no error");
  EXPECT_EQ(
      message_on_small_disk(folder, 100'000),
      "cannot write '" + (folder / "a.txt").string() +
          "': the disk is full; no file is half written: free some space and run the same command again");
}

TEST(AtomicFile, WritesAndReplaces) {
  const TemporaryFolder folder;
  write_file(folder / "a.txt", "first");
  write_file(folder / "a.txt", "second");
  EXPECT_EQ(folder.read("a.txt"), "second");
  EXPECT_EQ(folder.entries(), 1);
}

TEST(AtomicFile, ANewFileIsNotWrittenOverOneThatCameMeanwhile) {
  const TemporaryFolder folder;
  AtomicFile file(folder / "a.txt");
  file.write("mine");
  write_new_file(folder / "a.txt", "theirs");
  EXPECT_THROW(file.commit_new(), OutputError);
  EXPECT_EQ(folder.read("a.txt"), "theirs");
  EXPECT_THROW(write_new_file(folder / "a.txt", "again"), OutputError);
  EXPECT_EQ(folder.read("a.txt"), "theirs");
}

TEST(AtomicFile, ANewFileLeavesNothingBesideIt) {
  const TemporaryFolder folder;
  write_new_file(folder / "a.txt", "text");
  EXPECT_EQ(folder.read("a.txt"), "text");
  EXPECT_EQ(folder.entries(), 1);
}

TEST(AtomicFile, WithoutCommitTheTargetKeepsWhatItHad) {
  const TemporaryFolder folder;
  write_file(folder / "a.txt", "first");
  {
    AtomicFile file(folder / "a.txt");
    file.write("half");
    EXPECT_EQ(folder.read("a.txt"), "first");
  }
  EXPECT_EQ(folder.read("a.txt"), "first");
  EXPECT_EQ(folder.entries(), 1) << "a temporary file was left";
}

TEST(AtomicFile, NamesThePathThatCannotBeWritten) {
  const TemporaryFolder folder;
  write_file(folder / "file", "x");
  EXPECT_THAT(message_of_writing(folder / "missing/a.html"),
              AllOf(HasSubstr("missing/a.html"), HasSubstr("No such")));
  EXPECT_THAT(message_of_writing(folder / "file/a.html"),
              AllOf(HasSubstr("file/a.html"), HasSubstr("directory")));
  EXPECT_THAT(message_of_writing(folder.path()),
              AllOf(HasSubstr(folder.path().string()), HasSubstr("a directory")));
  EXPECT_THAT(message_of_writing(""), HasSubstr("cannot write ''"));
}

TEST(AtomicFile, IsNotStoppedByWhatAKilledProcessOfTheSameNumberLeft) {
  const TemporaryFolder folder;
  const auto temporary = [&] {  // the one that is there
    for (const auto& entry : std::filesystem::directory_iterator(folder.path())) return entry.path();
    return std::filesystem::path();
  };
  std::string name;
  {
    const AtomicFile file(folder / "a.txt");
    name = temporary().filename().string();
  }
  const std::size_t last = name.rfind('.'), before = name.rfind('.', last - 1);
  const int number = std::stoi(name.substr(before + 1, last - before - 1));
  for (int i = 1; i <= 3; ++i) {
    folder.write(name.substr(0, before + 1) + std::to_string(number + i) + name.substr(last), "left");
  }
  write_file(folder / "a.txt", "text");
  EXPECT_EQ(folder.read("a.txt"), "text");
  EXPECT_EQ(folder.entries(), 4);
}

/// A process that has been and is gone.
pid_t gone_process() {
  const pid_t child = fork();
  if (child == 0) _exit(0);
  waitpid(child, nullptr, 0);
  return child;
}

TEST(AtomicFile, WhatKilledProcessesLeftIsRemoved) {
  const TemporaryFolder folder;
  const auto name = [](pid_t process) { return ".credence." + std::to_string(process) + ".3.tmp"; };
  const auto hour_old = [&](const std::string& of) {
    const std::filesystem::path file = folder.write(of, "half");
    std::filesystem::last_write_time(file,
                                     std::filesystem::file_time_type::clock::now() - std::chrono::hours(1));
    return file;
  };
  const pid_t gone = gone_process();
  const auto left = hour_old(name(gone)), running = hour_old(name(getpid())), other = hour_old("a.tmp"),
             longer = hour_old(name(gone) + "x");
  const auto fresh = folder.write(".credence." + std::to_string(gone) + ".4.tmp", "half");
  remove_abandoned(folder.path());
  EXPECT_FALSE(std::filesystem::exists(left));
  for (const auto& file : {running, other, longer, fresh}) EXPECT_TRUE(std::filesystem::exists(file)) << file;
  remove_abandoned(folder / "missing");
}

TEST(AtomicFile, WritesNamesAsLongAsTheyCanBe) {
  const TemporaryFolder folder;
  const std::string name(NAME_MAX, 'x');
  write_file(folder / name, "text");
  EXPECT_EQ(folder.read(name), "text");
}

TEST(AtomicFile, RefusesDevicesInsteadOfReplacingThem) {
  EXPECT_THAT(message_of_writing("/dev/null"), HasSubstr("no regular file"));
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
}

TEST(AtomicFile, WritesThroughALink) {
  const TemporaryFolder folder;
  write_file(folder / "a.txt", "first");
  std::filesystem::create_symlink(folder / "a.txt", folder / "link");
  write_file(folder / "link", "second");
  EXPECT_EQ(folder.read("a.txt"), "second");
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
}

// A limit on the size of files stands for a full disk.
TEST(AtomicFile, AFailedWriteLeavesTheOldFile) {
  const TemporaryFolder folder;
  write_file(folder / "a.txt", "first");
  rlimit old_limit{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &old_limit), 0);
  const auto old_handler = signal(SIGXFSZ, SIG_IGN);
  rlimit limit = old_limit;
  limit.rlim_cur = 1000;
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
  EXPECT_THROW(write_file(folder / "a.txt", std::string(5000, 'x')), OutputError);
  setrlimit(RLIMIT_FSIZE, &old_limit);
  signal(SIGXFSZ, old_handler);
  EXPECT_EQ(folder.read("a.txt"), "first");
  EXPECT_EQ(folder.entries(), 1);
}

}  // namespace
}  // namespace credence::internal
