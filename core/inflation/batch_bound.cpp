#include "core/inflation/batch_bound.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/linear_algebra/mirror.h"
#include "core/linear_algebra/polar.h"

namespace credence::internal {
namespace {

/// The ascent ends when a sweep has lowered ‖M‖² by less than this share of tr L Lᵀ, or after so many.
constexpr double kStandstill = 1e-3;
constexpr int kMostSweeps = 20;
/// E is scaled by one and, where that is no bound, this, twice this …: so many times in all, by 4.3 at most.
constexpr double kLeastExcess = 1e-4;
constexpr int kScalings = 17;
/// A gain below this share of tr L Lᵀ of the landmarks measured is not taken: nearly every batch has one of
/// this size, and each costs a pass over the blocks of the whole map (docs/theory.md has both ways).
constexpr double kLeastGain = 1e-2;
/// Of G in (tr H)²: below it a direction is lost in rounding.
constexpr double kSingular = 1e-12;
/// Of the trace: added to A and B, so that Θ A Θ = B does not hang on the rounding of small eigenvalues.
constexpr double kRidge = 1e-9;
/// Θ is never less than this, so that its inverse does not magnify rounding.
constexpr double kLeastShare = 1e-6;
/// Of tr L Lᵀ: more than K and the Cholesky factorisation of a matrix on the boundary round off.
constexpr double kBoundaryRounding = 1e-13;

template <int n>
using Square = Eigen::Matrix<double, n, n>;

/// Eigenvalues and orthonormal eigenvectors of a 3×3 or smaller symmetric matrix, by Jacobi's rotations: with
/// Eigen's solver a step of six landmarks spent 40 % of its time there.
template <int n>
struct Eigensystem {
  Eigen::Matrix<double, n, 1> values;
  Square<n> vectors = Square<n>::Identity();

  explicit Eigensystem(Square<n> A) {
    for (int cycle = 0; cycle < kMostCycles && !is_diagonal(A); ++cycle) {
      for (int p = 0; p < n; ++p) {
        for (int q = p + 1; q < n; ++q) rotate(A, p, q);
      }
    }
    values = A.diagonal();
  }

 private:
  static constexpr int kMostCycles = 8;  ///< a few are enough, as they converge quadratically

  static bool is_diagonal(const Square<n>& A) {
    double beside = 0.0;
    for (int p = 0; p < n; ++p) {
      for (int q = p + 1; q < n; ++q) beside += A(p, q) * A(p, q);
    }
    return beside <= 1e-32 * A.diagonal().squaredNorm();
  }

  void rotate(Square<n>& A, int p, int q) {
    if (A(p, q) == 0.0) return;
    const double difference = 0.5 * (A(q, q) - A(p, p));
    const double length = std::sqrt(difference * difference + A(p, q) * A(p, q));
    const double t = A(p, q) / (difference + (difference < 0.0 ? -length : length));
    const double c = 1.0 / std::sqrt(1.0 + t * t), s = t * c, moved = t * A(p, q);
    A(p, p) -= moved;
    A(q, q) += moved;
    A(p, q) = A(q, p) = 0.0;
    for (int i = 0; i < n; ++i) {
      if (i != p && i != q) {
        const double x = A(i, p), y = A(i, q);
        A(i, p) = A(p, i) = c * x - s * y;
        A(i, q) = A(q, i) = s * x + c * y;
      }
      const double u = vectors(i, p), v = vectors(i, q);
      vectors(i, p) = c * u - s * v;
      vectors(i, q) = s * u + c * v;
    }
  }
};

template <int n>
Square<n> root(const Square<n>& A) {
  const Eigensystem<n> eigen(A);
  return eigen.vectors * eigen.values.cwiseMax(0.0).cwiseSqrt().asDiagonal() * eigen.vectors.transpose();
}

/// Θ and what follows from it.
template <int r>
struct Share {
  Square<r> theta = Square<r>::Zero();
  Square<r> weight = Square<r>::Zero();       ///< Θ⁻¹ − I
  Square<r> weight_root = Square<r>::Zero();  ///< (Θ⁻¹ − I)^{1/2}
};

template <int r>
Share<r> share_of(const Square<r>& theta) {
  const Eigensystem<r> eigen(theta);
  const Square<r>& U = eigen.vectors;
  const Eigen::Matrix<double, r, 1> kept = eigen.values.cwiseMax(kLeastShare).cwiseMin(1.0);
  const Eigen::Matrix<double, r, 1> weight = kept.cwiseInverse().array() - 1.0;
  Share<r> share;
  share.theta = U * kept.asDiagonal() * U.transpose();
  share.weight = U * weight.asDiagonal() * U.transpose();
  share.weight_root = U * weight.cwiseSqrt().asDiagonal();
  return share;
}

/// The Θ of greatest gain tr A(I − Θ) − tr B(Θ⁻¹ − I): Θ A Θ = B, cut off at I.
template <int r>
Share<r> best_share(Square<r> A, Square<r> B) {
  A.diagonal().array() += kRidge * A.trace();
  B.diagonal().array() += kRidge * B.trace();
  const Eigen::LLT<Square<r>> llt(A);
  if (llt.info() != Eigen::Success) return share_of<r>(Square<r>::Identity());
  const Square<r> U = llt.matrixU();
  Square<r> theta = root<r>(U * B * U.transpose());
  llt.matrixU().solveInPlace(theta);
  theta.transposeInPlace();
  llt.matrixU().solveInPlace(theta);
  return share_of<r>(0.5 * (theta + theta.transpose()));
}

/// (Gᵀ G)^{1/2} of a tall G.
template <int d>
Square<d> right_root(const Eigen::Matrix<double, 2 * d, d>& G) {
  Square<d> square = G.transpose() * G;
  if constexpr (d == 1) {
    return square.cwiseSqrt();
  } else {
    const double s = std::sqrt(std::max(0.0, square.determinant())), t = std::sqrt(square.trace() + 2.0 * s);
    if (!(t > 0.0)) return Square<d>::Zero();
    square.diagonal().array() += s;
    return square / t;
  }
}

/// The landmarks that are measured: V_j (2d×d, orthonormal columns) and the Gram matrix K = L (I − Θ) Lᵀ.
template <int r, int d>
class Measured {
 public:
  static constexpr int kHeight = 2 * d;
  using Isometry = Eigen::Matrix<double, kHeight, d>;

