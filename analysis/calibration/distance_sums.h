#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace credence::internal {

/// What a filter believes and errs over the way that its body has come, in equal lengths of the way.
///
/// The length is 2^k m, doubled as the way grows, so that there are at most kMost of them and those of two
/// runs can be brought to one length.
class DistanceSums {
 public:
  static constexpr std::size_t kMost = 16;

  /// Sums over rows.
  struct Bin {
    std::int64_t rows = 0;
    double nees = 0.0;                     ///< Σ eᵀ P⁻¹ e / n
    double squared = 0.0, variance = 0.0;  ///< of the position: Σ ‖e‖², Σ tr P; m²

    void merge(const Bin& later);
  };

  /// distance_m: from the start of the run; what is not finite or negative is left out.
  void add(double distance_m, const Bin& row);
  /// Joins neighbours until a bin has this length, one of those that another has.
  void widen(double length_m);

  double length_m() const { return length_m_; }
  const std::vector<Bin>& bins() const { return bins_; }

 private:
  double length_m_ = 0x1p-10;
  std::vector<Bin> bins_;
};

}  // namespace credence::internal
