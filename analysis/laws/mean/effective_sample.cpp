#include "analysis/laws/mean/effective_sample.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "analysis/laws/correlation/thinned_series.h"
#include "analysis/laws/mean/student_positive_mean.h"
#include "analysis/laws/shape/vector_moments.h"
#include "analysis/laws/ten_stretches.h"
#include "core/linear_algebra/decompositions.h"
#include "core/linear_algebra/psd_root.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

/// Products at several lags of deviations x_k − mean, each summed in order of time: as many sums as hide the
/// latency of an addition.
class LagSums {
 public:
  LagSums(std::span<const std::span<const double>> series, double mean) {
    deviations_.reserve(series.size());
    for (const auto& x : series) {
      std::vector<double>& d = deviations_.emplace_back(kBefore + x.size(), 0.0);
      std::ranges::transform(x, d.begin() + kBefore, [mean](double value) { return value - mean; });
    }
  }

  /// Σ over the series of (x_k − mean)(x_{k+lag} − mean), lags in ascending order.
  double sum(std::size_t lag) {
    if (lag >= end_) add_up(lag);
    return sums_[static_cast<Index>(end_ - 1 - lag)];
  }
  /// The number of products.
  double pairs(std::size_t lag) const {
    double pairs = 0.0;
    for (const std::vector<double>& d : deviations_) {
      if (d.size() - kBefore > lag) pairs += static_cast<double>(d.size() - kBefore - lag);
    }
    return pairs;
  }

 private:
  static constexpr std::size_t kLags = 8, kBefore = kLags - 1;
  using Sums = Eigen::Array<double, static_cast<Index>(kLags), 1>;

  void add_up(std::size_t first) {
    end_ = first + kLags;
    Sums sums = Sums::Zero();
    for (const std::vector<double>& d : deviations_) {
      const double* before = d.data();  // at the largest lag
      for (std::size_t k = kBefore + first; k < d.size(); ++k)
        sums += d[k] * Eigen::Map<const Sums>(before++);
    }
    sums_ = sums;
  }

  std::vector<std::vector<double>> deviations_;  ///< behind zeros, of products that are none
  std::size_t end_ = 0;                          ///< of the lags that sums_ is of, the largest first
  Sums sums_;
};

/// Of runs of these lengths, longest first, how many are long enough for the stretches that so many are cut
/// into.
std::size_t long_enough(const std::vector<std::size_t>& lengths, double shortest) {
  for (std::size_t runs = lengths.size(); runs > 0; --runs) {
    const auto of_a_run = static_cast<double>(stretches_of_each(runs));
    if (static_cast<double>(lengths[runs - 1]) >= of_a_run * std::max(1.0, shortest)) return runs;
  }
  return 0;
}

}  // namespace

RunMeanLaw linear_run_law(std::span<const Matrix> transitions, std::span<const Matrix> covariances) {
  const std::size_t steps = covariances.size();
  if (transitions.size() != steps || steps == 0) {
    throw std::invalid_argument(
        fmt::format("{} transitions and {} covariances: as many of each", transitions.size(), steps));
  }
  // Σ_{k<l} Φ_lk P_k Φ_lkᵀ and the same with a weight of l − k, Φ_lk = A_l … A_{k+1}.
  const Index n = covariances.front().rows();
  Matrix reached = Matrix::Zero(n, n), weighted = Matrix::Zero(n, n);
  double dof = 0.0, pairs = 0.0, weighted_pairs = 0.0;
  for (std::size_t l = 0; l < steps; ++l) {
    const Matrix& P = covariances[l];
    if (!is_psd(P)) throw std::invalid_argument("a covariance is not finite or not positive semidefinite");
    const Matrix W = psd_whitening(P);
    dof += static_cast<double>(W.rows());
    if (l > 0) {
      const Matrix& A = transitions[l];
      reached = (A * (reached + covariances[l - 1]) * A.transpose()).eval();
      weighted = (A * weighted * A.transpose() + reached).eval();
      pairs += (W * reached * W.transpose()).trace();
      weighted_pairs += (W * weighted * W.transpose()).trace();
    }
  }
  const double variance = 2.0 * dof + 4.0 * pairs;
  return {.effective_steps = static_cast<double>(steps) * 2.0 * dof / variance,
          .skewness = (8.0 * dof + 48.0 * weighted_pairs) / std::pow(variance, 1.5)};
}

