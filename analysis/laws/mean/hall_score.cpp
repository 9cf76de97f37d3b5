#include "analysis/laws/mean/hall_score.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/nan.h"

namespace credence::internal {
namespace {

/// In a few skewed values the large ones may be missing, and with them most of the variance.
double skewed_dof(const SkewedMoments& moments) {
  constexpr std::int64_t kFew = 20;
  const auto dof = static_cast<double>(moments.count - 1);
  return moments.count < kFew ? 0.5 * dof : dof;
}

}  // namespace

double sample_skewness(const SkewedMoments& moments) {
  const double cube = std::pow(moments.m2, 1.5);
  if (!(cube >= std::numeric_limits<double>::min())) return 0.0;
  return std::sqrt(static_cast<double>(moments.count)) * moments.m3 / cube;
}

double hall_score(const SkewedMoments& moments, double expected, double gamma) {
  const double root_runs = std::sqrt(static_cast<double>(moments.count));
  const double u = (moments.mean - expected) / std::sqrt(moments.variance());
  return root_runs * u * (1.0 + gamma * u / 3.0 + gamma * gamma * u * u / 27.0) + gamma / (6.0 * root_runs);
}

double hall_score(const SkewedMoments& moments, double expected) {
  return hall_score(moments, expected, sample_skewness(moments));
}

double mean_of_hall_score(const SkewedMoments& moments, double z, double gamma) {
  const double root_runs = std::sqrt(static_cast<double>(moments.count));
  const double y = (z - gamma / (6.0 * root_runs)) / root_runs;
  const double x = gamma * y;
  double u = y;
  if (std::abs(x) >= 0.5) {
    u = 3.0 / gamma * (std::cbrt(1.0 + x) - 1.0);
  } else if (gamma != 0.0) {
    u = 3.0 / gamma * std::expm1(std::log1p(x) / 3.0);
  }
  return moments.mean - std::sqrt(moments.variance()) * u;
}

double mean_of_hall_score(const SkewedMoments& moments, double z) {
  return mean_of_hall_score(moments, z, sample_skewness(moments));
}

MeanInterval hall_interval(const SkewedMoments& moments, double confidence) {
  MeanInterval interval =
      student_interval({.count = moments.count, .mean = moments.mean, .m2 = moments.m2}, confidence);
  if (!interval.reason.empty() || !(moments.m2 > 0.0)) return interval;
  if (!std::isfinite(moments.m3)) {
    interval.lower = interval.upper = kNaN;
    interval.reason = "the skewness is not finite";
    return interval;
  }
  const double t = student_quantile_two_sided(confidence, skewed_dof(moments));
  interval.lower = mean_of_hall_score(moments, t);
  interval.upper = mean_of_hall_score(moments, -t);
  return interval;
}

MeanInterval paired_interval(const SkewedMoments& differences, double confidence) {
  MeanInterval interval = hall_interval(differences, confidence);
  if (!interval.reason.empty() || !(differences.m2 > 0.0)) return interval;
  const double t = student_quantile_two_sided(confidence, skewed_dof(differences));
  const double error = std::sqrt(differences.variance() / static_cast<double>(differences.count));
  interval.lower = std::min(interval.lower, differences.mean - t * error);
  interval.upper = std::max(interval.upper, differences.mean + t * error);
  return interval;
}

double paired_p_value(const SkewedMoments& differences) {
  if (differences.count < 2) return kNaN;
  if (differences.m2 == 0.0) return differences.mean == 0.0 ? 1.0 : 0.0;
  const double dof = skewed_dof(differences);
  const double student =
      differences.mean / std::sqrt(differences.variance() / static_cast<double>(differences.count));
  return std::max(student_two_sided_p_value(student, dof),
                  student_two_sided_p_value(hall_score(differences, 0.0), dof));
}

}  // namespace credence::internal
