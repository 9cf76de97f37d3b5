#include "core/simd/panel_kernel.h"

#include "core/simd/kernel_set.h"

namespace credence {
namespace {

#include "core/simd/lane_pack.inc"
//
#include "core/simd/panel_pack.inc"

constexpr std::int64_t kBlock = kPanelRows * kPanelRows;

/// Columns that are kept in registers side by side.
constexpr int kTile = Pack::kTile;

/// sum[j] −= Σ_k a(:, k) b(j, k) over the first `columns` columns of two panels.
__attribute__((always_inline)) inline void take_products(Pack::D (&sum)[kTile], const double* a,
                                                         const double* b, std::int64_t columns) {
  for (std::int64_t k = 0; k < columns; ++k, a += kPanelRows, b += kPanelRows) {
    const Pack::D x = Pack::load(a);
#pragma GCC unroll 8
    for (int j = 0; j < kTile; ++j) sum[j] = Pack::fnma(x, Pack::broadcast(b[j]), sum[j]);
  }
}

/// The first kColumns columns of a block times L⁻ᵀ, with the block of L on the diagonal and the inverses of
/// its diagonal.
template <int kColumns>
inline void solve_columns(double* block, const double* L, const double* inverse) {
  Pack::D x[kColumns];
#pragma GCC unroll 8
  for (int j = 0; j < kColumns; ++j) x[j] = Pack::load(block + kPanelRows * j);
#pragma GCC unroll 8
  for (int j = 0; j < kColumns; ++j) {
    x[j] = Pack::mul(x[j], Pack::broadcast(inverse[j]));
    Pack::store(block + kPanelRows * j, x[j]);
#pragma GCC unroll 8
    for (int c = j + 1; c < kColumns; ++c) {
      x[c] = Pack::fnma(x[j], Pack::broadcast(L[kPanelRows * j + c]), x[c]);
    }
  }
}

/// The same for `columns` and perhaps some that fill up the block, which stay zero.
inline void solve_block(double* block, const double* L, const double* inverse, std::int64_t columns) {
  if (columns <= 2) return solve_columns<2>(block, L, inverse);
  if (columns <= 4) return solve_columns<4>(block, L, inverse);
  solve_columns<kPanelRows>(block, L, inverse);
}

/// A block on the diagonal becomes its factor; false if that does not exist.
inline bool factor_block(double* block, double* inverse) {
  bool ok = true;
  for (int j = 0; j < kPanelRows; ++j) {
    double* column = block + kPanelRows * j;
    const double pivot = column[j], root = __builtin_sqrt(pivot);
    ok = ok && pivot > 0.0 && pivot <= __DBL_MAX__;
    inverse[j] = 1.0 / root;
    const Pack::D x = Pack::mul(Pack::load(column), Pack::broadcast(inverse[j]));
    Pack::store(column, x);
    column[j] = root;
    for (int c = j + 1; c < kPanelRows; ++c) {
      double* next = block + kPanelRows * c;
      Pack::store(next, Pack::fnma(x, Pack::broadcast(column[c]), Pack::load(next)));
    }
  }
  return ok;
}

bool factor(const PanelTrapezoid& trapezoid) {
  const PanelTrapezoid t = trapezoid;  // a copy of our own stays in registers while we write
  for (std::int64_t p = t.first; p < t.panels; ++p) {
    double* rows = t.data + panel_offset(p, t.triangle);
    for (std::int64_t q = 0; q < t.triangle && q <= p; ++q) {
      const double* diagonal = t.data + panel_offset(q, t.triangle);
      double* block = rows + kBlock * q;
      for (int c = 0; c < kPanelRows && q > 0; c += kTile) {
        Pack::D sum[kTile];
#pragma GCC unroll 8
        for (int j = 0; j < kTile; ++j) sum[j] = Pack::load(block + kPanelRows * (c + j));
        take_products(sum, rows, diagonal + c, kPanelRows * q);
#pragma GCC unroll 8
        for (int j = 0; j < kTile; ++j) Pack::store(block + kPanelRows * (c + j), sum[j]);
      }
      double* inverse = t.inverse + kPanelRows * q;
      if (q < p) {
        solve_block(block, diagonal + kBlock * q, inverse, t.columns - kPanelRows * q);
      } else if (!factor_block(block, inverse)) {
        return false;
      }
    }
  }
  return true;
}

/// What the pass over the lower triangle works on.
struct Downdate {
  double* P;
  std::int64_t rows, stride;
  const double* W;
  std::int64_t panel_stride, columns;

