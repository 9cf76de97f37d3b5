#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace credence::internal {

/// Runs that are nearly the same as another one, and so not independent.
struct CopiedRuns {
  std::int64_t runs = 0, of = 0;  ///< so many of so many
  std::string says;               ///< of them; empty: there are none

  /// Whether they decide what is found: every test takes runs for independent, whose means scatter the more
  /// by as many as are there twice.
  bool many() const { return runs > 0 && 10 * runs >= of; }
};

/// Finds runs whose numbers are those of another one but for rounding, as of the same run in another format.
///
/// Of every run some rows are kept (the 1st, 2nd, 3rd, 4th, 6th, 8th, 12th, …), at most eight numbers of
/// each. Two runs are alike where in every row they share each number of at least half of the components, and
/// of all that vary, is the same to a fiftieth of the size of its component, which by chance would be so with
/// less than 1e-12: the share of numbers of different rows that are the same, to the power of those that
/// differ from the row before by more than a fifth of that size. Runs without noise of their own, whose
/// errors are all made by what they start with, may agree in a few random numbers: so runs are left out whose
/// numbers are a linear combination of those of up to six others, which is none of theirs with noise. Each
/// run is compared with at most 32 neighbours of its 16th row, those of fewer rows with those of as many by
/// their last kept one.
class RoundedCopies {
 public:
  void begin_run() { runs_.emplace_back(); }
  void add_row(std::span<const double> numbers);

  /// The runs of `later` come behind those of this.
  void append(RoundedCopies later);

  struct Pair {
    std::size_t run = 0, other = 0;  ///< in their order; the later one is `run`
    std::int64_t rows = 0;           ///< that both have
    double largest = 0.0;            ///< difference, as a share of the size of its component
  };
  /// One of each run that is like an earlier one.
  std::vector<Pair> pairs() const;
  /// They in a sentence, of runs by these names.
  CopiedRuns found(const std::function<std::string(std::size_t run)>& name) const;

 private:
  struct Run {
    std::int64_t rows = 0;
    std::size_t width = 0;        ///< numbers of each row; 0: they differ
    std::vector<double> numbers;  ///< of the kept rows
  };
  bool alike(const Run& a, const Run& b, Pair& pair) const;
  bool is_combination(std::size_t run, std::size_t other) const;

  std::vector<Run> runs_;
};

}  // namespace credence::internal
