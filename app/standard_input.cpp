#include "app/standard_input.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <system_error>

#include "app/binary_frames.h"
#include "app/interrupt.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

fs::path new_folder() {
  const char* const named = std::getenv("TMPDIR");
  const std::string parent = named == nullptr || *named == '\0' ? "/tmp" : named;
  std::string pattern = parent + "/credence-XXXXXX";
  if (mkdtemp(pattern.data()) != nullptr) return pattern;
  throw std::runtime_error(
      fmt::format("{}: standard input cannot be kept there ({}); TMPDIR names another folder", parent,
                  std::strerror(errno)));
}

void copy_input(const fs::path& target) {
  std::ofstream file(target, std::ios::binary);
  std::array<char, 1 << 16> buffer{};
  pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
  while (!catch_interrupt().load()) {
    constexpr int kHearsWithinMs = 100;
    const int ready = poll(&input, 1, kHearsWithinMs);
    if (ready == 0 || (ready < 0 && errno == EINTR)) continue;
    const ssize_t size = read(STDIN_FILENO, buffer.data(), buffer.size());
    if (size < 0 && errno == EINTR) continue;
    if (size < 0)
      throw std::runtime_error(fmt::format("standard input cannot be read ({})", std::strerror(errno)));
    if (size == 0) break;
    file.write(buffer.data(), size);
  }
  file.close();
  if (!file) throw std::runtime_error(fmt::format("{}: cannot be written", target.string()));
}

/// Makes this file the standard input.
void read_from(const fs::path& file) {
  const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC);
  const bool done = descriptor >= 0 && dup2(descriptor, STDIN_FILENO) == STDIN_FILENO;
  if (!done)
    throw std::runtime_error(fmt::format("{}: cannot be read ({})", file.string(), std::strerror(errno)));
  close(descriptor);
}

}  // namespace

StandardInputFile::StandardInputFile() : folder_(new_folder()) {
  try {
    copy_input(path());
    if (!catch_interrupt().load() && holds_frames(path())) {
      frames_to_csv(path(), folder_ / "csv");
      fs::rename(folder_ / "csv", path());
    }
    read_from(path());
  } catch (...) {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
    throw;
  }
}

StandardInputFile::~StandardInputFile() {
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

std::string text_of_file(const std::string& file, const std::string& complaint) {
  // A pipe of the shell, as <(…) is one, has its writer; another one may never have.
  const bool of_shell = fs::is_fifo(file) && (file.starts_with("/dev/") || file.starts_with("/proc/"));
  if (fs::exists(file) && !fs::is_regular_file(file) && !of_shell)
    throw std::invalid_argument(file + ": is no regular file");
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw std::invalid_argument(complaint);
  constexpr std::size_t kAtOnce = std::size_t{1} << 20, kMost = std::size_t{1} << 28;
  std::string text;
  while (stream) {
    if (text.size() >= kMost)
      throw std::invalid_argument(file + ": is longer than 256 MiB, as no document is");
    const std::size_t before = text.size();
    text.resize(before + kAtOnce);
    stream.read(text.data() + before, static_cast<std::streamsize>(kAtOnce));
    text.resize(before + static_cast<std::size_t>(stream.gcount()));
  }
  return text;
}

}  // namespace credence::internal
