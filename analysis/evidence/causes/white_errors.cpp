#include "analysis/evidence/causes/white_errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>

#include "core/nan.h"
#include "montecarlo/engine/moments.h"

namespace credence::internal {
namespace {

/// The 0.9 quantile of all that are finite.
double largest_counted(const std::vector<std::vector<double>>& nees) {
  std::vector<double> values;
  for (const std::vector<double>& run : nees)
    std::ranges::copy_if(run, std::back_inserter(values), [](double value) { return std::isfinite(value); });
  if (values.empty()) return kNaN;
  const auto at = values.begin() + std::ssize(values) * 9 / 10;
  std::ranges::nth_element(values, at);
  return *at;
}

}  // namespace

double white_share_of(const std::vector<std::vector<double>>& nees) {
  constexpr std::size_t kLags = 5;  // from 0
  constexpr std::int64_t kFewestPairs = 500;
  constexpr double kLeastLeft = 0.5, kErrors = 2.0;
  const double most = largest_counted(nees);
  Moments all;
  for (const std::vector<double>& run : nees) {
    for (const double value : run)
      if (std::isfinite(value)) all.add(std::min(value, most));
  }
  std::array<Moments, kLags> products;
  for (const std::vector<double>& run : nees) {
    for (std::size_t k = 0; k < run.size(); ++k) {
      for (std::size_t h = 0; h < kLags && h <= k; ++h) {
        if (!std::isfinite(run[k]) || !std::isfinite(run[k - h])) continue;
        products[h].add((std::min(run[k], most) - all.mean) * (std::min(run[k - h], most) - all.mean));
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
