#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "tests/paths.h"
#include "tests/temporary_folder.h"

namespace credence::internal {

/// How a call of the binary ended; a code above 128 is a signal.
struct Finished {
  int code = -1;
  std::string out, err;
};

/// Calls the built binary as a user does, in a folder of its own for each test.
class CommandTest : public ::testing::Test {
 protected:
  using Json = nlohmann::json;

  /// Scripts ignore it for what they start in the background, as these tests may be.
  CommandTest() { signal(SIGINT, SIG_DFL); }

  /// Starts the binary with its output in files. No data set is named by the environment.
  pid_t start(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), credence_binary());
    return start_program(std::move(arguments));
  }

  /// The same of any program, by its path or name.
  pid_t start_program(std::vector<std::string> arguments) const {
    const pid_t child = fork();
    if (child != 0) return child;
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    unsetenv("CREDENCE_DATA");
    redirect(STDOUT_FILENO, "stdout");
    redirect(STDERR_FILENO, "stderr");
    if (chdir(folder_.path().c_str()) == 0) execvp(argv.front(), argv.data());
    _exit(127);
  }

  Finished finish(pid_t child) const {
    int status = 0;
    waitpid(child, &status, 0);
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), read("stdout"), read("stderr")};
  }

  Finished run(const std::vector<std::string>& arguments) const { return finish(start(arguments)); }

  /// What a call says that is refused, and prints nothing.
  std::string refusal(const std::vector<std::string>& arguments) const {
    const Finished f = run(arguments);
    EXPECT_EQ(f.code, 2);
    EXPECT_EQ(f.out, "");
    return f.err;
  }

  /// The document of a call that ends with this code.
  Json json(const std::vector<std::string>& arguments, int code = 0) const {
    const Finished f = run(arguments);
    EXPECT_EQ(f.code, code) << f.err;
    return Json::parse(f.out);
  }

  /// A scenario file of the project.
  static std::string scenario_file(const std::string& name) {
    return source_folder() / "scenarios" / (name + ".toml");
  }

  static void wait_for(const std::function<bool()>& ready) {
    for (int i = 0; i < 300000 && !ready(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

  /// Until chunks have been written to the store of this folder.
  void wait_for_chunks(const std::filesystem::path& folder) const {
    wait_for([&] {
      std::error_code none;
      const std::uintmax_t size = std::filesystem::file_size(folder_ / folder / "results.sqlite-wal", none);
      return !none && size > 60000;
    });
  }

  /// Until the program catches SIGINT, as soon as it has something to save; a shell that is to become it
  /// does, too.
  static void wait_until_caught(pid_t child) {
    wait_for([&] {
      std::ifstream status("/proc/" + std::to_string(child) + "/status");
      for (std::string line; std::getline(status, line);) {
        if (line == "Name:\tsh") return false;
        if (line.starts_with("SigCgt:")) {
          return (std::stoull(line.substr(7), nullptr, 16) >> (SIGINT - 1) & 1U) != 0;
        }
      }
      return true;  // it has ended
    });
  }

  std::filesystem::path write(const std::filesystem::path& name, const std::string& text) const {
    return folder_.write(name, text);
  }
  std::string read(const std::filesystem::path& name) const { return folder_.read(name); }

  TemporaryFolder folder_;

 private:
  void redirect(int descriptor, const char* name) const {
    dup2(open((folder_ / name).c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), descriptor);
  }
};

}  // namespace credence::internal
