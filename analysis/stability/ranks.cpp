#include "analysis/stability/ranks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "analysis/stability/dense_svd.h"
#include "analysis/stability/observability_stack.h"
#include "core/linear_algebra/decompositions.h"

namespace credence::internal {
namespace {

constexpr double kMaxScale = 16384.0;  // what is nothing but rounding noise must not be scaled up to count
constexpr double kMaxUnitDiagonalScale = 1e3;

void require_finite(const char* name, MatrixRef M) {
  if (!M.allFinite()) throw std::invalid_argument(fmt::format("{} has an entry that is not finite", name));
}

void require_square(const char* name, MatrixRef M) {
  if (M.rows() != M.cols()) {
    throw std::invalid_argument(fmt::format("{} is {}x{} and must be square", name, M.rows(), M.cols()));
  }
  require_finite(name, M);
}

/// An upper bound of the 2-norm that is 1 for the identity, 0 only for a zero matrix.
double norm_bound(MatrixRef M) {
  if (M.size() == 0) return 0.0;
  const double columns = M.cwiseAbs().colwise().sum().maxCoeff();
  const double rows = M.cwiseAbs().rowwise().sum().maxCoeff();
  return std::sqrt(columns * rows);
}

double power_of_two(double x) { return std::exp2(std::round(std::log2(x))); }

/// Powers of two near the sizes given, the least no further than kMaxScale below the largest.
Vector bounded_scales(const Vector& sizes) {
  const double largest = sizes.size() > 0 ? sizes.maxCoeff() : 0.0;
  if (!(largest > 0.0)) return Vector::Ones(sizes.size());
  const double least = largest / kMaxScale;
  return sizes.unaryExpr([least](double size) { return power_of_two(std::max(size, least)); });
}

/// B with columns of about norm one: its range is what matters.
Matrix unit_columns(const Matrix& B) {
  if (B.size() == 0) return B;
  const Vector sizes = B.colwise().lpNorm<Eigen::Infinity>();
  return B * bounded_scales(sizes).cwiseInverse().asDiagonal();
}

Matrix scaled_to_norm_one(MatrixRef F) {
  const double norm = norm_bound(F);
  return norm > 0.0 ? Matrix(F / norm) : Matrix(F);
}

/// Typical size of each state within the first blocks of [B | F B | F² B], all columns of norm one.
Vector typical_sizes(const Matrix& F, const Matrix& B) {
  if (B.cols() == 0) return Vector::Zero(B.rows());
  Vector sizes = B.rowwise().lpNorm<Eigen::Infinity>();
  Matrix block = B;
  for (int power = 0; power < 2; ++power) {
    block = unit_columns(F * block);
    sizes = sizes.cwiseMax(block.rowwise().lpNorm<Eigen::Infinity>());
  }
  return sizes;
}

/// An orthogonal matrix whose first columns span those of M.
Matrix full_orthogonal(const Matrix& M) {
  const Eigen::HouseholderQR<Matrix> qr(M);
  return orthonormal_columns(qr.householderQ(), M.rows());
}

/// The staircase: an orthonormal basis of range [B | F B | …] and all singular values met on the way.
struct Staircase {
  Matrix basis;
  std::vector<double> kept, left_out;
  double error = std::numeric_limits<double>::epsilon();  ///< of the newest directions: each stair divides by
                                                          ///< its least singular value
  bool doubtful = false;                                  ///< something was kept that may be error alone
};

void append_new_directions(const Matrix& block, Staircase& stairs, Matrix& fresh) {
  const DenseSvd svd = dense_svd(block, SvdVectors::left);
  const Vector& values = svd.s;
  Index count = 0;
  for (Index i = 0; i < values.size(); ++i) {
    if (values[i] > kRankTolerance) {
      ++count;
      stairs.kept.push_back(values[i]);
    } else {
      stairs.left_out.push_back(values[i]);
    }
  }
  count = std::min(count, block.rows() - stairs.basis.cols());
  if (count > 0) {
    stairs.doubtful = stairs.doubtful || stairs.error > 0.1 * kRankTolerance;
    stairs.error = std::min(1.0, stairs.error / std::min(1.0, values[count - 1]));
  }
  fresh = svd.U.leftCols(count);
  const Index before = stairs.basis.cols();
  stairs.basis.conservativeResize(Eigen::NoChange, before + count);
  stairs.basis.rightCols(count) = fresh;
}

Staircase climb(const Matrix& F, const Matrix& B) {
  const Index n = F.rows();
  Staircase stairs;
  stairs.basis.resize(n, 0);
  if (B.cols() == 0) return stairs;
  Matrix fresh;
  append_new_directions(B, stairs, fresh);
  while (fresh.cols() > 0 && stairs.basis.cols() < n) {
    Matrix block = F * fresh;
    for (int twice = 0; twice < 2; ++twice) {  // once leaves rounding of the size of what was removed
      block -= stairs.basis * (stairs.basis.transpose() * block).eval();
    }
    append_new_directions(block, stairs, fresh);
  }
  return stairs;
}

RankDecision decision_of(const Staircase& stairs) {
  RankDecision decision;
  decision.rank = stairs.basis.cols();
  decision.doubtful = stairs.doubtful;
  std::vector<double> values = stairs.kept;
  values.insert(values.end(), stairs.left_out.begin(), stairs.left_out.end());
  std::ranges::sort(values, std::greater<>());
  decision.singular_values = Eigen::Map<const Vector>(values.data(), static_cast<Index>(values.size()));
  const auto least = std::ranges::min_element(stairs.kept);
  const auto most = std::ranges::max_element(stairs.left_out);
  const bool nothing_left_out = most == stairs.left_out.end() || *most == 0.0;
  if (nothing_left_out) {
    decision.gap = std::numeric_limits<double>::infinity();
  } else {
    decision.gap = least == stairs.kept.end() ? 0.0 : *least / *most;
  }
  return decision;
}

/// Singular values and vectors of what a left eigenvector w of λ that B does not drive makes zero: w (F − λ
/// I) and w B, of a pair of complex λ their real forms.
DenseSvd undriven_at(const Matrix& F, const Matrix& B, std::complex<double> lambda) {
  const Index n = F.rows(), q = B.cols();
  const Matrix I = Matrix::Identity(n, n);
  Matrix conditions(n, n + q);
  if (lambda.imag() == 0.0) {
    conditions << F - lambda.real() * I, B;
  } else {
    conditions.resize(n, n + 2 * q);
    conditions << F * F - 2.0 * lambda.real() * F + std::norm(lambda) * I, B, F * B;
  }
  return dense_svd(conditions.transpose(), SvdVectors::full_right);
}

/// What is left without the left modes of F that B does not drive, one eigenvalue after the other divided
/// out: their number does not hang on how far the climb to the last stair is. Orthonormal columns; O(n⁴).
Matrix without_undriven_modes(const Matrix& F, const Matrix& B, std::vector<double>& left_out) {
  constexpr double kZero = 1e-12;
  const Index n = F.rows();
  Matrix modes(n, 0), rest = Matrix::Identity(n, n);
  while (rest.cols() > 0) {
    const Matrix F_rest = rest.transpose() * F * rest, B_rest = rest.transpose() * B;
    const Eigen::EigenSolver<Matrix> eigen(F_rest, false);
    if (eigen.info() != Eigen::Success) break;
    DenseSvd best;
    double least = kZero;
    for (const std::complex<double> lambda : eigen.eigenvalues()) {
      if (lambda.imag() < 0.0) continue;
      DenseSvd svd = undriven_at(F_rest, B_rest, lambda);
      if (svd.s[svd.s.size() - 1] > least) continue;
      least = svd.s[svd.s.size() - 1];
      best = std::move(svd);
    }
    if (best.s.size() == 0) break;
    const Index count = (best.s.array() <= kZero).count();
    left_out.insert(left_out.end(), best.s.end() - count, best.s.end());
    const Matrix all = (Matrix(n, modes.cols() + count) << modes, rest * best.V.rightCols(count)).finished();
    const Matrix Q = full_orthogonal(all);
    modes = Q.leftCols(all.cols());
    rest = Q.rightCols(n - all.cols());
  }
  return rest;
}

/// Climbs; where errors may have grown to the size of a stair, without the modes that are found to be
/// undriven one by one; of more states than can be examined so the doubt stays.
Staircase climb_with_care(const Matrix& F, const Matrix& B) {
  Staircase stairs = climb(F, B);
  if (!stairs.doubtful || F.rows() > kMostExaminedStates) return stairs;
  std::vector<double> left_out;
  const Matrix rest = without_undriven_modes(F, B, left_out);
  if (rest.cols() < F.rows()) {
    stairs = climb(rest.transpose() * F * rest, rest.transpose() * B);
    stairs.basis = (rest * stairs.basis).eval();
    stairs.left_out.insert(stairs.left_out.end(), left_out.begin(), left_out.end());
  }
  stairs.doubtful = false;
  return stairs;
}

/// Scale, climb, and take the directions back to the caller's coordinates.
Controllability staircase_controllability(MatrixRef F, MatrixRef B) {
  const Index n = F.rows();
  const Vector d = bounded_scales(typical_sizes(scaled_to_norm_one(F), unit_columns(B)));
  const Matrix F_scaled = scaled_to_norm_one(d.cwiseInverse().asDiagonal() * F * d.asDiagonal());
  const Matrix B_scaled = unit_columns(d.cwiseInverse().asDiagonal() * B);
  const Staircase stairs = climb_with_care(F_scaled, B_scaled);

  Controllability result;
  result.decision = decision_of(stairs);
  const Index rank = result.decision.rank;
  const Matrix Q = full_orthogonal(d.asDiagonal() * stairs.basis);
  result.controllable = Q.leftCols(rank);
  result.uncontrollable = Q.rightCols(n - rank);
  return result;
}

/// Eigenvectors and eigenvalues of M after the scaling to unit diagonal, and the scales.
struct ScaledEigen {
  Vector d, values;
  Matrix vectors;
};

ScaledEigen scaled_eigen(MatrixRef M) {
  ScaledEigen result;
  const Vector diagonal = M.diagonal().cwiseAbs();
  const double largest = std::sqrt(diagonal.maxCoeff());
  result.d = largest > 0.0
                 ? Vector(diagonal.cwiseSqrt().cwiseMax(largest / kMaxUnitDiagonalScale).cwiseInverse())
                 : Vector::Ones(M.rows());
  const Matrix scaled = result.d.asDiagonal() * (0.5 * (M + M.transpose())) * result.d.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(scaled);
  if (eigen.info() != Eigen::Success)
    throw std::runtime_error("eigenvalues of a psd matrix did not converge");
  result.values = eigen.eigenvalues().cwiseAbs();
  result.vectors = eigen.eigenvectors();
  return result;
}

/// The eigenvectors of the eigenvalues of largest modulus.
Matrix largest_columns(const ScaledEigen& eigen, Index count) {
  std::vector<Index> order(static_cast<std::size_t>(eigen.values.size()));
  std::iota(order.begin(), order.end(), Index{0});
  std::ranges::sort(order, [&](Index a, Index b) { return eigen.values[a] > eigen.values[b]; });
  Matrix columns(eigen.vectors.rows(), count);
  for (Index i = 0; i < count; ++i) columns.col(i) = eigen.vectors.col(order[static_cast<std::size_t>(i)]);
  return columns;
}

void require_trajectory(std::span<const Matrix> F, std::span<const Matrix> H) {
  if (H.empty()) throw std::invalid_argument("a trajectory needs at least one measurement matrix");
  if (H.size() != F.size() && H.size() != F.size() + 1) {
    throw std::invalid_argument(
        fmt::format("{} measurement matrices do not go with {} transitions", H.size(), F.size()));
  }
  const Index n = H.front().cols();
  for (const Matrix& F_k : F) {
    require_square("F_k", F_k);
    if (F_k.rows() != n) throw std::invalid_argument(fmt::format("F_k has {} rows, not {}", F_k.rows(), n));
  }
  for (const Matrix& H_k : H) {
    require_finite("H_k", H_k);
    if (H_k.cols() != n)
      throw std::invalid_argument(fmt::format("H_k has {} columns, not {}", H_k.cols(), n));
  }
}

/// All H_k Φ_k, rows of H_k of norm one and Φ_k scaled down where it grows.
Matrix stacked_observations(std::span<const Matrix> F, std::span<const Matrix> H) {
  const Index n = H.front().cols();
  ObservabilityStack stack(n);
  Matrix Phi = Matrix::Identity(n, n);
  for (std::size_t k = 0; k < H.size(); ++k) {
    if (H[k].rows() > 0) {
      const Matrix seen = unit_columns(H[k].transpose()).transpose() * Phi;
      for (Index i = 0; i < seen.rows(); ++i) stack.add(seen.row(i).transpose());
    }
    if (k < F.size()) {
      Phi = (F[k] * Phi).eval();
      const double norm = norm_bound(Phi);
      if (norm > static_cast<double>(n)) Phi /= norm;
    }
  }
  return stack.rows();
}

}  // namespace
}  // namespace credence::internal

