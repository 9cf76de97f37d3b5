#include "analysis/evidence/sums/recorded_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "analysis/evidence/verdicts/consistency.h"
#include "analysis/laws/chi_square/chi_square.h"
#include "analysis/laws/chi_square/chi_square_truncated.h"
#include "analysis/laws/joint/multiple_tests.h"
#include "analysis/laws/mean/effective_sample.h"
#include "analysis/laws/mean/student_positive_mean.h"
#include "analysis/laws/mean/zero_mean.h"
#include "core/linear_algebra/decompositions.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

constexpr Index kLags = 10;
// Stretches of eight correlation times have nearly independent averages (effective_sample.h).
constexpr double kTimesAStretch = 8.0;
constexpr std::int64_t kFewestStretches = 10, kMostStretches = 50, kFewLong = 5;

double average(std::span<const double> values) {
  double sum = 0.0;
  for (const double x : values) sum += x;
  return sum / static_cast<double>(values.size());
}

double correlation_time_of(std::span<const double> values, double mean) {
  const EffectiveSample sample = effective_sample(std::vector<std::span<const double>>{values}, mean);
  return sample.reason.empty() ? sample.correlation_time : kNaN;
}

/// How many stretches a series of this length and correlation time can be cut into; 0 if too few.
std::int64_t stretches_of(std::size_t length, double correlation_time) {
  if (!std::isfinite(correlation_time)) return 0;
  const auto count =
      static_cast<std::int64_t>(static_cast<double>(length) / (kTimesAStretch * correlation_time));
  return count;
}

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

/// How many stretches to cut each run into: of eight correlation times if that gives ten in all, else five of
/// at least two and a half.
std::vector<std::int64_t> stretch_counts(std::span<const RecordedInnovations> runs) {
  std::vector<std::int64_t> many, few;
  std::int64_t possible = 0;
  for (const RecordedInnovations& run : runs) {
    const double time = run.nis.empty() ? kNaN : correlation_time_of(run.nis, average(run.nis));
    many.push_back(std::min(kMostStretches, stretches_of(run.nis.size(), time)));
    const bool long_enough = std::isfinite(time) && static_cast<double>(run.nis.size()) >= 12.5 * time;
    few.push_back(long_enough ? kFewLong : 0);
    possible += many.back();
  }
  return possible >= kFewestStretches ? many : few;
}

struct NisStretch {
  double sum = 0.0, count = 0.0;
};

/// Nearly independent parts that hold every value: of many runs these, else stretches of them. Of several
/// runs one that is too short to be cut is a part as it is.
std::vector<NisStretch> nis_stretches(std::span<const RecordedInnovations> runs) {
  const auto has_values = [](const RecordedInnovations& run) { return !run.nis.empty(); };
  const std::int64_t used = std::ranges::count_if(runs, has_values);
  const std::int64_t least = used > 1 ? 1 : 0;
  const std::vector<std::int64_t> counts = stretch_counts(runs);
  std::vector<NisStretch> parts;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const std::span<const double> nis = runs[r].nis;
    const auto count = static_cast<std::size_t>(used >= kFewestStretches ? 1 : std::max(least, counts[r]));
    for (std::size_t i = 0; i < count && !nis.empty(); ++i) {
      const std::size_t first = i * nis.size() / count, length = (i + 1) * nis.size() / count - first;
      const std::span<const double> part = nis.subspan(first, length);
      parts.push_back({average(part) * static_cast<double>(length), static_cast<double>(length)});
    }
  }
  return parts;
}

/// The mean of all values as that of independent ones with its variance, as which parts of different length
/// estimate it: a ratio of sums, whose variance is to first order. They count for as many as there would be
/// of one length.
Moments mean_over(std::span<const NisStretch> parts) {
  double sum = 0.0, count = 0.0, square = 0.0, spread = 0.0;
  for (const NisStretch& part : parts) {
    sum += part.sum;
    count += part.count;
    square += part.count * part.count;
  }
  Moments moments{.count = 0, .mean = sum / count, .m2 = 0.0};
  if (parts.size() < 2) return moments;
  for (const NisStretch& part : parts) spread += std::pow(part.sum - moments.mean * part.count, 2);
  const auto k = static_cast<double>(parts.size());
  moments.count = std::llround(count * count / square);
  const auto worth = static_cast<double>(moments.count);
  moments.m2 = k / (k - 1.0) * spread / (count * count) * worth * (worth - 1.0);
  return moments;
}

