#include "analysis/laws/correlation/error_modulation.h"

#include <algorithm>
#include <array>
#include <boost/math/special_functions/gamma.hpp>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <numeric>
#include <vector>

#include "analysis/laws/correlation/fourier.h"

namespace credence::internal {
namespace {

constexpr Index kFewestVectors = 130, kLeastWindow = 32, kMostWindowsOfScale = 16;

/// Values of a function of the frequency j/N at some j, in their order.
struct Spectrum {
  std::vector<double> frequencies, values;

  /// Between two of them on a line, beyond all as at the nearest.
  double at(double frequency) const {
    const auto next = std::ranges::lower_bound(frequencies, frequency);
    if (next == frequencies.begin()) return values.front();
    if (next == frequencies.end()) return values.back();
    const auto i = static_cast<std::size_t>(next - frequencies.begin());
    const double share = (frequency - frequencies[i - 1]) / (frequencies[i] - frequencies[i - 1]);
    return std::lerp(values[i - 1], values[i], share);
  }
};

/// 1, 2, 3, 4, 6, 8, 12, … < M/2.
std::vector<Index> offsets_within(Index M) {
  std::vector<Index> offsets;
  for (Index j = 1; 2 * j < M; j *= 2) {
    offsets.push_back(j);
    if (j > 1 && 3 * j < M) offsets.push_back(j + j / 2);
  }
  return offsets;
}

/// 2 Σ_λ |Z_λ* Z_{λ+j}|²/M³ of M rows z, one component a column, at these j.
Eigen::ArrayXd expected_powers(const MatrixRef& z, const std::vector<Index>& offsets) {
  const Index M = z.rows();
  Eigen::ArrayXXcd Z(M, z.cols());
  for (Index i = 0; i < z.cols(); ++i) {
    const auto waves = fourier({z.col(i).data(), static_cast<std::size_t>(M)});
    Z.col(i) = Eigen::ArrayXcd::Map(waves.data(), M);
  }
  Eigen::ArrayXd powers(std::ssize(offsets));
  Eigen::ArrayXcd product(M);
  for (Index k = 0; k < powers.size(); ++k) {
    const Index j = offsets[static_cast<std::size_t>(k)];
    product.setZero();
    for (Index i = 0; i < z.cols(); ++i) {
      product.head(M - j) += Z.col(i).head(M - j).conjugate() * Z.col(i).tail(M - j);
      product.tail(j) += Z.col(i).tail(j).conjugate() * Z.col(i).head(j);
    }
    const double size = static_cast<double>(M);
    powers[k] = 2.0 * product.abs2().sum() / (size * size * size);
  }
  return powers;
}

/// Rows cut at the quantile of 0.9 of their size, then every component of the variance 1; one of zeros alone
/// is left out. One row a vector.
Matrix cut_and_normalised(const MatrixRef& z, Index rows) {
  Matrix cut = z.leftCols(rows).transpose();
  const Vector sizes = cut.rowwise().norm();
  std::vector<double> sorted(sizes.begin(), sizes.end());
  const auto ninth = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() * 9 / 10);
  std::ranges::nth_element(sorted, ninth);
  for (Index k = 0; k < rows; ++k) {
    if (sizes[k] > *ninth) cut.row(k) *= *ninth / sizes[k];
  }
  Index kept = 0;
  for (Index i = 0; i < cut.cols(); ++i) {
    const double variance = cut.col(i).squaredNorm() / static_cast<double>(rows);
    if (variance > 0.0) cut.col(kept++) = cut.col(i) / std::sqrt(variance);
  }
  cut.conservativeResize(rows, kept);
  return cut;
}

/// Brings components up to the variance 1 where that of the `window` values around is smaller: of an error
/// that stays for a while one that is small by chance tells no less of its memory.
Matrix brought_up(const Matrix& z, Index window) {
  Matrix up = z;
  const Index rows = z.rows();
  std::vector<double> sums(static_cast<std::size_t>(rows + 1), 0.0);
  for (Index i = 0; i < z.cols(); ++i) {
    for (Index k = 0; k < rows; ++k)
      sums[static_cast<std::size_t>(k + 1)] = sums[static_cast<std::size_t>(k)] + z(k, i) * z(k, i);
    for (Index k = 0; k < rows; ++k) {
      const Index from = std::clamp<Index>(k - window / 2, 0, rows - window);
      const double sum = sums[static_cast<std::size_t>(from + window)] - sums[static_cast<std::size_t>(from)];
      const double variance = sum / static_cast<double>(window);
      if (variance > 0.0 && variance < 1.0) up(k, i) /= std::sqrt(variance);
    }
  }
  return up;
}

/// The expected powers of windows of so many rows, evenly over all.
struct Windows {
  Spectrum average;
  double largest_share = 0.0;  ///< of the three lowest frequencies: the largest over the average
};

Windows over_windows(const Matrix& z, Index length) {
  const Index M = static_cast<Index>(quick_length(static_cast<std::size_t>(length))), rows = z.rows();
  const Index count = M == rows ? 1 : std::min(kMostWindowsOfScale, 2 * (rows / length) - 1);
  const std::vector<Index> offsets = offsets_within(M);
  const Index low = std::min<Index>(3, std::ssize(offsets));
  Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(std::ssize(offsets));
  double largest = 0.0;
  for (Index i = 0; i < count; ++i) {
    const Index from = count == 1 ? 0 : i * (rows - M) / (count - 1);
    const Eigen::ArrayXd powers = expected_powers(z.middleRows(from, M), offsets);
    largest = std::max(largest, powers.head(low).sum());
    sum += powers;
  }
  Windows result;
  result.largest_share = largest * static_cast<double>(count) / sum.head(low).sum();
  for (Index k = 0; k < sum.size(); ++k) {
    const Index j = offsets[static_cast<std::size_t>(k)];
    result.average.frequencies.push_back(static_cast<double>(j) / static_cast<double>(M));
    result.average.values.push_back(sum[k] / static_cast<double>(count));
  }
  return result;
}

/// Of exponential variables of mean 1 or less at j = 1, 2, …, but for what heavy tails add to all alike.
struct TooLarge {
  double p_value;
  std::ptrdiff_t first, last;  ///< the j that speak most
};

TooLarge too_large(std::vector<double> ratios) {
  std::vector<double> sorted = ratios;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::ranges::nth_element(sorted, middle);
  const double scale = std::max(1.0, *middle / std::numbers::ln2);
  for (double& ratio : ratios) ratio /= scale;
  const auto largest = std::ranges::max_element(ratios);
  double least = static_cast<double>(ratios.size()) * std::exp(-*largest);
  std::ptrdiff_t last = largest - ratios.begin() + 1, first = last;
  constexpr std::array<std::ptrdiff_t, 5> kSlow = {1, 2, 4, 8, 16};
  for (const std::ptrdiff_t k : kSlow) {
    const double sum = std::accumulate(ratios.begin(), ratios.begin() + k, 0.0);
    const double p = static_cast<double>(kSlow.size()) * boost::math::gamma_q(static_cast<double>(k), sum);
    if (p < least) {
      first = 1;
      last = k;
    }
    least = std::min(least, p);
  }
  return {std::min(1.0, 2.0 * least), first, last};
}

}  // namespace

