#include "reports/figures/gnuplot_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <thread>

namespace credence {
namespace {

using Clock = std::chrono::steady_clock;

// Closes a descriptor at the end of its scope.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() { reset(); }
  int get() const { return fd_; }
  bool is_open() const { return fd_ >= 0; }
  void set(int fd) {
    reset();
    fd_ = fd;
  }
  void reset() {
    if (fd_ >= 0) close(fd_);
    fd_ = -1;
  }

 private:
  int fd_ = -1;
};

// One stream between us and the program. A socket, because writing to a program that has ended must be an
// error code and no SIGPIPE in the process of our caller.
struct Stream {
  Descriptor ours, theirs;
  bool create() {
    std::array<int, 2> ends{};
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) return false;
    ours.set(ends[0]);
    theirs.set(ends[1]);
    return fcntl(ours.get(), F_SETFL, O_NONBLOCK) == 0;
  }
};

// Starts the program in a process group of its own, with default signals. Returns errno, or 0 and the id.
int start(const std::vector<std::string>& arguments, std::array<Stream, 3>& streams, pid_t& child) {
  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  posix_spawn_file_actions_init(&actions);
  posix_spawnattr_init(&attributes);
  for (int i = 0; i < 3; ++i) {
    posix_spawn_file_actions_adddup2(&actions, streams[static_cast<std::size_t>(i)].theirs.get(), i);
  }
  sigset_t none;
  sigset_t all;
  sigemptyset(&none);
  sigfillset(&all);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &all);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes,
                           POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);

  std::vector<char*> argv;
  argv.reserve(arguments.size() + 1);
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  const int error = posix_spawnp(&child, argv[0], &actions, &attributes, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  return error;
}

void feed(Stream& stream, std::string_view& input) {
  const ssize_t sent = send(stream.ours.get(), input.data(), input.size(), MSG_NOSIGNAL);
  if (sent > 0) input.remove_prefix(static_cast<std::size_t>(sent));
  const bool broken = sent < 0 && errno != EAGAIN && errno != EINTR;
  if (broken || input.empty()) stream.ours.reset();
}

void collect(Stream& stream, std::string& into) {
  std::array<char, 1 << 16> buffer{};
  const ssize_t count = read(stream.ours.get(), buffer.data(), buffer.size());
  if (count > 0) into.append(buffer.data(), static_cast<std::size_t>(count));
  const bool broken = count < 0 && errno != EAGAIN && errno != EINTR;
  if (count == 0 || broken) stream.ours.reset();
}

int milliseconds_until(Clock::time_point deadline) {
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now()).count();
  return static_cast<int>(std::clamp<long long>(left, 0, 60'000));
}

// Moves bytes until both outputs are closed; false when the time is over first.
bool converse(std::array<Stream, 3>& streams, std::string_view input, ProcessResult& result,
              Clock::time_point deadline) {
  if (input.empty()) streams[0].ours.reset();
  while (streams[1].ours.is_open() || streams[2].ours.is_open()) {
    if (Clock::now() >= deadline) return false;
    // A closed stream has the descriptor -1, which poll ignores.
    std::array<pollfd, 3> waits{{{streams[0].ours.get(), POLLOUT, 0},
                                 {streams[1].ours.get(), POLLIN, 0},
                                 {streams[2].ours.get(), POLLIN, 0}}};
    if (poll(waits.data(), waits.size(), milliseconds_until(deadline)) <= 0) continue;
    if (waits[0].revents != 0) feed(streams[0], input);
    if (waits[1].revents != 0) collect(streams[1], result.output);
    if (waits[2].revents != 0) collect(streams[2], result.errors);
  }
  return true;
}

// Waits for the end; false when the time is over first.
bool reap(pid_t child, ProcessResult& result, Clock::time_point deadline) {
  int status = 0;
  pid_t reaped = 0;
  while ((reaped = waitpid(child, &status, WNOHANG)) == 0 || (reaped < 0 && errno == EINTR)) {
    if (Clock::now() >= deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  if (reaped == child && WIFEXITED(status)) result.exit_status = WEXITSTATUS(status);
  if (reaped == child && WIFSIGNALED(status)) result.signal = WTERMSIG(status);
  return true;
}

}  // namespace

ProcessResult run_process(const std::vector<std::string>& arguments, std::string_view input,
                          std::chrono::milliseconds timeout) {
  ProcessResult result;
  const Clock::time_point deadline = Clock::now() + timeout;
  std::array<Stream, 3> streams;
  for (Stream& stream : streams) {
    if (!stream.create()) {
      result.start_error = errno;
      return result;
    }
  }
  pid_t child = -1;
  result.start_error = start(arguments, streams, child);
  if (result.start_error != 0) return result;
  for (Stream& stream : streams) stream.theirs.reset();

  if (!converse(streams, input, result, deadline) || !reap(child, result, deadline)) {
    result.timed_out = true;
    kill(-child, SIGKILL);
    waitpid(child, nullptr, 0);
  }
  return result;
}

}  // namespace credence
