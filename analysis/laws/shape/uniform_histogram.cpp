#include "analysis/laws/shape/uniform_histogram.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "core/nan.h"

namespace credence::internal {

UniformHistogram::UniformHistogram(std::size_t bins) : counts_(bins, 0) {
  if (bins < 2) throw std::invalid_argument(fmt::format("bins = {} must be >= 2", bins));
}

UniformHistogram::UniformHistogram(std::span<const std::int64_t> counts, std::int64_t invalid)
    : counts_(counts.begin(), counts.end()), invalid_(invalid) {
  if (counts.size() < 2) throw std::invalid_argument(fmt::format("bins = {} must be >= 2", counts.size()));
  if (invalid < 0 || std::ranges::any_of(counts, [](std::int64_t c) { return c < 0; })) {
    throw std::invalid_argument("a count of the histogram is negative");
  }
}

void UniformHistogram::add(double u) {
  if (!(u >= 0.0 && u <= 1.0)) {
    ++invalid_;
    return;
  }
  const std::size_t bins = counts_.size();
  ++counts_[std::min(bins - 1, static_cast<std::size_t>(u * static_cast<double>(bins)))];
}

void UniformHistogram::merge(const UniformHistogram& other) {
  if (other.counts_.size() != counts_.size()) {
    throw std::invalid_argument(
        fmt::format("histograms of {} and of {} bins do not merge", counts_.size(), other.counts_.size()));
  }
  for (std::size_t i = 0; i < counts_.size(); ++i) counts_[i] += other.counts_[i];
  invalid_ += other.invalid_;
}

std::int64_t UniformHistogram::count() const {
  return std::accumulate(counts_.begin(), counts_.end(), std::int64_t{0});
}

GoodnessOfFit test_uniform(const UniformHistogram& histogram) {
  GoodnessOfFit result{.count = histogram.count(),
                       .kolmogorov = kNaN,
                       .kolmogorov_p_value = kNaN,
                       .anderson = kNaN,
                       .anderson_p_value = kNaN,
                       .reason = {}};
  if (histogram.invalid() > 0) result.reason = "a value is not a number in [0, 1]";
  if (result.count == 0) result.reason = "no data";
  if (!result.reason.empty()) return result;

  const double n = static_cast<double>(result.count);
  const double bins = static_cast<double>(histogram.counts().size());
  std::int64_t below = 0;
  double largest = 0.0;
  double sum = 0.0;
  for (std::size_t i = 0; i + 1 < histogram.counts().size(); ++i) {
    below += histogram.counts()[i];
    const double u = static_cast<double>(i + 1) / bins;
    const double deviation = static_cast<double>(below) / n - u;
    largest = std::max(largest, std::abs(deviation));
    sum += deviation * deviation / (u * (1.0 - u));
  }
  result.kolmogorov = largest;
  result.kolmogorov_p_value = kolmogorov_p_value(largest, result.count);
  result.anderson = n * sum / bins;
  result.anderson_p_value = anderson_p_value(result.anderson, result.count);
  return result;
}

}  // namespace credence::internal
