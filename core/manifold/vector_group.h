#pragma once

#include "core/manifold/lie_group.h"

namespace credence {

/// Rⁿ under addition.
template <int n>
class VectorGroup : public LieTypes<n> {
 public:
  using typename LieTypes<n>::Tangent;
  using typename LieTypes<n>::Jacobian;
  using Split = VectorGroup;

  VectorGroup() = default;  ///< 0
  explicit VectorGroup(const Tangent& v) : v_(v) {}

  static VectorGroup Exp(const Tangent& xi) { return VectorGroup(xi); }
  const Tangent& vector() const { return v_; }
  Tangent Log() const { return v_; }
  VectorGroup operator*(const VectorGroup& other) const { return VectorGroup(v_ + other.v_); }
  VectorGroup inverse() const { return VectorGroup(-v_); }
  Jacobian adjoint() const { return Jacobian::Identity(); }
  static Jacobian left_jacobian(const Tangent&) { return Jacobian::Identity(); }
  static Jacobian left_jacobian_inverse(const Tangent&) { return Jacobian::Identity(); }
  Split split() const { return *this; }
  static VectorGroup join(const Split& split) { return split; }
  Jacobian split_jacobian() const { return Jacobian::Identity(); }

 private:
  Tangent v_ = Tangent::Zero();
};

}  // namespace credence
