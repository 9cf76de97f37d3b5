#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

namespace credence::internal {

/// Finds stretches of rows that are there twice, to the last bit: in one run, as of a log that was appended
/// to itself, or in two runs at different rows, as of a copy that lacks its beginning.
///
/// Of every run the 64 smallest hashes of windows of eight rows are kept, with the rows they begin at, so
/// that memory and time do not grow with the square of rows or runs. A stretch is told where at least four of
/// them are there again at the same distance, as are all others kept that lie between, and where its rows are
/// worth 20 bits more than the pairs of rows that could agree by chance. Rows that are all zero, or as the
/// one before, do not count, nor do rows at the same place in two runs, which may start alike.
class RepeatedRows {
 public:
  void begin_run();
  /// hash: of the numbers of the row; 0 where there are none. Of rows in one order.
  void add_row(std::uint64_t hash);
  /// So many bits are known of the rows of this run so far (RunFingerprints::CoincidenceBits).
  void worth(double bits);

  /// The runs of `later` come behind those of this.
  void append(RepeatedRows later);

  /// Rows that are there twice; of one run, or of two.
  struct Stretch {
    std::size_t run = 0, other = 0;                     ///< in their order; the later one is `run`
    std::int64_t first = 0, last = 0, other_first = 0;  ///< rows, from 1
  };
  /// The longest of each run, and of each two neighbouring runs that share one.
  std::vector<Stretch> stretches() const;

 private:
  static constexpr std::size_t kKept = 64;
  static constexpr std::int64_t kWindow = 8;  ///< rows

  struct Window {
    std::int64_t row = 0, again = 0;  ///< where it is first, and then; 0: nowhere
  };
  struct Run {
    std::map<std::uint64_t, Window> windows;
    std::int64_t rows = 0;
    double bits_per_row = 0.0;
  };
  /// The same windows at two places of one distance.
  struct Match {
    std::int64_t row = 0, other = 0;
  };
  static bool enough(const Run& run, std::int64_t rows, double all_rows);

  std::vector<Run> runs_;
  // Of the run that is open:
  std::uint64_t last_ = 0, rolling_ = 0;
  std::vector<std::uint64_t> recent_;      ///< hashes of the last kWindow rows that count, in a ring
  std::vector<std::int64_t> recent_rows_;  ///< their numbers
  std::int64_t counted_ = 0;
};

}  // namespace credence::internal
