#include "analysis/laws/mean/mean_at_steps.h"

#include <algorithm>

#include "analysis/laws/mean/zero_mean.h"

namespace credence::internal {

MeanAtSteps test_mean_at_steps(const std::map<std::int64_t, VectorMoments>& whitened) {
  constexpr std::int64_t kFewest = 10;
  double of_mean = 0.0, excess = 0.0, least = 1.0, steps = 0.0;
  for (const auto& [step, errors] : whitened) {
    if (errors.count < kFewest && errors.count <= errors.mean.size()) continue;
    const ZeroMeanTest test = test_zero_mean(errors);
    if (!test.reason.empty()) continue;
    const auto runs = static_cast<double>(errors.count);
    const double square = errors.mean.squaredNorm(), spread = errors.scatter.trace();
    of_mean += square - spread / (runs * (runs - 1.0));
    excess += square + spread / runs - static_cast<double>(errors.mean.size());
    least = std::min(least, test.p_value);
    steps += 1.0;
  }
  return {.explained = excess > 0.0 ? std::max(0.0, of_mean) / excess : 0.0,
          .p_value = std::min(1.0, steps > 0.0 ? steps * least : 1.0)};
}

}  // namespace credence::internal
