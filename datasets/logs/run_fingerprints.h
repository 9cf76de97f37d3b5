#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "core/record/step.h"

namespace credence::internal {

/// Knows a run again, in another file or under another name: runs that are independent share no row of
/// numbers but by design, as the row they start from.
///
/// Of a row the bits of its errors and innovations count, in whatever order they stand; truth and covariance
/// do not, which runs may share. A run is kept as the hashes of its first 1, 2, 4, … rows, 64 bits each, so
/// that memory grows with the logarithm of its length. Two runs are the same where the longest of these
/// beginnings of one is a beginning of the other, so that a copy that was cut off is known, too; and where it
/// holds at least kLeastNumbers numbers other than zero, as coarse numbers agree by chance. Rounded copies
/// are others.
class RunFingerprints {
 public:
  static constexpr std::int64_t kLeastNumbers = 16;

  /// The runs that follow are in this file, which must outlive this.
  void begin_file(const std::filesystem::path& file);
  void begin_run();
  void add(const Step& step);

  /// The runs of `later` come behind those of this.
  void append(RunFingerprints later);

  /// Throws DataError for the first run that was there before, naming both files. O(n log n) of n runs.
  void require_distinct();

 private:
  struct Run {
    const std::filesystem::path* file = nullptr;
    std::int64_t number = 0;   ///< in its file, from 1
    std::int64_t longest = 0;  ///< rows of its longest beginning; 0: there is none
  };
  struct Beginning {
    std::uint64_t hash = 0;
    std::size_t run = 0;
    std::int64_t rows = 0;
  };

  std::vector<Run> runs_;
  std::vector<Beginning> beginnings_;
  const std::filesystem::path* file_ = nullptr;
  std::int64_t in_file_ = 0;
  // Of the run that is open:
  std::uint64_t hash_ = 0;
  std::int64_t rows_ = 0, numbers_ = 0;
};

}  // namespace credence::internal
