#include "analysis/laws/mean/student.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <stdexcept>

#include "analysis/laws/require.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

// Double alone has 13 digits, in a fraction of the time of long double.
using Student = boost::math::students_t_distribution<
    double, boost::math::policies::policy<boost::math::policies::promote_double<false>>>;

void require_dof(double dof) {
  if (!(dof > 0.0)) throw std::invalid_argument(fmt::format("dof = {} must be > 0", dof));
}

}  // namespace

double student_quantile_two_sided(double confidence, double dof) {
  require_dof(dof);
  require_confidence(confidence);
  // Of many samples of one size the same one is asked for again and again, and takes microseconds.
  struct Last {
    double confidence = 0.0, dof = 0.0, quantile = 0.0;
  };
  thread_local Last last;
  if (confidence != last.confidence || dof != last.dof) {
    const Student law(dof);
    last = {confidence, dof, quantile(complement(law, 0.5 * (1.0 - confidence)))};
  }
  return last.quantile;
}

double student_upper_p_value(double t, double dof) {
  const double tail = 0.5 * student_two_sided_p_value(t, dof);
  return t < 0.0 ? 1.0 - tail : tail;
}

double student_two_sided_p_value(double t, double dof) {
  require_dof(dof);
  if (std::isnan(t)) return t;
  if (std::isinf(t)) return 0.0;
  const Student law(dof);
  return std::min(1.0, 2.0 * cdf(complement(law, std::abs(t))));
}

MeanInterval student_interval(const Moments& moments, double confidence) {
  MeanInterval interval;
  interval.mean = moments.mean;
  interval.count = moments.count;
  interval.lower = interval.upper = interval.standard_error = kNaN;
  const double t = student_quantile_two_sided(
      confidence, static_cast<double>(std::max<std::int64_t>(1, moments.count - 1)));
  if (moments.count < 2) {
    interval.reason = moments.count == 1 ? "one value has no variance" : "no data";
    return interval;
  }
  if (!std::isfinite(moments.mean) || !std::isfinite(moments.m2)) {
    interval.reason = "the mean or its variance is not finite";
    return interval;
  }
  interval.standard_error = std::sqrt(moments.variance() / static_cast<double>(moments.count));
  interval.lower = moments.mean - t * interval.standard_error;
  interval.upper = moments.mean + t * interval.standard_error;
  return interval;
}

}  // namespace credence::internal
