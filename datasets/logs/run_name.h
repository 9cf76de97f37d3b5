#pragma once

#include <fmt/format.h>

#include <optional>
#include <string>

namespace credence::internal {

/// "run 13 of dv.csv": by the number that the file has for it, in its column `run` or as the place in its
/// arrays, from 0; the file alone where it has one run.
inline std::string run_name(const std::string& file, std::optional<double> number) {
  return number ? fmt::format("run {} of {}", *number, file) : file;
}

/// The number of a run that begins: that which its file has told of it, or for its second and further runs
/// their place from 0.
class RunNumber {
 public:
  void begin_file() { runs_ = 0; }
  /// Whether a run of the file has begun.
  bool any() const { return runs_ > 0; }
  void tell(double number) { told_ = number; }
  std::optional<double> next() {
    const std::optional<double> number = told_       ? told_
                                         : runs_ > 0 ? std::optional<double>(runs_)
                                                     : std::nullopt;
    told_.reset();
    ++runs_;
    return number;
  }

 private:
  std::optional<double> told_;
  int runs_ = 0;
};

}  // namespace credence::internal