namespace credence {

using namespace internal;

RankDecision decide_rank(const Vector& values, double tolerance) {
  require_finite("a vector of singular values", values);
  RankDecision decision;
  decision.singular_values = values;
  std::sort(decision.singular_values.data(), decision.singular_values.data() + values.size(),
            std::greater<>());
  const Vector& sorted = decision.singular_values;
  if (sorted.size() > 0 && sorted[0] > 0.0) {
    while (decision.rank < sorted.size() && sorted[decision.rank] > tolerance * sorted[0]) ++decision.rank;
  }
  const bool nothing_left_out = decision.rank == sorted.size() || sorted[decision.rank] == 0.0;
  if (nothing_left_out) {
    decision.gap = std::numeric_limits<double>::infinity();
  } else {
    decision.gap = decision.rank == 0 ? 0.0 : sorted[decision.rank - 1] / sorted[decision.rank];
  }
  return decision;
}

RankDecision psd_rank(MatrixRef M, double tolerance) {
  require_square("the matrix", M);
  if (M.rows() == 0) return decide_rank(Vector(), tolerance);
  return decide_rank(scaled_eigen(M).values, tolerance);
}

Matrix psd_range(MatrixRef M, double tolerance) {
  require_square("the matrix", M);
  if (M.rows() == 0) return Matrix(0, 0);
  const ScaledEigen eigen = scaled_eigen(M);
  const Index rank = decide_rank(eigen.values, tolerance).rank;
  if (rank == 0) return Matrix(M.rows(), 0);
  const Matrix spanning = eigen.d.cwiseInverse().asDiagonal() * largest_columns(eigen, rank);
  return full_orthogonal(spanning).leftCols(rank);
}

Matrix psd_null_space(MatrixRef M, double tolerance) {
  const Matrix range = psd_range(M, tolerance);
  if (range.cols() == 0) return Matrix::Identity(M.rows(), M.rows());
  return full_orthogonal(range).rightCols(M.rows() - range.cols());
}

Controllability controllability(MatrixRef F, MatrixRef B) {
  require_square("F", F);
  require_finite("B", B);
  if (B.rows() != F.rows()) {
    throw std::invalid_argument(fmt::format("B has {} rows and F has {}", B.rows(), F.rows()));
  }
  return staircase_controllability(F, B);
}

Controllability controllability(MatrixRef F, MatrixRef G, MatrixRef Q) {
  require_square("Q", Q);
  if (G.cols() != Q.rows()) {
    throw std::invalid_argument(fmt::format("G has {} columns and Q has {} rows", G.cols(), Q.rows()));
  }
  if (Q.rows() == 0) return controllability(F, G);
  const ScaledEigen eigen = scaled_eigen(Q);
  const Vector root =
      (eigen.values.array() > kRankTolerance * eigen.values.maxCoeff()).select(eigen.values.cwiseSqrt(), 0.0);
  const Matrix Q_root = eigen.d.cwiseInverse().asDiagonal() * eigen.vectors * root.asDiagonal();
  return controllability(F, G * Q_root);
}

ObservabilityAnalysis observability(MatrixRef F, MatrixRef H) {
  require_square("F", F);
  require_finite("H", H);
  if (H.cols() != F.rows()) {
    throw std::invalid_argument(fmt::format("H has {} columns and F has {} rows", H.cols(), F.rows()));
  }
  Controllability dual = staircase_controllability(F.transpose(), H.transpose());
  return {std::move(dual.decision), std::move(dual.uncontrollable)};
}

ObservabilityAnalysis local_observability(std::span<const Matrix> F, std::span<const Matrix> H) {
  require_trajectory(F, H);
  const Index n = H.front().cols();
  Matrix stack = stacked_observations(F, H);
  const Vector d = bounded_scales(stack.colwise().norm().transpose());
  stack = stack * d.cwiseInverse().asDiagonal();

  ObservabilityAnalysis result;
  Matrix null = Matrix::Identity(n, n);
  if (stack.rows() > 0) {
    const DenseSvd svd = dense_svd(stack, SvdVectors::full_right);
    result.decision = decide_rank(svd.s);
    null = svd.V.rightCols(n - result.decision.rank);
  } else {
    result.decision = decide_rank(Vector());
  }
  result.unobservable = Matrix(n, 0);
  if (null.cols() > 0) {
    result.unobservable = full_orthogonal(d.cwiseInverse().asDiagonal() * null).leftCols(null.cols());
  }
  return result;
}

}  // namespace credence
