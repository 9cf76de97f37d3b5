#include "core/simd/product_kernel.h"

#include "core/simd/kernel_set.h"
#include "core/simd/panel_kernel.h"

namespace credence::internal {
namespace {

#include "core/simd/lane_pack.inc"
//
#include "core/simd/panel_pack.inc"

/// Rows 8 p … of kColumns columns: to C, or as many of them as there are.
template <int kColumns>
inline void put(const PackedProduct& d, const Pack::D (&sum)[kColumns], std::int64_t row,
                std::int64_t column) {
  for (int j = 0; j < kColumns && column + j < d.columns; ++j) {
    double* c = d.C + (column + j) * d.stride + row;
    if (d.rows - row >= kPanelRows) {
      Pack::store(c, d.add ? Pack::add(Pack::load(c), sum[j]) : sum[j]);
      continue;
    }
    double x[kPanelRows];
    Pack::store(x, sum[j]);
    for (std::int64_t i = 0; i < d.rows - row; ++i) c[i] = d.add ? c[i] + x[i] : x[i];
  }
}

void multiply(const PackedProduct& product) {
  const PackedProduct d = product;  // a copy of our own stays in registers while we write
  constexpr int kColumns = Pack::kTile;
  for (std::int64_t column = 0; column < d.columns; column += kPanelRows) {
    for (std::int64_t row = d.lower ? column : 0; row < d.rows; row += kPanelRows) {
      for (int j = 0; j < kPanelRows; j += kColumns) {
        std::int64_t first = d.A_is_upper ? row : 0;
        if (d.B_is_lower && column > first) first = column;
        const double* a = d.A + row * d.depth + kPanelRows * first;
        const double* b = d.B + column * d.depth + kPanelRows * first + j;
        Pack::D sum[kColumns];
        for (int i = 0; i < kColumns; ++i) sum[i] = Pack::broadcast(0.0);
        for (std::int64_t k = first; k < d.depth; ++k, a += kPanelRows, b += kPanelRows) {
          const Pack::D x = Pack::load(a);
#pragma GCC unroll 8
          for (int i = 0; i < kColumns; ++i) sum[i] = Pack::fma(x, Pack::broadcast(b[i]), sum[i]);
        }
        put(d, sum, row, column + j);
      }
    }
  }
}

}  // namespace

const ProductKernel* CREDENCE_OF_SET(product_kernel)() {
  static constexpr ProductKernel kernel{&multiply};
  return &kernel;
}

}  // namespace credence::internal