NoiseScale noise_scale_of(std::span<const RecordedInnovations> runs, double confidence) {
  NoiseScale result{.lower = kNaN, .upper = kNaN};
  const double dof = runs.front().dof, gate = runs.front().gate;
  double sum = 0.0, count = 0.0;
  for (const RecordedInnovations& run : runs) {
    for (const double x : run.nis) sum += x;
    count += static_cast<double>(run.nis.size());
  }
  result.scale = scale_of_mean(sum / count, dof, gate);
  const std::vector<NisStretch> parts = nis_stretches(runs);
  const Moments mean = mean_over(parts);
  if (mean.count < kFewLong) {
    result.reason = "the recording is too short for its correlation in time";
    return result;
  }
  const MeanInterval interval = positive_mean_interval(mean, confidence);
  result.reason = interval.reason;
  if (!interval.reason.empty()) return result;
  result.lower = scale_of_mean(interval.lower, dof, gate);
  result.upper = scale_of_mean(interval.upper, dof, gate);
  result.stretches = std::ssize(parts);
  return result;
}

ConsistencyVerdict judge_sum(std::span<const RecordedInnovations> runs, double confidence) {
  Moments all;
  for (const RecordedInnovations& run : runs)
    for (const double x : run.nis) all.add(x);
  const double dof = runs.front().dof, gate = runs.front().gate;
  const std::vector<Moments> one{all};
  if (std::isfinite(gate)) return judge_gated_nis(one, dof, gate, confidence);
  return judge_nis(one, std::vector<double>{dof * static_cast<double>(all.count)}, confidence);
}

GoodnessOfFit test_law(std::span<const RecordedInnovations> runs) {
  std::vector<double> all;
  for (const RecordedInnovations& run : runs) all.insert(all.end(), run.nis.begin(), run.nis.end());
  const double dof = runs.front().dof, gate = runs.front().gate;
  if (std::isfinite(gate)) return test_uniform(gated_nis_to_uniform(all, dof, gate));
  return test_uniform(nis_to_uniform(all, std::vector<double>(all.size(), dof)));
}

/// The mean over stretches, as innovations that are not white make single values count too much.
void test_mean(std::span<const RecordedInnovations> runs, InnovationTests& tests) {
  VectorMoments values, stretches;
  for (const RecordedInnovations& run : runs) {
    if (run.whitened.empty()) continue;
    const Index dim = run.whitened.front().size();
    double slowest = 1.0;
    for (Index i = 0; i < dim; ++i) {
      std::vector<double> component;
      for (const Vector& u : run.whitened) component.push_back(u(i));
      slowest = std::max(slowest, correlation_time_of(component, average(component)));
    }
    const auto count = static_cast<std::size_t>(
        std::min(kMostStretches, std::max<std::int64_t>(1, stretches_of(run.whitened.size(), slowest))));
    const std::size_t length = run.whitened.size() / count;
    for (std::size_t k = 0; k < count; ++k) {
      VectorMoments stretch;
      for (std::size_t i = k * length; i < (k + 1) * length; ++i) stretch.add(run.whitened[i]);
      stretches.add(stretch.mean);
    }
    for (const Vector& u : run.whitened) values.add(u);
  }
  tests.mean = values.mean;
  tests.mean_p_value = kNaN;
  if (stretches.count < kFewestStretches) {
    tests.mean_reason = "the recording is too short for its correlation in time";
    return;
  }
  const ZeroMeanTest test = test_zero_mean(stretches);
  tests.mean_p_value = test.p_value;
  tests.mean_reason = test.reason;
}

WhitenessTest test_white(std::span<const RecordedInnovations> runs, double confidence) {
  const auto seen = std::find_if(runs.begin(), runs.end(), [](const auto& r) { return !r.whitened.empty(); });
  LagProducts products(seen == runs.end() ? 1 : seen->whitened.front().size(), kLags);
  for (const RecordedInnovations& run : runs) {
    products.begin_run();
    for (const Vector& u : run.whitened) products.add(u);
  }
  return test_whiteness(products, confidence);
}

double two_sided(const NormalisedError& error) {
  return error.ok && error.dof > 0 ? two_sided_p_value(error.value, static_cast<double>(error.dof)) : kNaN;
}

