#include "analysis/laws/power_law.h"

#include <cmath>
#include <stdexcept>

#include "analysis/laws/mean/student.h"
#include "core/nan.h"
#include "core/types.h"

namespace credence::internal {
namespace {

Vector logarithms(std::span<const double> values) {
  Vector logs(static_cast<Index>(values.size()));
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!(values[i] > 0.0 && std::isfinite(values[i]))) {
      throw std::invalid_argument("a power law is fitted to positive values");
    }
    logs[static_cast<Index>(i)] = std::log(values[i]);
  }
  return logs;
}

}  // namespace

PowerLaw fit_power_law(std::span<const double> x, std::span<const double> y) {
  if (x.size() != y.size() || x.size() < 2) {
    throw std::invalid_argument("a power law needs two points at least");
  }
  const Vector log_x = logarithms(x), log_y = logarithms(y);
  const Vector dx = log_x.array() - log_x.mean(), dy = log_y.array() - log_y.mean();
  const double spread = dx.squaredNorm();
  if (!(spread > 0.0)) throw std::invalid_argument("a power law needs two different x");
  PowerLaw law;
  law.exponent = dx.dot(dy) / spread;
  law.lower = law.upper = kNaN;
  const double dof = static_cast<double>(x.size()) - 2.0;
  if (dof > 0.0) {
    const double error = std::sqrt((dy - law.exponent * dx).squaredNorm() / dof / spread);
    const double t = student_quantile_two_sided(0.95, dof);
    law.lower = law.exponent - t * error;
    law.upper = law.exponent + t * error;
  }
  return law;
}

}  // namespace credence::internal
