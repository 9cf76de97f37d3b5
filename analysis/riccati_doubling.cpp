#include "analysis/riccati_doubling.h"

#include <cmath>
#include <optional>

namespace credence {
namespace {

constexpr double kLargest = 1e100;  // squares of it are still finite
constexpr double kVisibleRounding = 1e-3;
constexpr double kSignificantIncrement = 1e-5;

/// Another point of the trajectory, near enough for the same P0 to be followed from it.
Matrix second_centre(const RiccatiProblem& problem, const Matrix& P0) {
  return riccati_step(problem, riccati_step(problem, riccati_step(problem, P0)));
}

double safe_log2_ratio(double now, double before) {
  return now > 0.0 && before > 0.0 ? std::log2(now / before) : 0.0;
}

/// h of the three traces before `end`.
double increment_exponent_at(const std::vector<double>& traces, std::size_t end) {
  if (end < 3) return 0.0;
  const double last = traces[end - 1] - traces[end - 2];
  const double before = traces[end - 2] - traces[end - 3];
  const double significant = kSignificantIncrement * traces[end - 1];
  return last > significant && before > 0.25 * significant ? std::log2(last / before) : 0.0;
}

}  // namespace

double RiccatiGrowth::steps() const { return std::exp2(static_cast<double>(traces.size()) - 1.0); }

double RiccatiGrowth::exponent() const {
  if (traces.size() < 2) return 0.0;
  return safe_log2_ratio(traces[traces.size() - 1], traces[traces.size() - 2]);
}

double RiccatiGrowth::increment_exponent() const { return increment_exponent_at(traces, traces.size()); }

double RiccatiGrowth::trace_per_step() const {
  if (traces.size() < 2) return 0.0;
  return (traces[traces.size() - 1] - traces[traces.size() - 2]) / (0.5 * steps());
}

bool RiccatiGrowth::grows() const {
  if (overflowed || exponent() > 0.5) return true;
  return increment_exponent() > 0.5 && increment_exponent_at(traces, traces.size() - 1) > 0.5;
}

RiccatiGrowth riccati_growth(const RiccatiProblem& problem, const Matrix& P0, int doublings,
                             GrowthGuard guard) {
  RiccatiMap map(problem, P0);
  std::optional<RiccatiMap> other;
  if (guard == GrowthGuard::two_maps) other.emplace(problem, second_centre(problem, P0));
  RiccatiGrowth growth;
  growth.P = map.after_centre();
  growth.traces.push_back(growth.P.trace());
  while (map.doublings() < doublings) {
    const bool finite = map.square() && (!other || other->square());
    const Matrix P = map.after_centre();
    if (!finite || P.cwiseAbs().maxCoeff() > kLargest) {
      growth.overflowed = true;
      break;
    }
    if (other && !((other->after(P0) - P).norm() <= kVisibleRounding * P.norm())) {
      growth.rounded = true;
      break;
    }
    growth.P = P;
    growth.traces.push_back(P.trace());
  }
  return growth;
}

}  // namespace credence
