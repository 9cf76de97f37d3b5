#pragma once

#include <span>

#include "core/record/block_layout.h"
#include "core/types.h"

namespace credence {

/// A linear time-invariant estimation problem, the monobot of the paper and any of the user's own:
///
///   x⁺ = F x + u + G v,  v ~ N(0, Q)        (n states, q process noises)
///   z  = H x + w,        w ~ N(0, R)        (m measurements)
///   x_0 − x̂_0 ~ N(0, P0)
///
/// Shapes: F n×n, G n×q, Q q×q, H m×n, R m×m, P0 n×n; Q, R, P0 symmetric, Q and P0 may be singular.
struct LinearModel {
  Matrix F, G, Q, H, R, P0;
  internal::BlockLayout layout;  ///< which states are the vehicle and which the landmarks

  Index state_dim() const { return F.rows(); }
  Index measurement_dim() const { return H.rows(); }
};

/// The model of step k, from 1 on, of a system whose matrices repeat themselves after those of `period`.
inline const LinearModel& model_at(std::span<const LinearModel> period, Index k) {
  return period[static_cast<std::size_t>(k - 1) % period.size()];
}

/// The monobot (theory, section 2; [Vidal-Calleja 2004], eqs (13)-(15)): a vehicle on a line that sees every
/// landmark at every step, x = [r, f_1 … f_N], F = I, G = [1 0 … 0]ᵀ, z_i = f_i − r + w_i.
///
/// With `anchors` > 0 that many more landmarks stand at known positions a and are no states: their
/// measurement, less the known a, is z_a − a = −r + w; they are the first rows of H.
/// Variances in m²; throws std::invalid_argument for a negative count or variance, or no measurement at all.
LinearModel monobot_model(Index landmarks, Index anchors, double process_variance,
                          double measurement_variance, double initial_variance);

}  // namespace credence
