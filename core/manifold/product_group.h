#pragma once

#include "core/manifold/lie_group.h"

namespace credence {

/// A × B: pairs, each factor for itself; tangent vectors are (ξ_A, ξ_B).
template <LieGroup A, LieGroup B>
class ProductGroup : public LieTypes<A::kDim + B::kDim> {
  using Types = LieTypes<A::kDim + B::kDim>;

 public:
  using typename Types::Jacobian;
  using typename Types::Tangent;
  using Split = ProductGroup<typename A::Split, typename B::Split>;

  ProductGroup() = default;  ///< the identity
  ProductGroup(const A& first, const B& second) : first_(first), second_(second) {}

  const A& first() const { return first_; }
  const B& second() const { return second_; }

  static ProductGroup Exp(const Tangent& xi) { return {A::Exp(head(xi)), B::Exp(tail(xi))}; }
  Tangent Log() const {
    Tangent xi;
    xi << first_.Log(), second_.Log();
    return xi;
  }
  ProductGroup operator*(const ProductGroup& other) const {
    return {first_ * other.first_, second_ * other.second_};
  }
  ProductGroup inverse() const { return {first_.inverse(), second_.inverse()}; }
  Jacobian adjoint() const { return diagonal(first_.adjoint(), second_.adjoint()); }
  static Jacobian left_jacobian(const Tangent& xi) {
    return diagonal(A::left_jacobian(head(xi)), B::left_jacobian(tail(xi)));
  }
  static Jacobian left_jacobian_inverse(const Tangent& xi) {
    return diagonal(A::left_jacobian_inverse(head(xi)), B::left_jacobian_inverse(tail(xi)));
  }
  Split split() const { return {first_.split(), second_.split()}; }
  static ProductGroup join(const Split& split) { return {A::join(split.first()), B::join(split.second())}; }
  Jacobian split_jacobian() const { return diagonal(first_.split_jacobian(), second_.split_jacobian()); }

 private:
  static typename A::Tangent head(const Tangent& xi) { return xi.template head<A::kDim>(); }
  static typename B::Tangent tail(const Tangent& xi) { return xi.template tail<B::kDim>(); }
  static Jacobian diagonal(const typename A::Jacobian& a, const typename B::Jacobian& b) {
    Jacobian D = Jacobian::Zero();
    D.template topLeftCorner<A::kDim, A::kDim>() = a;
    D.template bottomRightCorner<B::kDim, B::kDim>() = b;
    return D;
  }

  A first_;
  B second_;
};

}  // namespace credence
