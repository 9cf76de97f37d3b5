#pragma once

#include <cstdint>

#include "core/record/block_layout.h"
#include "core/types.h"

namespace credence {

/// Where the range of a constant ΔP lies (theory, section 5).
enum class InflationRange {
  generic,       ///< anywhere in the state space
  map,           ///< in the landmarks: no vehicle state is touched
  with_vehicle,  ///< it contains the directions G that the process noise drives
  difference,    ///< in the differences of landmarks: their common translation is left alone, and the vehicle
};

/// A constant pseudo-noise ΔP = scale · U Uᵀ with r orthonormal columns in U.
struct RankInflation {
  Index rank = 0;  ///< r
  InflationRange range = InflationRange::generic;
  double scale = 1.0;      ///< every non-zero eigenvalue of ΔP, in the units of the covariance
  std::uint64_t seed = 1;  ///< of the directions
};

/// The largest rank that fits into a range: n, n_f, n or n_f − d.
Index max_inflation_rank(const internal::BlockLayout& layout, InflationRange range);

/// ΔP, n×n, symmetric to the last bit, of exactly the rank asked for.
///
/// The directions are uniformly distributed in the range and depend on the seed only (std::mt19937_64 with
/// Box-Muller, columns in order), so that the range of a lower rank lies within that of a higher one.
/// G is n×q, needed for with_vehicle. Throws std::invalid_argument for a rank that does not fit
/// (with_vehicle: from 1 to below rank G too), a negative or infinite scale, or, of a rank above 0, a G of
/// other height.
Matrix rank_inflation(const internal::BlockLayout& layout, const MatrixRef& G, const RankInflation& spec);

}  // namespace credence
