#include "app/interrupt.h"

#include <signal.h>
#include <unistd.h>

#include <string_view>

namespace credence::internal {
namespace {

std::atomic<bool> interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");

extern "C" void on_signal(int) {
  constexpr std::string_view kMessage = "\ncredence: ending with what is done; once more ends at once\n";
  interrupted.store(true);
  if (write(STDERR_FILENO, kMessage.data(), kMessage.size()) < 0) return;  // nobody listens
}

/// A signal that was ignored at the start, as nohup and scripts do for the background, stays so.
bool catch_signals() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction now {};
    if (sigaction(signal, nullptr, &now) == 0 && now.sa_handler == SIG_IGN) continue;
    struct sigaction once {};
    once.sa_handler = on_signal;
    once.sa_flags = SA_RESTART | static_cast<int>(SA_RESETHAND);
    sigaction(signal, &once, nullptr);
  }
  return true;
}

}  // namespace

const std::atomic<bool>& catch_interrupt() {
  static const bool caught = catch_signals();  // once, since the second signal shall end the process
  return static_cast<void>(caught), interrupted;
}

}  // namespace credence::internal
