#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/record/step.h"
#include "datasets/logs/repeated_rows.h"
#include "datasets/logs/rounded_copies.h"

namespace credence::internal {

/// Knows a run again, in another file or under another name: runs that are independent share no row of
/// numbers but by design, as the row they start from.
///
/// Of a row the bits of its errors and innovations count, in whatever order they stand; truth and covariance
/// do not, which runs may share. A run is kept as the hashes of its first 1, 2, 4, … rows, 64 bits each, so
/// that memory grows with the logarithm of its length. Two runs are the same where the longest of these
/// beginnings of one is a beginning of the other, so that a copy that was cut off is known, too; and where it
/// is no chance that they agree (CoincidenceBits).
///
/// Numbers that agree to a few digits are no proof: where a run has one random number, as an error from the
/// start on which no noise moves, two of a thousand independent runs agree to five digits in all they hold;
/// and from two logs alone it cannot be seen that they are such runs. So copies that were rounded, and
/// stretches of rows that are there twice, are told and not refused.
class RunFingerprints {
 public:
  /// The runs that follow are in this file, which must outlive this.
  void begin_file(const std::filesystem::path& file);
  void begin_run(std::optional<std::string> number = {});
  /// The run that is open is alone in its file.
  void name_by_file() { runs_.back().number.reset(); }
  void add(const Step& step);

  /// The runs of `later` come behind those of this.
  void append(RunFingerprints later);

  /// Throws DataError for the first run that was there before, naming both files. O(n log n) of n runs.
  void require_distinct();

  /// Of a file: what is there twice, and is judged all the same.
  struct Likeness {
    std::filesystem::path file;
    std::string sentence;
  };
  /// Stretches of rows that are there twice (RepeatedRows).
  std::vector<Likeness> likenesses() const;
  /// Of all files (RoundedCopies).
  CopiedRuns copies() const;

 private:
  struct Run {
    const std::filesystem::path* file = nullptr;
    std::optional<std::string> number{};  ///< in its file (run_name.h)
    std::int64_t longest = 0;             ///< rows of its longest beginning; 0: there is none
  };
  /// Bits by which the rows so far identify their run, −log2 of the chance that an independent one has them:
  /// log2(1/p) for each number that is neither zero nor what it was in the row before, p the share of equal
  /// pairs among them (one pair more, as there may be none), less log2 of the number of orders of each row.
  /// Levels of ±1 are worth 1 bit, 16 numbers that all differ 110.
  ///
  /// An error that goes up and down by one level has a bit a row, and is taken for one of all the levels it
  /// has been on, which kEnough allows for.
  class CoincidenceBits {
   public:
    /// Of a run of which there are not enough.
    void add_row(const std::vector<double>& numbers);
    bool enough() const { return enough_; }
    static constexpr double kEnough = 100.0;

   private:
    std::vector<double> before_;
    std::unordered_map<double, std::int64_t> times_;
    std::int64_t numbers_ = 0, equal_pairs_ = 0;
    double orders_ = 0.0;  ///< bits
    bool enough_ = false;
  };
  /// As run_name; and beside another one, which may be of the same file.
  static std::string name_of(const Run& run, const std::string& file);
  static std::string name_of(const Run& run, const Run& beside);
  struct Beginning {
    std::uint64_t hash = 0;
    std::size_t run = 0;
    std::int64_t rows = 0;
  };

  std::vector<Run> runs_;
  std::vector<Beginning> beginnings_;
  const std::filesystem::path* file_ = nullptr;
  // Of the run that is open:
  std::uint64_t hash_ = 0;
  std::int64_t rows_ = 0;
  std::vector<double> row_;
  CoincidenceBits bits_;
  RepeatedRows repeated_;
  RoundedCopies rounded_;
};

}  // namespace credence::internal
