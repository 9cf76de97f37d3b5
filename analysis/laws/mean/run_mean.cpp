#include "analysis/laws/mean/run_mean.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "analysis/laws/chi_square/chi_square.h"
#include "analysis/laws/chi_square/chi_square_dependent_sum.h"
#include "analysis/laws/mean/hall_score.h"
#include "analysis/laws/mean/student_positive_mean.h"
#include "analysis/laws/require.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

// From here on the scores hold their level on the pessimistic side too.
constexpr std::int64_t kFewestRunsForScores = 20;

Moments without_skewness(const SkewedMoments& moments) {
  return {.count = moments.count, .mean = moments.mean, .m2 = moments.m2};
}

bool has_mean(const SkewedMoments& moments) {
  return moments.count > 0 && std::isfinite(moments.mean) && moments.mean >= 0.0 &&
         std::isfinite(moments.m2) && std::isfinite(moments.m3);
}

DirectedPValues bound_p_values(const SkewedMoments& moments, double expected, double least_dof) {
  const std::array dof{static_cast<double>(moments.count) * least_dof};
  const TailPValues tails = dependent_sum_tails(moments.mean / expected * dof[0], dof);
  return {.optimistic = tails.upper, .pessimistic = tails.lower};
}

// All equal but for rounding; of others m2 to the power of 1.5 is a number.
bool are_equal(const SkewedMoments& moments, double expected) {
  constexpr double kEqual = 1e-24;
  return moments.m2 <= kEqual * expected * expected;
}

// Their mean is what they say, to as many digits as a log may have.
DirectedPValues equal_runs_p_values(double mean, double expected) {
  constexpr double kRounding = 1e-6;
  if (std::abs(mean - expected) <= kRounding * expected) return {};
  return {.optimistic = mean > expected ? 0.0 : 1.0, .pessimistic = mean < expected ? 0.0 : 1.0};
}

// A skewness that few runs hardly show: that of the sample and what it may lack, of order 1/M, but no more
// than that of χ²₁, the largest of any Σ λ_j χ²₁.
double cautious_skewness(const SkewedMoments& moments) {
  const double gamma = sample_skewness(moments);
  const double likely = gamma + (20.0 * gamma + 8.0) / static_cast<double>(moments.count);
  return std::max(gamma, std::min(std::sqrt(8.0), likely));
}

// Where the large values are missing the sample variance is too small together with the mean, so that the
// score of the pessimistic side has longer tails than t(M − 1). Far out a third of its dof, at twice the
// probability, hold them.
double pessimistic_p_value(double score, double dof) {
  return std::max(student_upper_p_value(score, dof), 0.5 * student_upper_p_value(score, dof / 3.0));
}

// The score that has this p-value, below ½.
double pessimistic_quantile(double p, double dof) {
  const double near = student_quantile_two_sided(1.0 - 2.0 * p, dof);
  return p < 0.25 ? std::max(near, student_quantile_two_sided(1.0 - 4.0 * p, dof / 3.0)) : near;
}

struct DirectedScores {
  double optimistic, pessimistic;  ///< large: the mean is too large, or too small
};

DirectedScores scores_of(const SkewedMoments& moments, double expected) {
  const double cube = positive_mean_score(without_skewness(moments), expected);
  const double hall = hall_score(moments, expected);
  const double cautious = hall_score(moments, expected, cautious_skewness(moments));
  return {std::min(cube, hall), -std::max(cube, cautious)};
}

DirectedPValues score_p_values(const DirectedScores& scores, std::int64_t count) {
  const double dof = static_cast<double>(count - 1);
  return {.optimistic = student_upper_p_value(scores.optimistic, dof),
          .pessimistic = pessimistic_p_value(scores.pessimistic, dof)};
}

}  // namespace

double DirectedPValues::two_sided() const {
  if (std::isnan(optimistic) || std::isnan(pessimistic)) return kNaN;
  return std::min(1.0, 2.0 * std::min(optimistic, pessimistic));
}

