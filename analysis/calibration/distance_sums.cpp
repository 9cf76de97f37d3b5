#include "analysis/calibration/distance_sums.h"

#include <utility>

namespace credence::internal {

void DistanceSums::Bin::merge(const Bin& later) {
  rows += later.rows;
  nees += later.nees;
  squared += later.squared;
  variance += later.variance;
}

void DistanceSums::add(double distance_m, const Bin& row) {
  constexpr double kFarthest_m = 1e12;
  if (!(distance_m >= 0.0 && distance_m <= kFarthest_m)) return;
  while (distance_m >= length_m_ * static_cast<double>(kMost)) widen(2.0 * length_m_);
  const auto i = static_cast<std::size_t>(distance_m / length_m_);
  if (bins_.size() <= i) bins_.resize(i + 1);
  bins_[i].merge(row);
}

void DistanceSums::widen(double length_m) {
  while (length_m_ < length_m) {
    length_m_ *= 2.0;
    std::vector<Bin> joined((bins_.size() + 1) / 2);
    for (std::size_t i = 0; i < bins_.size(); ++i) joined[i / 2].merge(bins_[i]);
    bins_ = std::move(joined);
  }
}

}  // namespace credence::internal
