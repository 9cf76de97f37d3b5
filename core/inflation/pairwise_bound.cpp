#include "core/inflation/pairwise_bound.h"

#include <fmt/format.h>

#include <stdexcept>

#include "core/linear_algebra/decompositions.h"
#include "core/linear_algebra/polar.h"

namespace credence::internal {
namespace {

constexpr int kDynamic = Eigen::Dynamic;

template <int R, int C>
using BlockOf = Eigen::Matrix<double, R, C>;

/// (C Cᵀ)^{1/2} and (Cᵀ C)^{1/2}, exactly symmetric, by the cheapest stable way for the shape.
template <int Rows, int Cols>
struct Moduli {
  BlockOf<Rows, Rows> left;
  BlockOf<Cols, Cols> right;
};

Moduli<1, 1> moduli(const BlockOf<1, 1>& C) { return {C.cwiseAbs(), C.cwiseAbs()}; }

/// A column c: c cᵀ/‖c‖ and ‖c‖.
template <int Rows>
requires(Rows > 1) Moduli<Rows, 1> moduli(const BlockOf<Rows, 1>& c) {
  const double norm = c.norm();
  Moduli<Rows, 1> out;
  out.right(0, 0) = norm;
  out.left.setZero();
  if (norm == 0.0) return out;
  const BlockOf<Rows, 1> unit = c / norm;
  out.left.noalias() = c * unit.transpose();
  mirror_lower(out.left);
  return out;
}

/// 2×2: with the orthogonal polar factor U of C the moduli are C Uᵀ and Uᵀ C.
Moduli<2, 2> moduli(const BlockOf<2, 2>& C) {
  const Eigen::Matrix2d U = orthogonal_factor(C);
  Moduli<2, 2> out;
  out.left.noalias() = C * U.transpose();
  out.right.noalias() = U.transpose() * C;
  mirror_lower(out.left);
  mirror_lower(out.right);
  return out;
}

/// m×2, m > 2: C = Q T with two orthonormal columns, then the 2×2 case for T.
template <int Rows>
requires(Rows > 2) Moduli<Rows, 2> moduli(const BlockOf<Rows, 2>& C) {
  BlockOf<Rows, 2> Q;
  BlockOf<2, 2> T;
  thin_qr(C, Q, T);
  const Moduli<2, 2> inner = moduli(T);
  Moduli<Rows, 2> out;
  const BlockOf<Rows, 2> half = Q * inner.left;
  out.left.noalias() = half * Q.transpose();
  mirror_lower(out.left);
  out.right = inner.right;
  return out;
}

template <int Rows, int Cols>
Moduli<Rows, Cols> moduli_by_svd(const BlockOf<Rows, Cols>& C) {
  constexpr bool kFixed = Rows != kDynamic && Cols != kDynamic;
  // Fixed sizes take full bases (thin ones are for dynamic columns); the superfluous columns are not used.
  constexpr unsigned kOptions =
      kFixed ? Eigen::ComputeFullU | Eigen::ComputeFullV : Eigen::ComputeThinU | Eigen::ComputeThinV;
  const Eigen::JacobiSVD<BlockOf<Rows, Cols>> svd(C, kOptions);
  const Index rank = svd.singularValues().size();
  const auto U = svd.matrixU().leftCols(rank);
  const auto V = svd.matrixV().leftCols(rank);
  Moduli<Rows, Cols> out;
  out.left = U * svd.singularValues().asDiagonal() * U.transpose();
  out.right = V * svd.singularValues().asDiagonal() * V.transpose();
  mirror_lower(out.left);
  mirror_lower(out.right);
  return out;
}

Moduli<3, 3> moduli(const BlockOf<3, 3>& C) { return moduli_by_svd<3, 3>(C); }
Moduli<kDynamic, kDynamic> moduli(const BlockOf<kDynamic, kDynamic>& C) {
  return moduli_by_svd<kDynamic, kDynamic>(C);
}

/// Decorrelates the block at row i from the block at column k: rows × cols, i > k.
template <int Rows, int Cols>
void decorrelate_pair(Eigen::Ref<Matrix>& A, Index i, Index k, Index rows, Index cols) {
  auto C = A.block<Rows, Cols>(i, k, rows, cols);
  const Moduli<Rows, Cols> bound = moduli(BlockOf<Rows, Cols>(C));
  A.block<Rows, Rows>(i, i, rows, rows) += bound.left;
  A.block<Cols, Cols>(k, k, cols, cols) += bound.right;
  C.setZero();
  A.block<Cols, Rows>(k, i, cols, rows).setZero();
}

/// The vehicle's correlation lies below it (d × n_r); its transpose is tall, which is what the kernels want.
template <int Vehicle, int Landmark>
void decorrelate_vehicle(Eigen::Ref<Matrix>& A, const BlockLayout& layout) {
  const Index n = layout.vehicle, d = layout.landmark;
  for (Index k = 0; k < layout.landmarks; ++k) {
    const Index at = layout.landmark_offset(k);
    auto C = A.block<Vehicle, Landmark>(0, at, n, d);
    const Moduli<Vehicle, Landmark> bound = moduli(BlockOf<Vehicle, Landmark>(C));
    A.block<Vehicle, Vehicle>(0, 0, n, n) += bound.left;
    A.block<Landmark, Landmark>(at, at, d, d) += bound.right;
    C.setZero();
    A.block<Landmark, Vehicle>(at, 0, d, n).setZero();
  }
}

template <int Landmark>
void decorrelate_landmarks(Eigen::Ref<Matrix>& A, const BlockLayout& layout) {
  const Index d = layout.landmark;
  for (Index k = 0; k < layout.landmarks; ++k) {
    for (Index i = k + 1; i < layout.landmarks; ++i) {
      decorrelate_pair<Landmark, Landmark>(A, layout.landmark_offset(i), layout.landmark_offset(k), d, d);
    }
  }
}

}  // namespace

void require_layout(const MatrixRef& A, const BlockLayout& layout) {
  if (layout.vehicle < 0 || layout.landmarks < 0 || layout.landmark < 0 || A.rows() != layout.state_dim() ||
      A.cols() != layout.state_dim()) {
    throw std::invalid_argument(fmt::format("A is {}x{}, its layout (vehicle {}, {} landmarks of {}) is not",
                                            A.rows(), A.cols(), layout.vehicle, layout.landmarks,
                                            layout.landmark));
  }
}

void decorrelate_pairwise(Eigen::Ref<Matrix> A, const BlockLayout& layout) {
  require_layout(A, layout);
  const Index n = layout.vehicle, d = layout.landmark;
  if (n == 1 && d == 1) {
    decorrelate_vehicle<1, 1>(A, layout);
  } else if (n == 2 && d == 2) {
    decorrelate_vehicle<2, 2>(A, layout);
  } else if (n == 3 && d == 2) {
    decorrelate_vehicle<3, 2>(A, layout);
  } else if (n > 0 && d > 0) {
    decorrelate_vehicle<kDynamic, kDynamic>(A, layout);
  }
  if (d == 1) {
    decorrelate_landmarks<1>(A, layout);
  } else if (d == 2) {
    decorrelate_landmarks<2>(A, layout);
  } else if (d == 3) {
    decorrelate_landmarks<3>(A, layout);
  } else if (d > 0) {
    decorrelate_landmarks<kDynamic>(A, layout);
  }
}

}  // namespace credence::internal
