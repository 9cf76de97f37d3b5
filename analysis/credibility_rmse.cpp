#include "analysis/credibility_rmse.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "analysis/chi_square.h"

namespace credence {

RmseInterval rmse_interval(const Moments& squared_errors, double confidence) {
  if (!(confidence > 0.0 && confidence < 1.0)) {
    throw std::invalid_argument(fmt::format("confidence = {} must lie in (0, 1)", confidence));
  }
  RmseInterval interval;
  interval.count = squared_errors.count;
  interval.rmse = std::sqrt(squared_errors.mean);
  interval.lower = interval.upper = interval.effective_dof = std::numeric_limits<double>::quiet_NaN();
  if (squared_errors.count < 2) {
    interval.reason = squared_errors.count == 1 ? "one run has no variance" : "no data";
    return interval;
  }
  if (!std::isfinite(squared_errors.mean) || !std::isfinite(squared_errors.m2) || squared_errors.mean < 0.0) {
    interval.reason = "the mean square is negative or not finite";
    return interval;
  }
  if (squared_errors.m2 <= 0.0) {
    interval.lower = interval.upper = interval.rmse;
    interval.effective_dof = std::numeric_limits<double>::infinity();
    return interval;
  }
  const double mean = squared_errors.mean;
  // For gamma values E[s²/x̄²] = 1 / (shape + 1/M) exactly: the 2 removes that bias.
  const double count = static_cast<double>(squared_errors.count);
  const double dof = std::max(1.0, 2.0 * mean * mean * count / squared_errors.variance() - 2.0);
  const ChiSquareBounds ratio = mean_bounds(dof, dof, confidence);
  interval.effective_dof = dof;
  interval.lower = std::sqrt(mean / ratio.upper);
  interval.upper = std::sqrt(mean / ratio.lower);
  return interval;
}

}  // namespace credence
