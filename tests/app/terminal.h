#pragma once

#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <string>

#include "tests/app/command.h"

namespace credence::internal {

/// A terminal of so many columns that nobody sits at.
class Terminal {
 public:
  explicit Terminal(unsigned short columns) : ours_(posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)) {
    if (ours_ < 0 || grantpt(ours_) != 0 || unlockpt(ours_) != 0) return;
    name_ = ptsname(ours_);
    theirs_ = open(name_.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
    const winsize size{.ws_row = 24, .ws_col = columns, .ws_xpixel = 0, .ws_ypixel = 0};
    ioctl(theirs_, TIOCSWINSZ, &size);
  }
  ~Terminal() {
    close(theirs_);
    close(ours_);
  }
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  bool is_there() const { return theirs_ >= 0; }
  const std::string& name() const { return name_; }

  /// What has been written to it so far.
  const std::string& text() {
    pollfd arrives{.fd = ours_, .events = POLLIN, .revents = 0};
    std::array<char, 4096> buffer{};
    while (poll(&arrives, 1, 0) == 1 && (arrives.revents & POLLIN) != 0) {
      const ssize_t size = ::read(ours_, buffer.data(), buffer.size());
      if (size <= 0) break;
      text_.append(buffer.data(), static_cast<std::size_t>(size));
    }
    return text_;
  }

  /// The same until a process has ended, which is still to be waited for.
  const std::string& text_until_end_of(pid_t child) {
    for (bool ended = false; !ended;) {
      siginfo_t info{};
      ended = waitid(P_PID, static_cast<id_t>(child), &info, WEXITED | WNOHANG | WNOWAIT) != 0 ||
              info.si_pid == child;
      text();
      if (!ended) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return text_;
  }

 private:
  int ours_, theirs_ = -1;
  std::string name_, text_;
};

/// Calls the binary with its output, or what it says, on a terminal.
class TerminalTest : public CommandTest {
 protected:
  void SetUp() override {
    if (!terminal_.is_there()) GTEST_SKIP() << "no pseudo-terminal";
  }

  /// `environment`: as of env; `stream`: ">" or "2>".
  pid_t start_on(const Terminal& terminal, const std::string& arguments, const std::string& stream = ">",
                 const std::string& environment = "-u NO_COLOR TERM=xterm") const {
    return start_program({"sh", "-c",
                          "exec env " + environment + " " + credence_binary().string() + " " + arguments +
                              " " + stream + " " + terminal.name()});
  }

  /// What a command writes to a terminal of its own, with the line ends of a file.
  std::string on_terminal(unsigned short columns, const std::string& arguments,
                          const std::string& environment = "-u NO_COLOR TERM=xterm") const {
    Terminal terminal(columns);
    const pid_t child = start_on(terminal, arguments, ">", environment);
    std::string text = terminal.text_until_end_of(child);
    EXPECT_EQ(finish(child).code, 0);
    std::erase(text, '\r');
    return text;
  }

 private:
  Terminal terminal_{80};
};

/// The columns that a line of UTF-8 takes, without characters of two columns.
inline std::size_t columns_of(const std::string& line) {
  return static_cast<std::size_t>(
      std::ranges::count_if(line, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

}  // namespace credence::internal
