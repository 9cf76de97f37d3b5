#include "analysis/laws/correlation/coarse_series.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <stdexcept>
#include <utility>

namespace credence::internal {

CoarseSeries::CoarseSeries(std::vector<double> averages, std::int64_t rows_per_value)
    : averages_(std::move(averages)), rows_per_value_(rows_per_value) {
  if (averages_.size() > kMost || rows_per_value < 1 ||
      !std::has_single_bit(static_cast<std::uint64_t>(rows_per_value))) {
    throw std::invalid_argument(fmt::format("{} averages of {} rows: at most {}, of 1, 2, 4, … rows",
                                            averages_.size(), rows_per_value, kMost));
  }
}

void CoarseSeries::add(double value) {
  sum_ += value;
  if (++rows_ < rows_per_value_) return;
  averages_.push_back(sum_ / static_cast<double>(rows_per_value_));
  sum_ = 0.0;
  rows_ = 0;
  if (averages_.size() == kMost) coarsen(2 * rows_per_value_);
}

void CoarseSeries::coarsen(std::int64_t rows_per_value) {
  for (; rows_per_value_ < rows_per_value; rows_per_value_ *= 2) {
    const std::size_t pairs = averages_.size() / 2;
    for (std::size_t i = 0; i < pairs; ++i) averages_[i] = 0.5 * (averages_[2 * i] + averages_[2 * i + 1]);
    averages_.resize(pairs);
  }
}

std::vector<std::vector<double>> averages_alike(std::span<const CoarseSeries> series) {
  std::int64_t coarsest = 1;
  for (const CoarseSeries& one : series) coarsest = std::max(coarsest, one.rows_per_value());
  std::vector<std::vector<double>> averages;
  averages.reserve(series.size());
  for (CoarseSeries one : series) {
    one.coarsen(coarsest);
    averages.push_back(one.averages());
  }
  return averages;
}

}  // namespace credence::internal
