#include "analysis/laws/shape/component_variances.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "analysis/laws/chi_square/chi_square.h"
#include "analysis/laws/require.h"

namespace credence::internal {

ComponentTest test_components(std::span<const Moments> values, double confidence, double correlation_time) {
  require_confidence(confidence);
  ComponentTest result;
  const bool some = std::ranges::any_of(values, [](const Moments& m) { return m.count > 0; });
  if (values.size() < 2 || !some) {
    result.reason = "no innovations of several components of their own";
    return result;
  }
  const double tail = 0.5 * (1.0 - confidence), tests = static_cast<double>(values.size());
  double optimistic = 1.0, pessimistic = 1.0, least = std::numeric_limits<double>::infinity();
  double largest = 0.0;
  for (std::size_t j = 0; j < values.size(); ++j) {
    ComponentVariance& component = result.components.emplace_back();
    component.count = values[j].count;
    if (component.count == 0) continue;
    const auto n = static_cast<double>(component.count) / correlation_time;
    component.mean = values[j].mean;
    component.lower = n * component.mean / chi_square_upper_quantile(tail, n);
    component.upper = n * component.mean / chi_square_quantile(tail, n);
    component.p_value = {.optimistic = std::min(1.0, 2.0 * chi_square_survival(n * component.mean, n)),
                         .pessimistic = std::min(1.0, 2.0 * chi_square_cdf(n * component.mean, n))};
    optimistic = std::min(optimistic, tests * component.p_value.optimistic);
    pessimistic = std::min(pessimistic, tests * component.p_value.pessimistic);
    // Of values that are all beyond arithmetic the larger factor counts.
    const double size = std::abs(std::log(component.mean));
    const double p = std::min(component.p_value.optimistic, component.p_value.pessimistic);
    if (p > least || (p == least && size <= largest)) continue;
    least = p;
    largest = size;
    result.worst = static_cast<Index>(j);
  }
  result.p_value = {.optimistic = optimistic, .pessimistic = pessimistic};
  return result;
}

}  // namespace credence::internal
