#include "analysis/tuning/noise_scale.h"

#include <algorithm>
#include <cmath>

#include "analysis/laws/chi_square/chi_square_truncated.h"
#include "analysis/laws/mean/effective_sample.h"
#include "analysis/laws/mean/hall_score.h"
#include "analysis/laws/scores/rmse_interval.h"
#include "analysis/tuning/stretches.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

constexpr std::int64_t kFewLong = 5;
constexpr double kMostParts = 20.0;       // of stretches; more narrow the interval little, and are shorter
constexpr double kTimesAPart = 12.0;      // correlation times, which the record underestimates
constexpr double kLeastTimesAPart = 2.5;  // of few long ones

/// The scale c with E[c X | c X ≤ gate] = mean, X ~ χ²(dof); the largest that a gate allows when there is
/// none.
double scale_of_mean(double mean, double dof, double gate) {
  if (!std::isfinite(gate) || !std::isfinite(mean)) return mean / dof;
  const auto cut_mean = [&](double c) { return c * truncated_chi_square_cumulants(dof, gate / c).mean; };
  double low = 1e-6 * mean / dof, high = 2.0 * mean / dof;
  constexpr double kLargest = 1e4;
  while (cut_mean(high) < mean && high < kLargest) high *= 2.0;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (cut_mean(middle) < mean ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// How many stretches to cut each run into: of kTimesAPart correlation times if that gives ten in all, and no
/// more than kMostParts in all, else five of each.
std::vector<std::int64_t> stretch_counts(NisOfRuns runs) {
  const EffectiveSample sample = effective_sample(runs);
  std::vector<std::int64_t> many(runs.size(), 0), few(runs.size(), 0);
  if (!sample.reason.empty()) return few;
  const double time = sample.correlation_time;
  double values = 0.0;
  for (const std::vector<double>& run : runs) values += static_cast<double>(run.size());
  std::int64_t possible = 0;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const auto length = static_cast<double>(runs[r].size());
    const double most = std::max(1.0, std::round(kMostParts * length / values));
    many[r] = static_cast<std::int64_t>(std::min(most, length / (kTimesAPart * time)));
    if (length >= kLeastTimesAPart * static_cast<double>(kFewLong) * time) few[r] = kFewLong;
    possible += many[r];
  }
  return possible >= kFewestStretches ? many : few;
}

struct NisStretch {
  double sum = 0.0, count = 0.0;
};

/// Nearly independent parts that hold every value: of many runs these, else stretches of them. Of several
/// runs one that is too short to be cut is a part as it is.
std::vector<NisStretch> nis_stretches(NisOfRuns runs) {
  const auto has_values = [](const std::vector<double>& run) { return !run.empty(); };
  const std::int64_t used = std::ranges::count_if(runs, has_values);
  const std::int64_t least = used > 1 ? 1 : 0;
  const std::vector<std::int64_t> counts = stretch_counts(runs);
  std::vector<NisStretch> parts;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const std::span<const double> nis = runs[r];
    const auto count = static_cast<std::size_t>(used >= kFewestStretches ? 1 : std::max(least, counts[r]));
    for (std::size_t i = 0; i < count && !nis.empty(); ++i) {
      const std::size_t first = i * nis.size() / count, length = (i + 1) * nis.size() / count - first;
      const std::span<const double> part = nis.subspan(first, length);
      parts.push_back({average_of(part) * static_cast<double>(length), static_cast<double>(length)});
    }
  }
  return parts;
}

/// The mean of all values as that of independent ones with its variance, as which parts of different length
/// estimate it: a ratio of sums, whose variance is to first order. They count for as many as there would be
/// of one length, and are as skewed as the means of the parts.
SkewedMoments mean_over(std::span<const NisStretch> parts) {
  double sum = 0.0, count = 0.0, square = 0.0, spread = 0.0;
  for (const NisStretch& part : parts) {
    sum += part.sum;
    count += part.count;
    square += part.count * part.count;
  }
  SkewedMoments moments{.count = 0, .mean = sum / count}, means;
  if (parts.size() < 2) return moments;
  for (const NisStretch& part : parts) {
    spread += std::pow(part.sum - moments.mean * part.count, 2);
    means.add(part.sum / part.count);
  }
  const auto k = static_cast<double>(parts.size());
  moments.count = std::llround(count * count / square);
  const auto worth = static_cast<double>(moments.count);
  moments.m2 = k / (k - 1.0) * spread / (count * count) * worth * (worth - 1.0);
  if (moments.count > 0) moments.m3 = sample_skewness(means) * std::pow(moments.m2, 1.5) / std::sqrt(worth);
  return moments;
}

}  // namespace

NoiseScale noise_scale(NisOfRuns runs, double dof, double gate, double confidence) {
  NoiseScale result{.lower = kNaN, .upper = kNaN};
  double sum = 0.0, count = 0.0;
  for (const std::vector<double>& run : runs) {
    for (const double x : run) sum += x;
    count += static_cast<double>(run.size());
  }
  result.scale = scale_of_mean(sum / count, dof, gate);
  const std::vector<NisStretch> parts = nis_stretches(runs);
  const SkewedMoments mean = mean_over(parts);
  if (mean.count < kFewLong) {
    result.reason = "the recording is too short for its correlation in time";
    return result;
  }
  // In few skewed parts the large ones may be missing: the upper end is the further one of two that remove
  // the skewness.
  const MeanInterval interval = mean_square_interval(mean, confidence);
  result.reason = interval.reason;
  if (!interval.reason.empty()) return result;
  result.lower = scale_of_mean(interval.lower, dof, gate);
  result.upper = scale_of_mean(interval.upper, dof, gate);
  result.stretches = std::ssize(parts);
  return result;
}

}  // namespace credence::internal
