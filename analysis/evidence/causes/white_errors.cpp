#include "analysis/evidence/causes/white_errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "montecarlo/engine/moments.h"

namespace credence::internal {

double white_share_of(const std::vector<std::vector<double>>& nees) {
  constexpr std::size_t kLags = 5;  // from 0
  constexpr std::int64_t kFewestPairs = 500;
  constexpr double kLeastLeft = 0.5, kErrors = 2.0;
  Moments all;
  for (const std::vector<double>& run : nees) {
    for (const double value : run)
      if (std::isfinite(value)) all.add(value);
  }
  std::array<Moments, kLags> products;
  for (const std::vector<double>& run : nees) {
    for (std::size_t k = 0; k < run.size(); ++k) {
      for (std::size_t h = 0; h < kLags && h <= k; ++h) {
        const double product = (run[k] - all.mean) * (run[k - h] - all.mean);
        if (std::isfinite(product)) products[h].add(product);
      }
    }
  }
  if (std::ranges::any_of(products, [](const Moments& lag) { return lag.count < kFewestPairs; })) return 0.0;
  const double near = 0.5 * (products[1].mean + products[2].mean);
  const double far = 0.5 * (products[3].mean + products[4].mean);
  const double error = products[0].mean / std::sqrt(2.0 * static_cast<double>(products[1].count));
  if (!(std::min(near, far) > kErrors * error) || !(far > kLeastLeft * near)) return 0.0;
  const double fades = std::min(1.0, far / near);
  return std::max(0.0, 1.0 - near * std::pow(fades, -0.75) / products[0].mean);
}

}  // namespace credence::internal