  double* tile(std::int64_t i, std::int64_t j) const { return P + j * stride + i; }
  const double* panel(std::int64_t row) const { return W + row / kPanelRows * panel_stride; }
};

/// Tiles of whole panels and columns, from row i on of the columns from j on; returns the first row from
/// `end` on.
inline std::int64_t downdate_tiles(const Downdate& d, std::int64_t i, std::int64_t end, std::int64_t j) {
  const double *left = d.panel(i), *right = d.panel(j) + j % kPanelRows;
  for (double* tile = d.tile(i, j); i < end; i += kPanelRows, tile += kPanelRows, left += d.panel_stride) {
    Pack::D sum[kTile];
#pragma GCC unroll 8
    for (int c = 0; c < kTile; ++c) sum[c] = Pack::load(tile + c * d.stride);
    take_products(sum, left, right, d.columns);
#pragma GCC unroll 8
    for (int c = 0; c < kTile; ++c) Pack::store(tile + c * d.stride, sum[c]);
  }
  return i;
}

/// The same for two columns of W, those of one landmark: there is a register for each of its numbers on the
/// right, which are loaded once, so that little is left to do beside reading and writing P.
inline std::int64_t downdate_tiles_by_two(const Downdate& d, std::int64_t i, std::int64_t end,
                                          std::int64_t j) {
  const double *left = d.panel(i), *right = d.panel(j) + j % kPanelRows;
  Pack::D b[2][kTile];
#pragma GCC unroll 8
  for (int c = 0; c < kTile; ++c) {
    b[0][c] = Pack::broadcast(right[c]);
    b[1][c] = Pack::broadcast(right[kPanelRows + c]);
  }
  for (double* tile = d.tile(i, j); i < end; i += kPanelRows, tile += kPanelRows, left += d.panel_stride) {
    const Pack::D x = Pack::load(left), y = Pack::load(left + kPanelRows);
#pragma GCC unroll 8
    for (int c = 0; c < kTile; ++c) {
      double* column = tile + c * d.stride;
      Pack::store(column, Pack::fnma(y, b[1][c], Pack::fnma(x, b[0][c], Pack::load(column))));
    }
  }
  return i;
}

/// A tile at the end, which has fewer rows or columns.
inline void downdate_edge(const Downdate& d, std::int64_t i, std::int64_t j) {
  double* tile = d.tile(i, j);
  const std::int64_t height = d.rows - i < kPanelRows ? d.rows - i : kPanelRows;
  const std::int64_t width = d.rows - j < kTile ? d.rows - j : kTile;
  double edge[kTile][kPanelRows] = {};
  for (std::int64_t c = 0; c < width; ++c) {
    for (std::int64_t r = 0; r < height; ++r) edge[c][r] = tile[c * d.stride + r];
  }
  Pack::D sum[kTile];
  for (int c = 0; c < kTile; ++c) sum[c] = Pack::load(edge[c]);
  take_products(sum, d.panel(i), d.panel(j) + j % kPanelRows, d.columns);
  for (int c = 0; c < kTile; ++c) Pack::store(edge[c], sum[c]);
  for (std::int64_t c = 0; c < width; ++c) {
    for (std::int64_t r = 0; r < height; ++r) tile[c * d.stride + r] = edge[c][r];
  }
}

void downdate(double* P, std::int64_t rows, std::int64_t stride, const double* W, std::int64_t panel_stride,
              std::int64_t columns) {
  const Downdate d{P, rows, stride, W, panel_stride, columns};
  for (std::int64_t j = 0; j < rows; j += kTile) {
    // What fills up the last panel is zero in W, and in P belongs to the next column above its diagonal.
    const bool filled = stride == rows && j >= kPanelRows && j + kTile < rows;
    const std::int64_t end = j + kTile > rows ? 0 : filled ? rows : rows / kPanelRows * kPanelRows;
    std::int64_t i = j / kPanelRows * kPanelRows;
    i = columns == 2 ? downdate_tiles_by_two(d, i, end, j) : downdate_tiles(d, i, end, j);
    for (; i < rows; i += kPanelRows) downdate_edge(d, i, j);
  }
}

constexpr PanelKernel kPanelKernel{&factor, &downdate};

}  // namespace

const PanelKernel* CREDENCE_OF_SET(panel_kernel)() { return &kPanelKernel; }

}  // namespace credence
