#include "analysis/laws/mean/step_profile.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "analysis/laws/mean/student.h"
#include "core/nan.h"
#include "montecarlo/engine/moments.h"

namespace credence::internal {

double step_profile_p_value(std::span<const std::vector<double>> runs, std::size_t stretches) {
  constexpr std::size_t kFewest = 20;
  if (runs.size() < 2 || runs.size() * stretches < kFewest) return kNaN;
  std::array<std::vector<double>, 2> profile;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    std::vector<double>& sums = profile[i % 2];
    sums.resize(std::max(sums.size(), runs[i].size()), 0.0);
    for (std::size_t k = 0; k < runs[i].size(); ++k) sums[k] += runs[i][k] - 1.0;
  }
  std::array<Moments, 2> projections;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const std::vector<double>& of_others = profile[1 - i % 2];
    const std::size_t length = runs[i].size() / stretches;
    for (std::size_t from = 0; length > 0 && from + length <= runs[i].size(); from += length) {
      double projection = 0.0;
      for (std::size_t k = from; k < std::min(of_others.size(), from + length); ++k)
        projection += of_others[k] * (runs[i][k] - 1.0);
      projections[i % 2].add(projection);
    }
  }
  double smallest = kNaN;
  for (const Moments& m : projections) {
    const double t = m.mean / std::sqrt(m.variance() / static_cast<double>(m.count));
    smallest = std::fmin(smallest, student_upper_p_value(t, static_cast<double>(m.count - 1)));
  }
  return std::min(1.0, 2.0 * smallest);
}

}  // namespace credence::internal
