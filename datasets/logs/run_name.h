#pragma once

#include <fmt/format.h>

#include <optional>
#include <string>
#include <utility>

namespace credence::internal {

/// "run 13 of dv.csv": by the number that the file has for it, in its column `run` or as the place in its
/// arrays, from 0; the file alone where it has one run.
inline std::string run_name(const std::string& file, const std::optional<std::string>& number) {
  return number ? fmt::format("run {} of {}", *number, file) : file;
}

/// The number of a run that begins: that which its file has told of it, or its place from 0.
class RunNumber {
 public:
  void begin_file() { runs_ = 0; }
  /// Whether a run of the file has begun.
  bool any() const { return runs_ > 0; }
  /// Whether one has, and no other: at the end of the file it is named by it, whatever its number.
  bool alone() const { return runs_ == 1; }
  void tell(std::string number) { told_ = std::move(number); }
  std::string next() {
    std::string number = told_ ? *std::move(told_) : fmt::to_string(runs_);
    told_.reset();
    ++runs_;
    return number;
  }

 private:
  std::optional<std::string> told_;
  int runs_ = 0;
};

}  // namespace credence::internal
