#include "analysis/evidence/causes/lone_outliers.h"

#include "analysis/evidence/sums/evidence.h"

namespace credence::internal {

std::optional<LoneOutliers> find_lone_outliers(std::span<const std::vector<double>> runs, double dof) {
  constexpr std::int64_t kOneInRows = 20, kOneInOutliers = 5, kTenth = 10, kHalf = 2;
  const double most = outlier_limit(static_cast<Index>(dof)) / dof;
  LoneOutliers found;
  std::int64_t beside = 0, early = 0;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const std::vector<double>& run = runs[i];
    const auto rows = std::ssize(run);
    found.rows += rows;
    const auto beyond = [&](std::int64_t k) { return run[static_cast<std::size_t>(k)] > most; };
    for (std::int64_t k = 0; k < rows; ++k) {
      if (!beyond(k)) continue;
      if (found.count++ == 0) {
        found.run = static_cast<std::int64_t>(i);
        found.row = k;
      }
      found.at_one_step = found.at_one_step && k == found.row;
      beside += (k > 0 && beyond(k - 1)) || (k + 1 < rows && beyond(k + 1)) ? 1 : 0;
      early += kTenth * k < rows ? 1 : 0;
    }
  }
  const bool few = found.count > 0 && kOneInRows * found.count <= found.rows;
  const bool alone = kOneInOutliers * beside <= found.count && kHalf * early <= found.count;
  return few && alone ? std::optional(found) : std::nullopt;
}

}  // namespace credence::internal