DirectedPValues run_mean_p_values(const SkewedMoments& run_averages, double expected, double least_dof) {
  require_positive("expected", expected);
  require_positive("least_dof", least_dof);
  if (!has_mean(run_averages)) return {.optimistic = kNaN, .pessimistic = kNaN};
  if (run_averages.count == 1) return bound_p_values(run_averages, expected, least_dof);
  const bool equal = are_equal(run_averages, expected);
  const DirectedPValues scores = equal
                                     ? equal_runs_p_values(run_averages.mean, expected)
                                     : score_p_values(scores_of(run_averages, expected), run_averages.count);
  if (run_averages.count >= kFewestRunsForScores) return scores;
  const double cube =
      equal ? scores.optimistic
            : student_upper_p_value(positive_mean_score(without_skewness(run_averages), expected),
                                    static_cast<double>(run_averages.count - 1));
  return {.optimistic = cube, .pessimistic = bound_p_values(run_averages, expected, least_dof).pessimistic};
}

LeastPValue least_run_mean_p_value(std::span<const SkewedMoments> averages, double expected,
                                   std::int64_t fewest) {
  require_positive("expected", expected);
  LeastPValue least;
  std::int64_t count = 0;  // of the runs that the scores so far are of
  DirectedScores furthest{};
  for (const SkewedMoments& moments : averages) {
    if (moments.count < fewest || !has_mean(moments)) continue;
    double p = 1.0;
    if (moments.count >= kFewestRunsForScores && !are_equal(moments, expected)) {
      const DirectedScores scores = scores_of(moments, expected);
      const bool as_many = moments.count == count;
      count = moments.count;
      if (as_many && scores.optimistic <= furthest.optimistic && scores.pessimistic <= furthest.pessimistic) {
        ++least.tests;
        continue;
      }
      furthest = as_many ? DirectedScores{std::max(furthest.optimistic, scores.optimistic),
                                          std::max(furthest.pessimistic, scores.pessimistic)}
                         : scores;
      p = score_p_values(scores, count).two_sided();
    } else {
      p = run_mean_p_values(moments, expected).two_sided();
    }
    if (std::isnan(p)) continue;
    least.p_value = std::min(least.p_value, p);
    ++least.tests;
  }
  return least;
}

MeanInterval run_mean_interval(const SkewedMoments& run_averages, double confidence, double least_dof) {
  require_confidence(confidence);
  require_positive("least_dof", least_dof);
  const double runs = static_cast<double>(run_averages.count);
  MeanInterval interval{
      .mean = run_averages.count > 0 ? run_averages.mean : kNaN,
      .lower = kNaN,
      .upper = kNaN,
      .standard_error = run_averages.count > 1 ? std::sqrt(run_averages.variance() / runs) : kNaN,
      .count = run_averages.count};
  if (!has_mean(run_averages)) {
    interval.reason = run_averages.count == 0 ? "no runs" : "the mean is negative or not finite";
    return interval;
  }
  const double tail = 0.5 * (1.0 - confidence);
  const double dof = runs * least_dof;
  if (run_averages.count == 1) {
    interval.lower = interval.mean * dof / chi_square_upper_tail_mean(tail, dof);
  } else {
    interval.lower = positive_mean_interval(without_skewness(run_averages), confidence).lower;
  }
  if (run_averages.count < kFewestRunsForScores) {
    interval.upper = interval.mean * dof / chi_square_lower_tail_mean(tail, dof);
    return interval;
  }
  interval.upper = interval.mean;
  if (run_averages.m2 > 0.0) {
    const double t = student_quantile_two_sided(confidence, runs - 1.0);
    const double far = pessimistic_quantile(tail, runs - 1.0);
    // No mean of NEES is below zero, whatever the score says.
    interval.lower = std::max(0.0, std::min(interval.lower, mean_of_hall_score(run_averages, t)));
    interval.upper = std::max(mean_of_positive_score(without_skewness(run_averages), -far),
                              mean_of_hall_score(run_averages, -far, cautious_skewness(run_averages)));
  }
  return interval;
}

}  // namespace credence::internal