EffectiveSample effective_sample(std::span<const std::span<const double>> series, double mean) {
  EffectiveSample result{.correlation_time = kNaN, .size = kNaN, .reason = {}};
  LagSums lags(series, mean);
  const double variance_sum = lags.sum(0), values = lags.pairs(0);
  if (values == 0.0) {
    result.reason = "no data";
    return result;
  }
  if (!(std::isfinite(variance_sum) && variance_sum > 0.0)) {
    result.reason = "the series does not vary or is not finite";
    return result;
  }
  std::size_t longest = 0;
  for (const auto& x : series) longest = std::max(longest, x.size());
  double time = 1.0;
  for (std::size_t lag = 1; lag < longest && static_cast<double>(lag) < 5.0 * time; ++lag) {
    time += 2.0 * (lags.sum(lag) / lags.pairs(lag)) / (variance_sum / values);
  }
  result.correlation_time = std::max(1.0, time);
  result.size = values / result.correlation_time;
  return result;
}

EffectiveSample effective_sample(std::span<const std::vector<double>> series) {
  double sum = 0.0, values = 0.0;
  for (const std::vector<double>& of_run : series) {
    sum = std::accumulate(of_run.begin(), of_run.end(), sum);
    values += static_cast<double>(of_run.size());
  }
  const std::vector<std::span<const double>> views(series.begin(), series.end());
  return effective_sample(views, sum / values);
}

double average_of(std::span<const double> values) {
  double sum = 0.0;
  for (const double x : values) sum += x;
  return sum / static_cast<double>(values.size());
}

EffectiveSample effective_sample(std::span<const double> series) {
  return effective_sample(std::span(&series, 1), average_of(series));
}

double memory_of_squares(std::span<const Matrix> errors) {
  VectorMoments all;
  Index longest = 0;
  for (const Matrix& run : errors) {
    longest = std::max(longest, run.cols());
    for (Index k = 0; k < run.cols(); ++k) all.add(run.col(k));
  }
  if (all.count == 0) return kNaN;
  const auto vectors = static_cast<double>(all.count);
  const Eigen::LLT<Matrix> factor(all.scatter / vectors);
  if (factor.info() != Eigen::Success) return kNaN;
  std::vector<Matrix> white;
  for (const Matrix& run : errors) white.push_back(factor.matrixL().solve(run.colwise() - all.mean));
  const auto dim = static_cast<double>(all.mean.size());
  // The products at lags that the errors remember have less noise, as those at lag 0 are known: 1.4 (τ − 1)
  // of autoregressions.
  constexpr double kWithoutNoise = 1.4;
  double time = 1.0, sum = 0.0, noisy_lags = 0.0;
  for (Index lag = 1; lag < longest && static_cast<double>(lag) < 5.0 * time + 1.0; ++lag) {
    Matrix products = Matrix::Zero(all.mean.size(), all.mean.size());
    double pairs = 0.0;
    for (const Matrix& run : white) {
      const Index of_run = run.cols() - lag;
      if (of_run <= 0) continue;
      products += run.rightCols(of_run) * run.leftCols(of_run).transpose();
      pairs += static_cast<double>(of_run);
    }
    sum += (products / vectors).squaredNorm() / dim;
    noisy_lags += pairs / vectors;
    const double noise = 2.0 * dim / vectors * std::max(0.0, noisy_lags - kWithoutNoise * (time - 1.0));
    time = std::max(1.0, (1.0 + 2.0 * sum) / (1.0 + noise));
  }
  return time;
}

