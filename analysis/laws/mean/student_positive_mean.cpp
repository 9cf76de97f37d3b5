#include "analysis/laws/mean/student_positive_mean.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/nan.h"

namespace credence::internal {
namespace {

// The c of the header, the variance of the cube root.
double cube_root_variance(const Moments& moments) {
  const double count = static_cast<double>(moments.count);
  const double shape = moments.mean * moments.mean / moments.variance() - 1.0 / count;
  // s²/x̄² is at most M for positive values; equality, all but one value zero, must not give a negative shape.
  constexpr double kSmallestDof = 1e-3;
  return 2.0 / (9.0 * std::max(kSmallestDof, 2.0 * count * shape));
}

bool has_variance(const Moments& moments) {
  return moments.count >= 2 && std::isfinite(moments.mean) && std::isfinite(moments.m2) && moments.mean > 0.0;
}

}  // namespace

double positive_mean_score(const Moments& moments, double expected) {
  if (!has_variance(moments) || moments.m2 <= 0.0) return kNaN;
  const double c = cube_root_variance(moments);
  return (std::cbrt(moments.mean / expected) - (1.0 - c)) / std::sqrt(c);
}

double mean_of_positive_score(const Moments& moments, double z) {
  if (!has_variance(moments) || moments.m2 <= 0.0) return kNaN;
  const double c = cube_root_variance(moments);
  const double root = 1.0 - c + z * std::sqrt(c);
  return root > 0.0 ? moments.mean / std::pow(root, 3) : std::numeric_limits<double>::infinity();
}

double positive_mean_p_value(const Moments& moments, double expected) {
  if (!(expected > 0.0)) throw std::invalid_argument(fmt::format("expected = {} must be > 0", expected));
  if (!has_variance(moments)) return kNaN;
  if (moments.m2 <= 0.0) return moments.mean == expected ? 1.0 : 0.0;
  return student_two_sided_p_value(positive_mean_score(moments, expected),
                                   static_cast<double>(moments.count - 1));
}

MeanInterval positive_mean_interval(const Moments& moments, double confidence) {
  MeanInterval interval = student_interval(moments, confidence);
  if (!interval.reason.empty()) return interval;
  if (!has_variance(moments) && moments.m2 > 0.0) {
    interval.lower = interval.upper = kNaN;
    interval.reason = "the mean is not positive";
    return interval;
  }
  if (moments.m2 <= 0.0) return interval;
  const double t = student_quantile_two_sided(confidence, static_cast<double>(moments.count - 1));
  // Of values so scattered that the score would reject their own mean the interval begins there.
  interval.lower = std::min(moments.mean, mean_of_positive_score(moments, t));
  interval.upper = mean_of_positive_score(moments, -t);
  return interval;
}

}  // namespace credence::internal
