#pragma once

#include <span>

#include "core/models/linear_model.h"

namespace credence::internal {

/// A periodic model seen once a period: the time-invariant model of s = x at the end of a period ([Bittanti
/// 2009]), so that everything known of time-invariant systems can be asked of it.
///
///   s⁺ = Φ s + B n,  y = O s + D n + w,
///
/// with n and w the noises and y the measurements of the p steps that follow s. Process and measurement noise
/// are correlated, C = B Q Dᵀ; as with R' = D Q Dᵀ + R the part C R'⁻¹ y of the process noise is known, the
/// filter is that of F = Φ − C R'⁻¹ O, Q' = B Q Bᵀ − C R'⁻¹ Cᵀ, H = O and R'. Its prior covariance in the
/// predictor form is the filter's P after the update at the end of each period, P0 to begin with.
///
/// n states, p·m measurements; G is the identity. Throws std::invalid_argument where R' is not positive
/// definite.
LinearModel lifted_model(std::span<const LinearModel> period);

}  // namespace credence::internal