double unbiased_size(double length, double correlation_time) {
  constexpr double kTooMany = 25.0;
  return std::max(1.0, length / correlation_time - kTooMany * (1.0 - 1.0 / correlation_time));
}

double standing_share(const Matrix& mean_square, const Matrix& square_of_means) {
  constexpr double kLeast = 1e-9;  // of the average direction: what rounding leaves
  const double least =
      kLeast * mean_square.trace() / static_cast<double>(std::max<Index>(1, mean_square.rows()));
  if (!(std::isfinite(least) && least > 0.0)) return 0.0;
  const Matrix regular = mean_square + least * Matrix::Identity(mean_square.rows(), mean_square.cols());
  const Eigen::LLT<Matrix> factor(regular);
  if (factor.info() != Eigen::Success) return 0.0;
  const Matrix half = factor.matrixL().solve(square_of_means);
  const Matrix share = factor.matrixL().solve(half.transpose());
  return share.selfadjointView<Eigen::Lower>().eigenvalues().maxCoeff();
}

double oscillating_share(const MatrixRef& errors) {
  constexpr Index kTenths = kOscillatingStretches / 2, kFewest = 4;
  const Index dim = errors.rows(), rows = errors.cols() / kTenths;
  if (rows < kFewest) return 0.0;
  const auto used = errors.leftCols(kTenths * rows);
  const Matrix mean_square = used * used.transpose();
  // Half a period of a tenth apart, so that none falls between two; orthonormal columns of each.
  Matrix waves(rows, 2 * (rows + 1));
  for (Index j = 0; j <= rows; ++j) {
    const double turn = std::numbers::pi * static_cast<double>(j) / static_cast<double>(rows);
    auto cosine = waves.col(2 * j), sine = waves.col(2 * j + 1);
    for (Index k = 0; k < rows; ++k) {
      cosine[k] = std::cos(turn * static_cast<double>(k));
      sine[k] = j % rows == 0 ? 0.0 : std::sin(turn * static_cast<double>(k));
    }
    cosine.normalize();
    sine -= cosine * cosine.dot(sine);
    sine.normalize();  // zeros stay
  }
  std::vector<Matrix> square(static_cast<std::size_t>(rows + 1), Matrix::Zero(dim, dim));
  for (Index tenth = 0; tenth < kTenths; ++tenth) {
    const Matrix fitted = used.middleCols(tenth * rows, rows) * waves;
    for (Index j = 0; j <= rows; ++j) {
      const auto both = fitted.middleCols(2 * j, 2);
      square[static_cast<std::size_t>(j)] += both * both.transpose();
    }
  }
  double largest = 0.0;
  for (const Matrix& of_frequency : square)
    largest = std::max(largest, standing_share(mean_square, of_frequency));
  return largest;
}

double least_standing_share(Index directions, Index stretches, double effective_rows) {
  constexpr double kOfNees = 0.6;
  const double rows = std::max(2.0, kOfNees * effective_rows);
  const auto angle = [rows](Index x) {
    return std::asin(std::sqrt(std::min(1.0, (static_cast<double>(x) - 0.5) / (rows - 1.0))));
  };
  const double sine = std::sin(std::min(0.5 * std::numbers::pi, angle(directions) + angle(stretches)));
  return std::max(kStandingErrors, (1.0 + 2.0 * sine * sine) / 3.0);
}

std::size_t stretches_of_each(std::size_t runs) {
  constexpr std::size_t kStretches = 20;
  return runs == 0 || runs >= kStretches ? 0 : (kStretches + runs - 1) / runs;
}