Modulation error_modulation(const MatrixRef& z) {
  if (z.cols() < kFewestVectors || !z.allFinite()) return {};
  constexpr double kMostOfOne = 2.5, kRounding = 1e-9;
  constexpr Index kEighths = 8;
  const auto rows = static_cast<Index>(quick_length(static_cast<std::size_t>(z.cols())));
  const Matrix normalised = cut_and_normalised(z, rows);
  if (normalised.cols() == 0) return {};
  const Matrix up = brought_up(normalised, std::min(kLeastWindow, rows / kEighths));
  std::vector<Spectrum> expected;
  for (Index parts = 1; parts <= kEighths || rows / parts >= kLeastWindow; parts *= 2) {
    Windows windows = over_windows(up, rows / parts);
    if (parts == kEighths && windows.largest_share > kMostOfOne) return {};
    expected.push_back(std::move(windows.average));
    expected.push_back(over_windows(normalised, rows / parts).average);
  }
  Vector sizes = normalised.rowwise().squaredNorm();
  sizes.array() -= sizes.mean();
  if (sizes.norm() <= kRounding * normalised.squaredNorm()) return {};
  const std::vector<double> powers = periodogram({sizes.data(), static_cast<std::size_t>(rows)});
  std::vector<double> ratios = powers;
  for (std::size_t j = 0; j < ratios.size(); ++j) {
    const double frequency = static_cast<double>(j + 1) / static_cast<double>(rows);
    double power = 0.0;
    for (const Spectrum& spectrum : expected) power = std::max(power, spectrum.at(frequency));
    ratios[j] /= static_cast<double>(rows) * power;
  }
  const TooLarge found = too_large(std::move(ratios));
  Modulation modulated = {.p_value = found.p_value,
                          .wave = static_cast<double>(rows) / static_cast<double>(found.last)};
  const Vector uncut = z.leftCols(rows).colwise().squaredNorm();
  set_levels({uncut.data(), static_cast<std::size_t>(rows)}, static_cast<std::size_t>(found.first),
             static_cast<std::size_t>(found.last), modulated);
  return modulated;
}

}  // namespace credence::internal
