#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace credence::internal {

/// A series of any length in bounded memory, as its values come: averages of so many successive ones, a power
/// of two, that at most kMost are left.
class CoarseSeries {
 public:
  static constexpr std::size_t kMost = 4096;

  CoarseSeries() = default;
  /// Throws std::invalid_argument for more averages than kMost, or rows that are no power of two.
  CoarseSeries(std::vector<double> averages, std::int64_t rows_per_value);

  void add(double value);
  /// Of so many rows each, a power of two; of fewer than there are now nothing changes. What is left over at
  /// the end is left out.
  void coarsen(std::int64_t rows_per_value);

  const std::vector<double>& averages() const { return averages_; }
  std::int64_t rows_per_value() const { return rows_per_value_; }

 private:
  std::vector<double> averages_{};
  std::int64_t rows_per_value_ = 1;
  double sum_ = 0.0;  ///< of the rows of the next average, so far
  std::int64_t rows_ = 0;
};

/// The averages of several series, all of as many rows.
std::vector<std::vector<double>> averages_alike(std::span<const CoarseSeries> series);

}  // namespace credence::internal
