#pragma once

#include <concepts>

#include "core/types.h"

/// @file
/// What a matrix Lie group is here, and what follows for all of them ([Sola 2018]).
///
/// Tangent vectors ξ hold the translations first and the rotation last: (x, y, θ) of SE(2), (ρ, φ) of SE(3),
/// (position, velocity, φ) of SE_2(3), φ a rotation vector in rad. Everything is of fixed size and allocates
/// nothing; Log is the principal one, its angle in (−π, π] or its rotation vector no longer than π.

namespace credence {

/// Exp(ξ), Log, product and inverse; Ad_x of x Exp(ξ) x⁻¹ = Exp(Ad_x ξ); the left Jacobian J_l of
/// Exp(ξ + δ) = Exp(J_l(ξ) δ) Exp(ξ) to first order in δ, and its inverse, of |angle| < 2π.
///
/// `Split` is the direct product of the same translations and rotation, in which the group is taken
/// componentwise: split() and join() go there and back, and split_jacobian() is D of
/// split(x Exp(δ)) = split(x) Exp(D δ) to first order, an orthogonal matrix.
template <class G>
concept LieGroup = requires(const G& x, const typename G::Tangent& xi, const typename G::Split& split) {
  { G::kDim } -> std::convertible_to<int>;
  { G::Exp(xi) } -> std::same_as<G>;
  { x.Log() } -> std::same_as<typename G::Tangent>;
  { x* x } -> std::same_as<G>;
  { x.inverse() } -> std::same_as<G>;
  { x.adjoint() } -> std::same_as<typename G::Jacobian>;
  { G::left_jacobian(xi) } -> std::same_as<typename G::Jacobian>;
  { G::left_jacobian_inverse(xi) } -> std::same_as<typename G::Jacobian>;
  { x.split() } -> std::same_as<typename G::Split>;
  { G::join(split) } -> std::same_as<G>;
  { x.split_jacobian() } -> std::same_as<typename G::Jacobian>;
};

/// The types of a group of dimension n.
template <int n>
struct LieTypes {
  static constexpr int kDim = n;
  using Tangent = Eigen::Matrix<double, n, 1>;
  using Jacobian = Eigen::Matrix<double, n, n>;
};

/// J_r(ξ) of Exp(ξ + δ) = Exp(ξ) Exp(J_r(ξ) δ) to first order in δ.
template <LieGroup G>
typename G::Jacobian right_jacobian(const typename G::Tangent& xi) {
  return G::left_jacobian(-xi);
}
/// J_r(ξ)⁻¹.
template <LieGroup G>
typename G::Jacobian right_jacobian_inverse(const typename G::Tangent& xi) {
  return G::left_jacobian_inverse(-xi);
}

}  // namespace credence