StretchAverages stretch_averages(std::span<const std::vector<double>> runs, double memory) {
  if (stretches_of_each(runs.size()) == 0) return {};
  std::vector<std::size_t> lengths(runs.size());
  std::ranges::transform(runs, lengths.begin(), [](const auto& run) { return run.size(); });
  std::ranges::sort(lengths, std::greater());
  std::vector<ThinnedSeries> shorter;
  shorter.reserve(runs.size());
  Moments all;
  for (const auto& run : runs) {
    shorter.push_back(thinned(run, lengths.front()));
    for (const double x : run) all.add(x);
  }
  std::vector<std::span<const double>> looked_at;
  looked_at.reserve(shorter.size());
  for (const ThinnedSeries& run : shorter) looked_at.emplace_back(run.values);
  const EffectiveSample sample = effective_sample(looked_at, all.mean);
  const double correlation_time = shorter.front().rows_per_value * sample.correlation_time;
  const std::size_t used = long_enough(lengths, shortest_stretch(correlation_time, memory));
  if (used == 0) return {};
  const std::size_t least = lengths[used - 1], length = least / stretches_of_each(used);
  StretchAverages result{.effective_rows = sample.size, .correlation_time = correlation_time};
  std::vector<double> short_runs;  // one behind the other: pieces of them are as independent
  const auto cut = [&](std::span<const double> run) {
    for (; run.size() >= length; run = run.subspan(length))
      result.averages.add(average_of(run.first(length)));
    return run;
  };
  for (const auto& run : runs) {
    if (run.size() >= length)
      cut(run);
    else
      short_runs.insert(short_runs.end(), run.begin(), run.end());
  }
  const std::span<const double> rest = cut(short_runs);
  if (2 * rest.size() >= length) result.averages.add(average_of(rest));
  return result;
}

std::vector<SkewedMoments> averages_by_place(std::span<const std::vector<double>> runs,
                                             double correlation_time) {
  constexpr std::size_t kTenths = 10;
  const auto group = static_cast<std::size_t>(std::max(1.0, std::ceil(4.0 * (correlation_time - 1.0))));
  std::vector<SkewedMoments> places(1 + kTenths);
  for (const std::vector<double>& run : runs) {
    for (std::size_t row = 0; row + group <= run.size(); row += group) {
      const double average = average_of(std::span(run).subspan(row, group));
      const std::size_t from_start = 1 + kTenths + static_cast<std::size_t>(std::bit_width(row + 1)) - 1;
      if (places.size() <= from_start) places.resize(from_start + 1);
      for (const std::size_t place : {std::size_t{0}, 1 + row * kTenths / run.size(), from_start})
        places[place].add(average);
    }
  }
  return places;
}

TimeAverageTest test_single_run(std::span<const double> normalised_nees, double confidence) {
  return test_single_run(normalised_nees, {confidence}).front();
}

std::vector<TimeAverageTest> test_single_run(std::span<const double> normalised_nees,
                                             std::initializer_list<double> confidences, double memory) {
  std::vector<TimeAverageTest> tests;
  tests.reserve(confidences.size());
  for (const double confidence : confidences) {
    tests.push_back({.average = student_interval({}, confidence)});
  }
  const auto without = [&tests](std::string_view reason) {
    for (TimeAverageTest& test : tests) test.average.reason = reason;
    return tests;
  };

  double mean = 0.0;
  for (const double x : normalised_nees) mean += x / static_cast<double>(normalised_nees.size());
  const EffectiveSample sample =
      effective_sample(std::vector<std::span<const double>>{normalised_nees}, mean);
  if (!sample.reason.empty()) return without(sample.reason);
  for (TimeAverageTest& test : tests) test.effective_steps = sample.size;
  if (static_cast<double>(normalised_nees.size()) <
      shortest_stretch(sample.correlation_time, memory) * static_cast<double>(kTestedStretches)) {
    return without("the run is too short for its correlation in time");
  }
  const Moments averages = tested_averages(normalised_nees);
  std::ranges::transform(confidences, tests.begin(), [&](double confidence) {
    return TimeAverageTest{.average = positive_mean_interval(averages, confidence),
                           .p_value = positive_mean_p_value(averages, 1.0),
                           .effective_steps = sample.size};
  });
  return tests;
}

}  // namespace credence::internal
