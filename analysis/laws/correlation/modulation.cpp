#include "analysis/laws/correlation/modulation.h"

#include <algorithm>
#include <boost/math/special_functions/beta.hpp>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <numeric>
#include <vector>

#include "analysis/laws/correlation/fourier.h"
#include "analysis/laws/correlation/thinned_series.h"
#include "montecarlo/engine/moments.h"

namespace credence::internal {
namespace {

constexpr std::size_t kFewestFrequencies = 64, kOnEachSide = 16;

/// The places of the values by their size, between −½ and ½; of equal ones their mean.
std::vector<double> ranks_of(std::span<const double> values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return values[i]; });
  std::vector<double> ranks(values.size());
  for (std::size_t from = 0, to = 0; from < order.size(); from = to) {
    while (to < order.size() && values[order[to]] == values[order[from]]) ++to;
    const double rank = 0.5 * static_cast<double>(from + to) / static_cast<double>(order.size()) - 0.5;
    for (std::size_t i = from; i < to; ++i) ranks[order[i]] = rank;
  }
  return ranks;
}

double autocorrelation(const std::vector<double>& u, std::size_t lag) {
  double product = 0.0, square = 0.0;
  for (std::size_t k = 0; k < u.size(); ++k) {
    square += u[k] * u[k];
    if (k >= lag) product += u[k] * u[k - lag];
  }
  return product / square;
}

/// Divides by the spectrum of the short memory of the ranks.
void whiten(const std::vector<double>& ranks, std::vector<double>& powers) {
  constexpr double kClearly = 3.0, kLongest = 200.0;  // standard errors; over N
  const auto n = static_cast<double>(ranks.size());
  const double first = autocorrelation(ranks, 1);
  if (!(first * std::sqrt(n) > kClearly)) return;
  const double second = autocorrelation(ranks, 2), third = autocorrelation(ranks, 3);
  const double rho = std::max(first, std::min((second + third) / (first + second), 1.0 - kLongest / n)),
               a = first / rho;
  for (std::size_t j = 0; j < powers.size(); ++j) {
    const double omega = 2.0 * std::numbers::pi * static_cast<double>(j + 1) / n;
    powers[j] /= 1.0 - a + a * (1.0 - rho * rho) / (1.0 - 2.0 * rho * std::cos(omega) + rho * rho);
  }
}

double total_of(std::span<const double> values) { return std::accumulate(values.begin(), values.end(), 0.0); }

/// That the mean of k exponential values is so many times that of n others, or more.
double upper_f(double ratio, double k, double n) { return boost::math::ibeta(n, k, n / (n + k * ratio)); }

/// Of the frequencies from the first to the last, from 1.
struct FrequencyBand {
  double p_value = 1.0;
  std::size_t first = 1, last = 1;
};

/// Of every frequency and those around it, but for its neighbours, into which a wave reaches.
FrequencyBand wave_in(std::span<const double> powers) {
  std::vector<double> sums(powers.size() + 1, 0.0);
  std::partial_sum(powers.begin(), powers.end(), sums.begin() + 1);
  const auto between = [&](std::size_t from, std::size_t to) { return sums[to] - sums[from]; };
  FrequencyBand least;
  for (std::size_t j = 0; j < powers.size(); ++j) {
    const std::size_t from = std::min(j - std::min(j, kOnEachSide), powers.size() - 2 * kOnEachSide - 1);
    const std::size_t to = from + 2 * kOnEachSide + 1;
    const std::size_t own = j - std::min<std::size_t>(j, 1), end = std::min(j + 2, powers.size());
    const auto count = static_cast<double>(2 * kOnEachSide + 1 - (end - own));
    const double around = (between(from, to) - between(own, end)) / count;
    const double p = upper_f(powers[j] / around, 1.0, count);
    if (p < least.p_value) least = {p, j + 1, j + 1};
  }
  least.p_value = std::min(1.0, least.p_value * static_cast<double>(powers.size()));
  return least;
}

/// Of the lowest frequencies and those above them.
FrequencyBand slow_in(std::span<const double> powers) {
  FrequencyBand least;
  double tests = 0.0;
  for (const std::size_t k : {1U, 2U, 4U, 8U, 16U}) {
    const std::size_t above = 4 * k + 16;
    if (k + above > powers.size()) break;
    const auto slow = static_cast<double>(k), others = static_cast<double>(above);
    const double ratio = total_of(powers.first(k)) / slow / (total_of(powers.subspan(k, above)) / others);
    const double p = upper_f(ratio, slow, others);
    if (p < least.p_value) least = {p, 1, k};
    tests += 1.0;
  }
  least.p_value = std::min(1.0, least.p_value * tests);
  return least;
}

}  // namespace

Modulation modulation(std::span<const double> series) {
  if (!std::ranges::all_of(series, [](double x) { return std::isfinite(x); })) return {};
  const ThinnedSeries all = thinned(series);
  if (all.values.size() < 2 * kFewestFrequencies) return {};
  const auto values = std::span(all.values).first(quick_length(all.values.size()));
  const std::vector<double> ranks = ranks_of(values);
  const bool varies = std::ranges::any_of(ranks, [](double rank) { return rank != 0.0; });
  std::vector<double> powers = periodogram(ranks);
  if (!varies || powers.size() < kFewestFrequencies) return {};
  whiten(ranks, powers);
  const FrequencyBand wave = wave_in(powers), slow = slow_in(powers),
                      most = slow.p_value < wave.p_value ? slow : wave;
  Modulation found = {
      .p_value = std::min(1.0, 2.0 * most.p_value),
      .wave = all.rows_per_value * static_cast<double>(values.size()) / static_cast<double>(most.last)};
  set_levels(values, most.first, most.last, found);
  return found;
}

void set_levels(std::span<const double> series, std::size_t first, std::size_t last, Modulation& of) {
  const std::size_t n = series.size();
  std::vector<double> waves(n, 0.0);
  for (std::size_t j = first; j <= last; ++j) {
    const auto turn =
        std::polar(1.0, 2.0 * std::numbers::pi * static_cast<double>(j) / static_cast<double>(n));
    std::complex<double> phase = 1.0, sum = 0.0;
    for (std::size_t k = 0; k < n; ++k, phase *= turn) sum += series[k] * std::conj(phase);
    phase = 1.0;
    for (std::size_t k = 0; k < n; ++k, phase *= turn) waves[k] += (sum * phase).real();
  }
  Moments all, sides[2];
  for (std::size_t k = 0; k < n; ++k) {
    all.add(series[k]);
    sides[waves[k] > 0.0 ? 1 : 0].add(series[k]);
  }
  const auto rest = [&](std::size_t k) { return series[k] - sides[waves[k] > 0.0 ? 1 : 0].mean; };
  double product = 0.0;
  for (std::size_t k = 1; k < n; ++k) product += rest(k) * rest(k - 1);
  constexpr double kLongest = 0.99;
  const double rho = std::clamp(product / (sides[0].m2 + sides[1].m2), 0.0, kLongest);
  const auto level_of = [&](const Moments& side) {
    const double error =
        std::sqrt(side.variance() / static_cast<double>(side.count) * (1.0 + rho) / (1.0 - rho));
    return SeriesLevel{side.mean / all.mean, error / std::abs(all.mean)};
  };
  of.low = level_of(sides[0]);
  of.high = level_of(sides[1]);
}

}  // namespace credence::internal
