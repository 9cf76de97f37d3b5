#pragma once

#include <string_view>

#include "core/manifold/lie_group.h"

/// @file
/// Charts: what the coordinates ξ of a state y about a state x mean, in which an error is stated and a
/// covariance holds.

namespace credence {

/// y = x ⊞ ξ.
enum class Chart {
  right,          ///< y = x Exp(ξ): ξ in the axes of the body. Of the left-invariant error x̂⁻¹ x.
  left,           ///< y = Exp(ξ) x: ξ in the axes of the world. Of the right-invariant error x x̂⁻¹.
  componentwise,  ///< vectors by their differences, the rotation by its right chart
  componentwise_left,  ///< vectors by their differences, the rotation by its left chart
};

/// The word of scenario files and JSON for a chart.
constexpr std::string_view chart_name(Chart chart) {
  constexpr std::string_view kNames[] = {"right", "left", "componentwise", "componentwise_left"};
  return kNames[static_cast<std::size_t>(chart)];
}

/// x ⊞ ξ.
template <LieGroup G>
G plus(const G& x, const typename G::Tangent& xi, Chart chart) {
  switch (chart) {
    case Chart::right: return x * G::Exp(xi);
    case Chart::left: return G::Exp(xi) * x;
    case Chart::componentwise: return G::join(plus(x.split(), xi, Chart::right));
    case Chart::componentwise_left: break;
  }
  return G::join(plus(x.split(), xi, Chart::left));
}

/// y ⊟ x: the ξ of y = x ⊞ ξ whose angle is at most π.
template <LieGroup G>
typename G::Tangent minus(const G& y, const G& x, Chart chart) {
  switch (chart) {
    case Chart::right: return (x.inverse() * y).Log();
    case Chart::left: return (y * x.inverse()).Log();
    case Chart::componentwise: return minus(y.split(), x.split(), Chart::right);
    case Chart::componentwise_left: break;
  }
  return minus(y.split(), x.split(), Chart::left);
}

/// D of (y Exp(δ)) ⊟ x = y ⊟ x + D δ to first order in δ.
template <LieGroup G>
typename G::Jacobian minus_jacobian(const G& y, const G& x, Chart chart) {
  switch (chart) {
    case Chart::right: return right_jacobian_inverse<G>(minus(y, x, Chart::right));
    case Chart::left: return right_jacobian_inverse<G>(minus(y, x, Chart::left)) * x.adjoint();
    case Chart::componentwise: return minus_jacobian(y.split(), x.split(), Chart::right) * y.split_jacobian();
    case Chart::componentwise_left: break;
  }
  return minus_jacobian(y.split(), x.split(), Chart::left) * y.split_jacobian();
}

/// D of x ⊞ (ξ + D' δ) = (x ⊞ ξ) Exp(δ), y = x ⊞ ξ: the inverse of minus_jacobian, in closed form.
template <LieGroup G>
typename G::Jacobian plus_jacobian(const G& y, const G& x, Chart chart) {
  switch (chart) {
    case Chart::right: return right_jacobian<G>(minus(y, x, Chart::right));
    case Chart::left: return x.inverse().adjoint() * right_jacobian<G>(minus(y, x, Chart::left));
    case Chart::componentwise: {
      // Block diagonal of rotations: its inverse is its transpose.
      return y.split_jacobian().transpose() * plus_jacobian(y.split(), x.split(), Chart::right);
    }
    case Chart::componentwise_left: break;
  }
  return y.split_jacobian().transpose() * plus_jacobian(y.split(), x.split(), Chart::left);
}

/// The Jacobian of ξ' by ξ, where ξ and ξ' are the coordinates of y about x in the charts `from` and `to`.
template <LieGroup G>
typename G::Jacobian chart_jacobian(const G& y, const G& x, Chart from, Chart to) {
  return minus_jacobian(y, x, to) * plus_jacobian(y, x, from);
}

/// The covariance P of the coordinates about x in another chart: exact for small errors, and for errors of
/// any size where the change is linear, which it is between right and left (Ad_x). About an error that is
/// known, chart_jacobian(y, x, …) takes the place of chart_jacobian(x, x, …).
template <LieGroup G>
typename G::Jacobian transported(const typename G::Jacobian& P, const G& x, Chart from, Chart to) {
  if (from == to) return P;
  const typename G::Jacobian T = chart_jacobian(x, x, from, to);
  return T * P * T.transpose();
}

}  // namespace credence
