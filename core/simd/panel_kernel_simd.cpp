#include "core/simd/panel_kernel.h"

#include "core/simd/kernel_set.h"

namespace credence::internal {
namespace {

#include "core/simd/lane_pack.inc"
//
#include "core/simd/panel_pack.inc"

constexpr std::int64_t kBlock = kPanelRows * kPanelRows;

/// Columns that are kept in registers side by side.
constexpr int kTile = Pack::kTile;
/// Panels whose rows are kept there together, where there are registers: what is broadcast serves all of
/// them.
constexpr int kTogether = Pack::kParts == 1 ? 2 : 1;

/// sum[i][j] −= Σ_k a_i(:, k) b(j, k) over the first `columns` columns of panels, a_i that many doubles
/// behind a.
template <int kPanels>
__attribute__((always_inline)) inline void take_products(Pack::D (&sum)[kPanels][kTile], const double* a,
                                                         std::int64_t panel_stride, const double* b,
                                                         std::int64_t columns) {
  for (std::int64_t k = 0; k < columns; ++k, a += kPanelRows, b += kPanelRows) {
    Pack::D x[kPanels];
    for (int i = 0; i < kPanels; ++i) x[i] = Pack::load(a + i * panel_stride);
#pragma GCC unroll 8
    for (int j = 0; j < kTile; ++j) {
      const Pack::D factor = Pack::broadcast(b[j]);
      for (int i = 0; i < kPanels; ++i) sum[i][j] = Pack::fnma(x[i], factor, sum[i][j]);
    }
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
  switch (solved_columns(columns)) {
    case 2: return solve_columns<2>(block, L, inverse);
    case 4: return solve_columns<4>(block, L, inverse);
    default: return solve_columns<kPanelRows>(block, L, inverse);
  }
}

/// A block on the diagonal becomes its factor; false if that does not exist. Beyond its first `columns` it is
/// that of the identity, which stays.
inline bool factor_block(double* block, double* inverse, std::int64_t columns) {
  bool ok = true;
  for (std::int64_t j = 0; j < kPanelRows; ++j) inverse[j] = 1.0;
  for (std::int64_t j = 0; j < kPanelRows && j < columns; ++j) {
    double* column = block + kPanelRows * j;
    const double pivot = column[j], root = __builtin_sqrt(pivot);
    ok = ok && pivot > 0.0 && pivot <= __DBL_MAX__;
    inverse[j] = 1.0 / root;
    const Pack::D x = Pack::mul(Pack::load(column), Pack::broadcast(inverse[j]));
    Pack::store(column, x);
    column[j] = root;
    for (std::int64_t c = j + 1; c < kPanelRows && c < columns; ++c) {
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
        Pack::D sum[1][kTile];
#pragma GCC unroll 8
        for (int j = 0; j < kTile; ++j) sum[0][j] = Pack::load(block + kPanelRows * (c + j));
        take_products(sum, rows, 0, diagonal + c, kPanelRows * q);
#pragma GCC unroll 8
        for (int j = 0; j < kTile; ++j) Pack::store(block + kPanelRows * (c + j), sum[0][j]);
      }
      double* inverse = t.inverse + kPanelRows * q;
      if (q < p) {
        solve_block(block, diagonal + kBlock * q, inverse, t.columns - kPanelRows * q);
      } else if (!factor_block(block, inverse, t.columns - kPanelRows * q)) {
        return false;
      }
    }
  }
  return true;
}

/// The rows of kPanels panels from p on in the columns of panel q.
template <int kPanels>
inline void downdate_block(const PanelDowndate& d, std::int64_t p, std::int64_t q) {
  double* tile = d.P + kPanelRows * (q * d.stride + p);
  const auto place = [&](int i, int c) { return tile + c * d.stride + kPanelRows * i; };
  for (int first = 0; first < kPanelRows; first += kTile, tile += kTile * d.stride) {
    Pack::D sum[kPanels][kTile];
#pragma GCC unroll 8
    for (int c = 0; c < kTile; ++c) {
      for (int i = 0; i < kPanels; ++i) sum[i][c] = Pack::load(place(i, c));
    }
    take_products(sum, d.W + p * d.panel_stride, d.panel_stride, d.W + q * d.panel_stride + first, d.columns);
#pragma GCC unroll 8
    for (int c = 0; c < kTile; ++c) {
      for (int i = 0; i < kPanels; ++i) Pack::store(place(i, c), sum[i][c]);
    }
  }
}

/// The same at the end of P, where there are fewer rows or columns.
inline void downdate_edge(const PanelDowndate& d, std::int64_t p, std::int64_t q) {
  const std::int64_t rows = d.rows - kPanelRows * p, columns = d.rows - kPanelRows * q;
  const std::int64_t height = rows < kPanelRows ? rows : kPanelRows;
  for (std::int64_t first = 0; first < kPanelRows && first < columns; first += kTile) {
    double* tile = d.P + (kPanelRows * q + first) * d.stride + kPanelRows * p;
    const std::int64_t width = columns - first < kTile ? columns - first : kTile;
    double edge[kTile][kPanelRows] = {};
    for (std::int64_t c = 0; c < width; ++c) {
      for (std::int64_t r = 0; r < height; ++r) edge[c][r] = tile[c * d.stride + r];
    }
    Pack::D sum[1][kTile];
    for (int c = 0; c < kTile; ++c) sum[0][c] = Pack::load(edge[c]);
    take_products(sum, d.W + p * d.panel_stride, 0, d.W + q * d.panel_stride + first, d.columns);
    for (int c = 0; c < kTile; ++c) Pack::store(edge[c], sum[0][c]);
    for (std::int64_t c = 0; c < width; ++c) {
      for (std::int64_t r = 0; r < height; ++r) tile[c * d.stride + r] = edge[c][r];
    }
  }
}

void downdate(const PanelDowndate& downdate) {
  const PanelDowndate d = downdate;  // a copy of our own stays in registers while we write
  for (std::int64_t q = 0; kPanelRows * q < d.rows; ++q) {
    const std::int64_t next = kPanelRows * (q + 1);
    // What is below the last row belongs to the next column, above its diagonal.
    const bool goes_on = d.stride == d.rows && q > 0 && next < d.rows;
    const std::int64_t end = next > d.rows ? q : goes_on ? panels_of(d.rows) : d.rows / kPanelRows;
    std::int64_t p = q;
    for (; p + kTogether <= end; p += kTogether) downdate_block<kTogether>(d, p, q);
    for (; p < end; ++p) downdate_block<1>(d, p, q);
    for (; kPanelRows * p < d.rows; ++p) downdate_edge(d, p, q);
  }
}

/// Calls rows<kPanels>(row) for all panels, two at a time where they last: one's sums hide the latency of the
/// other's.
template <class Rows>
inline void for_panels(std::int64_t end, Rows rows) {
  constexpr int kMany = 2;
  std::int64_t row = 0;
  for (; row + kMany * kPanelRows <= end; row += kMany * kPanelRows) rows.template operator()<kMany>(row);
  for (; row < end; row += kPanelRows) rows.template operator()<1>(row);
}

/// Calls take<kCount>(first) for `count` columns, at most three at a time, which are kept in registers
/// together.
template <class Take>
inline void for_columns(std::int64_t count, Take take) {
  std::int64_t first = 0;
  for (; count - first >= 3; first += 3) take.template operator()<3>(first);
  if (count - first == 2) take.template operator()<2>(first);
  if (count - first == 1) take.template operator()<1>(first);
}

void subtract(const PanelProduct& product, std::int64_t row_of_first) {
  const PanelProduct d = product;  // a copy of our own stays in registers while we write
  for_columns(d.count, [&]<int kColumns>(std::int64_t first) {
    double* y = d.y + first * d.y_stride;
    const double* w[kColumns];
    for (int c = 0; c < kColumns; ++c) {
      const std::int64_t of_column = row_of_first + first + c;
      w[c] = d.W + of_column / kPanelRows * d.panel_stride + of_column % kPanelRows;
    }
    for_panels(d.rows, [&]<int kPanels>(std::int64_t row) {
      const double* W = d.W + row / kPanelRows * d.panel_stride;
      const auto place = [&](int i, int c) { return y + c * d.y_stride + row + kPanelRows * i; };
      Pack::D sum[kPanels][kColumns];
      for (int i = 0; i < kPanels; ++i) {
        for (int c = 0; c < kColumns; ++c) sum[i][c] = Pack::load(place(i, c));
      }
      for (std::int64_t k = 0; k < d.columns; ++k) {
        Pack::D x[kPanels];
        for (int i = 0; i < kPanels; ++i) x[i] = Pack::load(W + i * d.panel_stride + kPanelRows * k);
        for (int c = 0; c < kColumns; ++c) {
          const Pack::D factor = Pack::broadcast(w[c][kPanelRows * k]);
          for (int i = 0; i < kPanels; ++i) sum[i][c] = Pack::fnma(x[i], factor, sum[i][c]);
        }
      }
      for (int i = 0; i < kPanels; ++i) {
        for (int c = 0; c < kColumns; ++c) Pack::store(place(i, c), sum[i][c]);
      }
    });
  });
}

void subtract_squares(const PanelProduct& product) {
  const PanelProduct d = product;
  for_panels(d.rows, [&]<int kPanels>(std::int64_t row) {
    const double* W = d.W + row / kPanelRows * d.panel_stride;
    Pack::D sum[kPanels];
    for (int i = 0; i < kPanels; ++i) sum[i] = Pack::load(d.y + row + kPanelRows * i);
    for (std::int64_t k = 0; k < d.columns; ++k) {
      for (int i = 0; i < kPanels; ++i) {
        const Pack::D x = Pack::load(W + i * d.panel_stride + kPanelRows * k);
        sum[i] = Pack::fnma(x, x, sum[i]);
      }
    }
    for (int i = 0; i < kPanels; ++i) Pack::store(d.y + row + kPanelRows * i, sum[i]);
  });
}

/// All results at once, since they may be the columns.
template <int kResults>
inline void combine_all(const PanelCombination& d, const PanelResults& results) {
  for_panels(d.rows, [&]<int kPanels>(std::int64_t row) {
    Pack::D sum[kPanels][kResults];
    for (int i = 0; i < kPanels; ++i) {
      for (int j = 0; j < kResults; ++j) sum[i][j] = Pack::broadcast(0.0);
    }
    for (std::int64_t c = 0; c < d.count; ++c) {
      Pack::D x[kPanels];
      for (int i = 0; i < kPanels; ++i) x[i] = Pack::load(d.columns[c] + row + kPanelRows * i);
      for (int j = 0; j < kResults; ++j) {
        const Pack::D factor = Pack::broadcast(d.factors[j * d.count + c]);
        for (int i = 0; i < kPanels; ++i) sum[i][j] = Pack::add(sum[i][j], Pack::mul(factor, x[i]));
      }
    }
    double* y = results.y + row / kPanelRows * results.panel_step;
    for (int i = 0; i < kPanels; ++i) {
      for (int j = 0; j < kResults; ++j)
        Pack::store(y + i * results.panel_step + j * results.step, sum[i][j]);
    }
  });
}

void combine(const PanelCombination& combination, const PanelResults& results) {
  const PanelCombination d = combination;
  const PanelResults r = results;
  switch (r.count) {
    case 1: return combine_all<1>(d, r);
    case 2: return combine_all<2>(d, r);
    default: return combine_all<3>(d, r);
  }
}

void sums(const PanelSums& sums) {
  const PanelSums d = sums;
  for (std::int64_t p = 0; kPanelRows * p < d.rows; ++p) {
    const double* W = d.W + p * d.panel_stride;
    Pack::D square = Pack::broadcast(0.0), sum = Pack::broadcast(0.0);
    for (std::int64_t k = 0; k < d.columns; ++k) {
      const Pack::D x = Pack::load(W + kPanelRows * k);
      square = Pack::add(square, Pack::mul(x, x));
      sum = Pack::add(sum, Pack::mul(Pack::broadcast(d.y[k]), x));
    }
    Pack::store(d.squares + kPanelRows * p, square);
    Pack::store(d.product + kPanelRows * p, sum);
  }
}

constexpr PanelKernel kPanelKernel{&factor, &downdate, &subtract, &subtract_squares, &combine, &sums};

}  // namespace

const PanelKernel* CREDENCE_OF_SET(panel_kernel)() { return &kPanelKernel; }

}  // namespace credence::internal