  Measured(const BatchRows& L, const BatchBasis<r>& Q) : count_(L.rows() / d) {
    whole_.noalias() = L * L.transpose();
    common_.noalias() = L * Q;
    for (Index j = 1; j < count_; ++j) {
      if (block(whole_, j, j).trace() > block(whole_, first_, first_).trace()) first_ = j;
    }
    // The largest one way, all others the other way, each in a plane of its own as far as there are any.
    for (Index j = 0, turned = 1; j < count_; ++j) {
      const Index at = j == first_ ? 0 : turned++;
      V(j).setZero();
      for (Index a = 0; a < d; ++a) V(j)((at + a) % kHeight, a) = j == first_ ? 1.0 : -1.0;
    }
  }

  void set_share(const Square<r>& theta) {
    gram_ = whole_;
    gram_.noalias() -= (common_ * theta).lazyProduct(common_.transpose());
  }

  /// One of block ascent, the largest first; returns by how much ‖M‖² fell.
  double sweep() {
    double fall = turn(first_);
    for (Index j = 0; j < count_; ++j) {
      if (j != first_) fall += turn(j);
    }
    return fall;
  }

  /// Qᵀ Mᵀ M Q with M = Σ V_j L_j.
  Square<r> common_square() const {
    Eigen::Matrix<double, kHeight, r> M = Eigen::Matrix<double, kHeight, r>::Zero();
    for (Index j = 0; j < count_; ++j) M += V(j) * common_.template middleRows<d>(d * j);
    return M.transpose() * M;
  }

  /// (G_jᵀ G_j)^{1/2}.
  Square<d> inflation(Index j) const { return right_root<d>(others_of(j)); }

  /// ‖M (I − Θ)^{1/2}‖²: with this Θ no bound lowers the landmarks measured by more.
  double most() const {
    double square = gram_.trace();
    for (Index j = 0; j < count_; ++j) square += V(j).cwiseProduct(others_of(j)).sum();
    return square;
  }

  Index count() const { return count_; }
  const BatchRows& gram() const { return gram_; }
  double reduction() const { return whole_.trace(); }
  static auto block(const BatchRows& A, Index i, Index j) { return A.template block<d, d>(d * i, d * j); }

 private:
  Isometry& V(Index j) { return V_[static_cast<std::size_t>(j)]; }
  const Isometry& V(Index j) const { return V_[static_cast<std::size_t>(j)]; }

  /// G_j = Σ_{i≠j} V_i L_i (I − Θ) L_jᵀ.
  Isometry others_of(Index j) const {
    Isometry sum = Isometry::Zero();
    for (Index i = 0; i < count_; ++i) {
      if (i != j) sum += V(i) * block(gram_, i, j);
    }
    return sum;
  }

  /// V_j against G_j; where G_jᵀ G_j is singular it stays as it is. Returns by how much ‖M‖² fell.
  double turn(Index j) {
    const Isometry G = others_of(j);
    const Square<d> square = G.transpose() * G;
    Isometry turned;
    if constexpr (d == 1) {
      const double norm = std::sqrt(square(0, 0));
      if (!(norm > 0.0)) return 0.0;
      turned = -G / norm;
    } else {
      // H = (GᵀG)^{1/2} = (GᵀG + s I)/t with s² = det GᵀG, t = tr H.
      const double s = std::sqrt(std::max(0.0, square.determinant())),
                   t = std::sqrt(square.trace() + 2.0 * s);
      if (!(s > kSingular * t * t)) return 0.0;
      Square<d> adjugate;
      adjugate << square(1, 1) + s, -square(0, 1), -square(1, 0), square(0, 0) + s;
      turned.noalias() = G * (adjugate / (-s * t));
    }
    const double fall = 2.0 * (V(j) - turned).cwiseProduct(G).sum();
    V(j) = turned;
    return fall;
  }