/// The tangents of the rigid motions of N points: two shifts and the turn about their mean.
Matrix rigid_tangents(VectorRef points) {
  const Index n = points.size() / 2;
  Matrix J = Matrix::Zero(points.size(), 3);
  double x = 0.0, y = 0.0;
  for (Index i = 0; i < n; ++i) {
    x += points(2 * i) / static_cast<double>(n);
    y += points(2 * i + 1) / static_cast<double>(n);
  }
  for (Index i = 0; i < n; ++i) {
    J(2 * i, 0) = J(2 * i + 1, 1) = 1.0;
    J(2 * i, 2) = -(points(2 * i + 1) - y);
    J(2 * i + 1, 2) = points(2 * i) - x;
  }
  return J;
}

}  // namespace

InnovationTests test_recorded_innovations(std::span<const RecordedInnovations> runs, double confidence) {
  if (runs.empty()) throw std::invalid_argument("no run whose innovations could be tested");
  for (const RecordedInnovations& run : runs)
    if (run.dof != runs.front().dof || run.gate != runs.front().gate)
      throw std::invalid_argument(
          fmt::format("runs tested together must have one dof and one gate, not {} "
                      "and {}, {} and {}",
                      runs.front().dof, run.dof, runs.front().gate, run.gate));
  InnovationTests tests;
  tests.nis = judge_sum(runs, confidence);
  tests.fit = test_law(runs);
  tests.whiteness = test_white(runs, confidence);
  test_mean(runs, tests);
  tests.noise_scale = noise_scale_of(runs, confidence);
  // Kolmogorov and Anderson are two tests of one hypothesis.
  const double fit =
      tests.fit.reason.empty()
          ? std::min(1.0, 2.0 * std::min(tests.fit.kolmogorov_p_value, tests.fit.anderson_p_value))
          : kNaN;
  const double white = tests.whiteness.reason.empty() ? tests.whiteness.p_value : kNaN;
  tests.adjusted_p_value = holm(std::vector<double>{tests.nis.p_value, fit, white, tests.mean_p_value});
  return tests;
}

RecordedNeesVerdict judge_recorded_nees(std::span<const RecordedNees> runs, double dof, double interval_s,
                                        double confidence) {
  if (!(dof > 0.0) || !(interval_s > 0.0))
    throw std::invalid_argument(fmt::format("dof = {} and interval = {} must be > 0", dof, interval_s));
  RecordedNeesVerdict result;
  std::vector<Moments> steps;
  for (const RecordedNees& run : runs) {
    std::vector<double> last;  // of each interval
    for (std::size_t i = 0; i < run.nees.size(); ++i) {
      const auto k = static_cast<std::size_t>(std::max(0.0, run.time_s[i] / interval_s));
      if (k >= last.size()) last.resize(k + 1, kNaN);
      last[k] = run.nees[i];
    }
    if (last.size() > steps.size()) steps.resize(last.size());
    for (std::size_t k = 0; k < last.size(); ++k)
      if (std::isfinite(last[k])) steps[k].add(last[k]);
    result.run_mean.push_back(run.nees.empty() ? kNaN : average(run.nees));
    result.correlation_time.push_back(run.nees.empty() ? kNaN
                                                       : correlation_time_of(run.nees, average(run.nees)));
  }
  std::vector<double> dofs;
  for (std::size_t k = 0; k < steps.size(); ++k) {
    dofs.push_back(dof * static_cast<double>(steps[k].count));
    result.time_s.push_back(interval_s * static_cast<double>(k + 1));
  }
  result.verdict = judge_nees(steps, dofs, confidence);
  return result;
}

MapConsistency judge_map(VectorRef estimate, VectorRef truth, VectorRef aligned, MatrixRef P) {
  const Index n = estimate.size();
  if (truth.size() != n || aligned.size() != n || P.rows() != n || P.cols() != n || n % 2 != 0)
    throw std::invalid_argument("judge_map: estimate, truths and P must be of one even size");
  MapConsistency result;
  result.placed_p_value = result.shape_p_value = kNaN;
  if (n == 0) {
    result.placed.reason = result.shape.reason = "the map is empty";
    return result;
  }
  result.placed = normalised_error(estimate - truth, P);
  result.placed_p_value = two_sided(result.placed);
  if (n <= 4) {
    result.shape.reason = "fewer than three landmarks";
    return result;
  }
  const Eigen::HouseholderQR<Matrix> qr(rigid_tangents(aligned));
  const Matrix Q = qr.householderQ();
  const Matrix shape = Q.rightCols(n - 3);
  const Matrix P_shape = shape.transpose() * P * shape;
  result.shape =
      normalised_error(shape.transpose() * (estimate - aligned), 0.5 * (P_shape + P_shape.transpose()));
  result.shape_p_value = two_sided(result.shape);
  return result;
}

}  // namespace credence::internal
