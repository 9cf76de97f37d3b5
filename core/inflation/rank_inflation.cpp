#include "core/inflation/rank_inflation.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>

#include "core/linear_algebra/decompositions.h"
#include "core/linear_algebra/logarithm.h"
#include "core/linear_algebra/polar.h"
#include "core/manifold/trigonometry.h"

namespace credence::internal {
namespace {

/// Independent standard normals, the same on every machine with IEEE arithmetic.
Matrix normals(Index rows, Index cols, std::uint64_t seed) {
  std::mt19937_64 bits(seed);
  const auto uniform = [&] { return std::ldexp(static_cast<double>((bits() >> 11) + 1), -53); };
  Matrix Z(rows, cols);
  for (double& z : Z.reshaped()) {
    const double radius = std::sqrt(-2.0 * natural_logarithm(uniform()));
    z = radius * cosine(2.0 * std::numbers::pi * uniform());
  }
  return Z;
}

/// An orthonormal basis of range(G), rank(G) columns.
Matrix range_of(const MatrixRef& G) {
  if (G.size() == 0) return Matrix(G.rows(), 0);
  const Eigen::ColPivHouseholderQR<Matrix> qr(G);
  return orthonormal_columns(qr.householderQ(), qr.rank());
}

/// Takes the common translation out of each column: landmarks keep only their differences.
void remove_common_translation(Eigen::Ref<Matrix> landmarks, const BlockLayout& layout) {
  for (Index c = 0; c < landmarks.cols(); ++c) {
    auto column = landmarks.col(c).reshaped(layout.landmark, layout.landmarks);
    const Vector mean = column.rowwise().mean();
    column.colwise() -= mean;
  }
}

/// Columns in general position within the range, to be orthonormalised.
Matrix directions(const BlockLayout& layout, const MatrixRef& G, const RankInflation& spec) {
  const Index n = layout.state_dim();
  const Index n_f = n - layout.vehicle;
  Matrix U = Matrix::Zero(n, spec.rank);
  switch (spec.range) {
    case InflationRange::generic: return normals(n, spec.rank, spec.seed);
    case InflationRange::map: U.bottomRows(n_f) = normals(n_f, spec.rank, spec.seed); return U;
    case InflationRange::difference:
      U.bottomRows(n_f) = normals(n_f, spec.rank, spec.seed);
      remove_common_translation(U.bottomRows(n_f), layout);
      return U;
    case InflationRange::with_vehicle: {
      if (G.rows() != n) throw std::invalid_argument(fmt::format("G has {} rows, not {}", G.rows(), n));
      const Matrix vehicle = range_of(G);
      if (spec.rank < vehicle.cols()) {
        throw std::invalid_argument(fmt::format("inflation_rank = {} cannot contain the {} directions of G",
                                                spec.rank, vehicle.cols()));
      }
      U.leftCols(vehicle.cols()) = vehicle;
      U.rightCols(spec.rank - vehicle.cols()) = normals(n, spec.rank - vehicle.cols(), spec.seed);
      return U;
    }
  }
  throw std::invalid_argument("unknown inflation_range");
}

}  // namespace
}  // namespace credence::internal

namespace credence {

using namespace internal;

Index max_inflation_rank(const BlockLayout& layout, InflationRange range) {
  const Index n_f = layout.landmark * layout.landmarks;
  switch (range) {
    case InflationRange::generic:
    case InflationRange::with_vehicle: return layout.state_dim();
    case InflationRange::map: return n_f;
    case InflationRange::difference: return layout.landmarks > 0 ? n_f - layout.landmark : 0;
  }
  throw std::invalid_argument("unknown inflation_range");
}

Matrix rank_inflation(const BlockLayout& layout, const MatrixRef& G, const RankInflation& spec) {
  const Index most = max_inflation_rank(layout, spec.range);
  if (spec.rank < 0 || spec.rank > most) {
    throw std::invalid_argument(
        fmt::format("inflation_rank = {} must lie in 0 … {} for this range", spec.rank, most));
  }
  if (!(std::isfinite(spec.scale) && spec.scale >= 0.0)) {
    throw std::invalid_argument(fmt::format("inflation_scale = {} must be a finite number >= 0", spec.scale));
  }
  const Index n = layout.state_dim();
  if (spec.rank == 0) return Matrix::Zero(n, n);
  Matrix U, T;
  thin_qr(directions(layout, G, spec), U, T);
  Matrix delta = spec.scale * U * U.transpose();
  mirror_lower(delta);
  return delta;
}

}  // namespace credence
