#include "app/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <initializer_list>

#include "app/say.h"
#include "app/terminal_text.h"
#include "reports/render/utf8_text.h"

namespace credence::internal {
namespace {

using Seconds = std::chrono::duration<double>;

std::string duration_text(double seconds) {
  const auto s = std::lround(seconds);
  if (s < 60) return fmt::format("{} s", s);
  if (s < 3600) return fmt::format("{}:{:02} min", s / 60, s % 60);
  return fmt::format("{}:{:02} h", s / 3600, s / 60 % 60);
}

/// With a digit behind the point where it is no whole number and small.
std::string amount_text(double amount) {
  const bool whole = amount >= 100.0 || amount == std::floor(amount);
  return whole ? fmt::format("{:.0f}", std::floor(amount)) : fmt::format("{:.1f}", amount);
}

std::string rate_text(double rate) {
  return rate < 10.0 ? fmt::format("{:.2g}", rate) : fmt::format("{:.0f}", rate);
}

/// The longest of these that a line of the terminal takes, which may have been resized.
std::string longest_that_fits(std::initializer_list<std::string> texts) {
  const std::size_t columns = terminal_width(STDERR_FILENO);
  for (const std::string& text : texts) {
    if (columns == 0 || display_width(text) < columns) return text;
  }
  return {};
}

std::string bar(double share) {
  constexpr int kWidth = 30;
  const int filled = static_cast<int>(share * kWidth);
  std::string text;
  for (int i = 0; i < kWidth; ++i) text += i < filled ? "█" : "·";
  return text;
}

}  // namespace

ProgressDisplay::ProgressDisplay(const std::string& what, bool quiet, std::string unit)
    : what_(printable_line(what)),
      unit_(std::move(unit)),
      quiet_(quiet),
      terminal_(isatty(STDERR_FILENO) == 1) {}

ProgressDisplay::~ProgressDisplay() {
  if (shown_ && terminal_) std::fputs("\r\x1b[K", stderr);
}

void ProgressDisplay::show(const StudyProgress& p) {
  constexpr Seconds kSilence{2.0};
  if (quiet_) return;
  const Clock::time_point now = Clock::now();
  const Seconds elapsed = now - begin_;
  const Seconds interval{terminal_ ? 0.1 : 5.0};
  if (elapsed < kSilence || (shown_ && Seconds(now - last_) < interval)) return;
  last_ = now;
  shown_ = true;
  const double begun = static_cast<double>(p.runs_done) + p.runs_in_hand;
  const double rate = begun / elapsed.count();
  const std::int64_t done = p.runs_done + p.runs_stored;
  if (p.runs_total == 0) {
    const std::string reached = amount_text(static_cast<double>(done) + p.runs_in_hand);
    put({fmt::format("{}: {} {} in {}", what_, reached, unit_, duration_text(elapsed.count())),
         fmt::format("{} {}", reached, unit_)});
    return;
  }
  const auto total = static_cast<double>(p.runs_total);
  const double reached = std::min(total, static_cast<double>(done) + p.runs_in_hand), share = reached / total;
  const auto percent = static_cast<int>(100.0 * share);
  std::string numbers = fmt::format("{} of {} {}", static_cast<std::int64_t>(reached), p.runs_total, unit_);
  if (begun > 0.0) {
    numbers +=
        fmt::format(", {} {}/s, {} left", rate_text(rate), unit_, duration_text((total - reached) / rate));
  }
  if (terminal_) {
    put({fmt::format("{} {} {}", what_, bar(share), numbers), fmt::format("{} {}", what_, numbers), numbers,
         fmt::format("{} %", percent)});
  } else {
    put({fmt::format("{}: {} %, {}", what_, percent, numbers)});
  }
}

void ProgressDisplay::put(std::initializer_list<std::string> texts) {
  if (terminal_) {
    std::fputs(fmt::format("\r{}\x1b[K", longest_that_fits(texts)).c_str(), stderr);
  } else {
    say(*texts.begin());
  }
}

}  // namespace credence::internal