  Index count_, first_ = 0;
  BatchRows whole_, gram_;
  BatchBasis<r> common_;
  std::array<Isometry, kMostBatchScalars / d> V_;
};

}  // namespace

Index batch_group(Index scalars) {
  const Index groups = (scalars + kMostBatchScalars - 1) / kMostBatchScalars;
  if (groups <= 1) return scalars;
  const Index each = (scalars + groups - 1) / groups;
  return std::min(kMostBatchScalars, each + each % 2);
}

template <int r>
BatchBasis<r> batch_basis(const Eigen::Ref<const Matrix>& G) {
  BatchBasis<r> Q = BatchBasis<r>::Zero(G.cols(), r);
  if (G.cols() < r) {
    Q.leftCols(G.cols()).setIdentity();
  } else {
    Square<r> T;
    const BatchBasis<r> rows = G.transpose();
    thin_qr(rows, Q, T);
  }
  return Q;
}

template <int r, int d>
BatchBound<r, d> batch_bound(const BatchRows& L, const BatchBasis<r>& Q, const BatchOthers<r>& others,
                             double map_trace) {
  BatchBound<r, d> bound;
  if (L.rows() == 0) return bound;
  Measured<r, d> measured(L, Q);
  const Square<r> B = others.norms * others.squares;
  Share<r> share;
  share.theta = 0.5 * Square<r>::Identity();
  measured.set_share(share.theta);
  double cost = 0.0, least = 0.0;  // what the others grow by; the least gain that is one
  for (int i = 0; i < kMostSweeps; ++i) {
    const double fall = measured.count() > 1 ? measured.sweep() : 0.0;
    share = best_share<r>(measured.common_square(), B);
    measured.set_share(share.theta);
    cost = B.cwiseProduct(share.weight).sum();
    const double rounding =
        16.0 * std::numeric_limits<double>::epsilon() * (map_trace + B.trace() * share.weight.trace());
    least = std::max(rounding, kLeastGain * measured.reduction());
    // Θ is the best for these V, and V bounds the gain of any E.
    if (!(measured.most() - cost > least)) return bound;
    if (!(fall > kStandstill * measured.reduction())) break;
  }

  const BatchRows& K = measured.gram();
  const Index rows = L.rows();
  BatchRows Y = K;
  double inflated = 0.0;
  for (Index j = 0; j < measured.count(); ++j) {
    const Square<d> E = measured.inflation(j);
    Y.template block<d, d>(d * j, d * j) = E;
    inflated += E.trace();
  }
  const double shift = kBoundaryRounding * measured.reduction();
  const double most = K.trace() - cost - 2.0 * shift * static_cast<double>(rows);
  // E is a bound where the ascent stands still; before, some multiple of it is.
  for (int scaling = 0; scaling < kScalings; ++scaling) {
    const double excess = scaling == 0 ? 0.0 : std::ldexp(kLeastExcess, scaling - 1);
    bound.gain = most - (1.0 + excess) * inflated;
    if (!(bound.gain > least)) return bound;
    BatchRows tried = Y;
    for (Index j = 0; j < measured.count(); ++j) tried.template block<d, d>(d * j, d * j) *= 1.0 + excess;
    tried.diagonal().array() += shift;
    if (Eigen::LLT<Eigen::Ref<BatchRows>>(tried).info() != Eigen::Success) continue;
    bound.changes.resize(d, rows);
    for (Index j = 0; j < measured.count(); ++j) {
      Square<d> change = (1.0 + excess) * Y.template block<d, d>(d * j, d * j) - measured.block(K, j, j);
      change.diagonal().array() += 2.0 * shift;
      mirror_lower(change);
      bound.changes.template middleCols<d>(d * j) = change;
    }
    bound.spread = std::sqrt(others.norms) * share.weight_root;
    bound.lowers = true;
    return bound;
  }
  return bound;
}

template BatchBasis<3> batch_basis<3>(const Eigen::Ref<const Matrix>& G);
template BatchBasis<1> batch_basis<1>(const Eigen::Ref<const Matrix>& G);
template BatchBound<3, 2> batch_bound<3, 2>(const BatchRows& L, const BatchBasis<3>& Q,
                                            const BatchOthers<3>& others, double map_trace);
template BatchBound<1, 1> batch_bound<1, 1>(const BatchRows& L, const BatchBasis<1>& Q,
                                            const BatchOthers<1>& others, double map_trace);

}  // namespace credence::internal
