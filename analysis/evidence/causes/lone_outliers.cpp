#include "analysis/evidence/causes/lone_outliers.h"

#include "analysis/evidence/sums/evidence.h"
#include "analysis/laws/chi_square/chi_square.h"

namespace credence::internal {

std::optional<LoneOutliers> find_lone_outliers(std::span<const std::vector<double>> runs, double dof) {
  constexpr std::int64_t kOneInRows = 20, kOneInOutliers = 5, kTenth = 10, kHalf = 2;
  constexpr double kUsual = 0.01;  ///< beyond this upper quantile a row beside is not what it usually is
  const double most = outlier_limit(static_cast<Index>(dof)) / dof;
  const double usual = chi_square_upper_quantile(kUsual, dof) / dof;
  LoneOutliers found;
  std::int64_t beside = 0, early = 0;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const std::vector<double>& run = runs[i];
    const auto rows = std::ssize(run);
    found.rows += rows;
    const auto is_above = [&](std::int64_t k, double level) {
      return k >= 0 && k < rows && run[static_cast<std::size_t>(k)] > level;
    };
    const auto has_beside = [&](std::int64_t k, double level) {
      return is_above(k - 1, level) || is_above(k + 1, level);
    };
    for (std::int64_t k = 0; k < rows; ++k) {
      if (!is_above(k, most)) continue;
      if (found.count++ == 0) {
        found.run = static_cast<std::int64_t>(i);
        found.row = k;
      }
      found.at_one_step = found.at_one_step && k == found.row;
      beside += has_beside(k, most) ? 1 : 0;
      early += kTenth * k < rows && (k == 0 || has_beside(k, usual)) ? 1 : 0;
    }
  }
  const bool few = found.count > 0 && kOneInRows * found.count <= found.rows;
  const bool alone = kOneInOutliers * beside <= found.count && kHalf * early <= found.count;
  return few && alone ? std::optional(found) : std::nullopt;
}

}  // namespace credence::internal
