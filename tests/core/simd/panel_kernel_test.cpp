#include "core/simd/panel_kernel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "core/simd/aligned_vector.h"
#include "tests/core/random_matrix.h"

namespace credence::internal {
namespace {

/// The kernels that this machine runs.
std::vector<const PanelKernel*> panel_kernels() {
  std::vector<const PanelKernel*> kernels;
  for (const InstructionSet set : {InstructionSet::scalar, InstructionSet::avx2, InstructionSet::avx512}) {
    if (is_supported(set)) kernels.push_back(&panel_kernel(set));
  }
  return kernels;
}

/// A matrix in panels of eight rows, each `gap` doubles longer than it needs to be; what fills up the last is
/// `filler`.
struct Panels {
  std::int64_t stride;
  AlignedVector data;

  explicit Panels(const Matrix& W, std::int64_t gap = 0, double filler = 7.0)
      : stride(kPanelRows * W.cols() + gap),
        data(static_cast<std::size_t>(panels_of(W.rows()) * stride), filler) {
    for (Index i = 0; i < W.rows(); ++i) {
      for (Index k = 0; k < W.cols(); ++k) data[at(i, k)] = W(i, k);
    }
  }
  std::size_t at(Index i, Index k) const {
    return static_cast<std::size_t>(i / kPanelRows * stride + kPanelRows * k + i % kPanelRows);
  }
};

AlignedVector padded_vector(const Vector& y) {
  AlignedVector all(static_cast<std::size_t>(whole_panels(y.size())), 0.0);
  for (Index i = 0; i < y.size(); ++i) all[static_cast<std::size_t>(i)] = y[i];
  return all;
}

Vector first_of(const AlignedVector& padded, Index n) { return Eigen::Map<const Vector>(padded.data(), n); }

TEST(PanelKernel, PanelsOfATrapezoidFollowEachOther) {
  EXPECT_EQ(panels_of(0), 0);
  EXPECT_EQ(panels_of(8), 1);
  EXPECT_EQ(panels_of(9), 2);
  EXPECT_EQ(whole_panels(9), 16);
  // A triangle of three panels has blocks of 64 doubles in rows of 1, 2 and 3; three more in each row below.
  const std::int64_t blocks[] = {0, 1, 3, 6, 9, 12};
  for (std::int64_t p = 0; p < 6; ++p) EXPECT_EQ(panel_offset(p, 3), 64 * blocks[p]) << p;
}

/// A symmetric matrix of m rows and others below it, as a trapezoid.
class Trapezoid {
 public:
  Trapezoid(const Matrix& S, const Matrix& Y)
      : columns_(S.cols()), triangle_(panels_of(columns_)), panels_(triangle_ + panels_of(Y.rows())) {
    data_.assign(static_cast<std::size_t>(panel_offset(panels_, triangle_)), 0.0);
    inverse_.assign(static_cast<std::size_t>(kPanelRows * triangle_), 0.0);
    for (Index k = 0; k < kPanelRows * triangle_; ++k) {
      if (k >= columns_) at(k, k) = 1.0;
      for (Index i = k; i < S.rows() && k < columns_; ++i) at(i, k) = S(i, k);
      for (Index i = 0; i < Y.rows() && k < columns_; ++i) at(kPanelRows * triangle_ + i, k) = Y(i, k);
    }
  }
  double& at(Index row, Index column) {
    return data_[static_cast<std::size_t>(panel_offset(row / kPanelRows, triangle_) + kPanelRows * column +
                                          row % kPanelRows)];
  }
  double inverse(Index k) const { return inverse_[static_cast<std::size_t>(k)]; }
  double& below(Index row, Index column) { return at(kPanelRows * triangle_ + row, column); }
  std::int64_t triangle() const { return triangle_; }
  PanelTrapezoid from(std::int64_t first, std::int64_t panels) {
    return {.data = data_.data(),
            .inverse = inverse_.data(),
            .triangle = triangle_,
            .panels = panels,
            .first = first,
            .columns = columns_};
  }
  PanelTrapezoid all() { return from(0, panels_); }
  std::int64_t panels() const { return panels_; }

 private:
  std::int64_t columns_, triangle_, panels_;
  AlignedVector data_, inverse_;
};

Matrix positive_matrix(Index m) {
  const Matrix A = random_matrix(m, m, 3);
  return A * A.transpose() + Matrix::Identity(m, m);
}

/// Column by column, every sum ascending by fused multiply-adds: L, and Y L⁻ᵀ below it.
Matrix factor_by_definition(const Matrix& S, const Matrix& Y) {
  const Index m = S.rows();
  Matrix L(m + Y.rows(), m);
  L << S, Y;
  for (Index c = 0; c < m; ++c) {
    for (Index i = c; i < L.rows(); ++i) {
      for (Index k = 0; k < c; ++k) L(i, c) = std::fma(-L(i, k), L(c, k), L(i, c));
    }
    const double root = std::sqrt(L(c, c)), inverse = 1.0 / root;
    for (Index i = c + 1; i < L.rows(); ++i) L(i, c) *= inverse;
    L(c, c) = root;
  }
  return L;
}

TEST(PanelKernel, AFactorIsThatOfALoopToTheBit) {
  for (const PanelKernel* kernel : panel_kernels()) {
    for (const Index m : {1, 2, 3, 4, 5, 7, 8, 9, 12, 16, 25}) {
      for (const Index n : {0, 1, 8, 19}) {
        const Matrix S = positive_matrix(m), Y = random_matrix(n, m, 5);
        const Matrix expected = factor_by_definition(S, Y);
        Trapezoid got(S, Y);
        ASSERT_TRUE(kernel->factor(got.all()));
        for (Index k = 0; k < m; ++k) {
          EXPECT_EQ(got.inverse(k), 1.0 / expected(k, k));
          for (Index i = k; i < m; ++i) ASSERT_EQ(got.at(i, k), expected(i, k)) << m << ": " << i << ' ' << k;
          for (Index i = 0; i < n; ++i) ASSERT_EQ(got.below(i, k), expected(m + i, k)) << m << ' ' << n;
        }
        for (Index k = m; k < kPanelRows * got.triangle(); ++k) {
          EXPECT_EQ(got.inverse(k), 1.0);
          for (Index i = 0; i < n; ++i) EXPECT_EQ(got.below(i, k), 0.0) << "what fills up the last block";
        }
      }
    }
  }
}

// What has been factored already is only read.
TEST(PanelKernel, RowsBelowMayComeLater) {
  const Matrix S = positive_matrix(11), Y = random_matrix(10, 11, 6);
  for (const PanelKernel* kernel : panel_kernels()) {
    Trapezoid at_once(S, Y), later(S, Y);
    ASSERT_TRUE(kernel->factor(at_once.all()));
    ASSERT_TRUE(kernel->factor(later.from(0, later.triangle())));
    ASSERT_TRUE(kernel->factor(later.from(later.triangle(), later.panels())));
    for (Index k = 0; k < 11; ++k) {
      for (Index i = 0; i < 10; ++i) EXPECT_EQ(later.below(i, k), at_once.below(i, k));
    }
  }
}

TEST(PanelKernel, APivotThatIsNotPositiveAndFiniteIsSaid) {
  for (const PanelKernel* kernel : panel_kernels()) {
    for (const double pivot : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
      for (const Index at : {0, 7, 8, 10}) {
        Matrix S = Matrix::Identity(11, 11);
        S(at, at) = pivot;
        Trapezoid trapezoid(S, Matrix(0, 11));
        EXPECT_FALSE(kernel->factor(trapezoid.all())) << pivot << " at " << at;
      }
    }
    Trapezoid least(Matrix::Constant(1, 1, std::numeric_limits<double>::min()), Matrix(0, 1));
    EXPECT_TRUE(kernel->factor(least.all()));
  }
}

// The lower triangle, and nothing where the caller was promised that it stays.
TEST(PanelKernel, ADowndateIsThatOfALoopToTheBit) {
  for (const PanelKernel* kernel : panel_kernels()) {
    for (const Index n : {1, 5, 8, 9, 16, 23, 40}) {
      for (const Index m : {0, 1, 4, 11}) {
        for (const Index gap : {0, 3}) {
          const Matrix W = random_matrix(n, m, 8), before = random_matrix(n + gap, n, 9);
          const Panels panels(W, 8);
          Matrix P = before;
          kernel->downdate({.P = P.data(),
                            .rows = n,
                            .stride = n + gap,
                            .W = panels.data.data(),
                            .panel_stride = panels.stride,
                            .columns = m});
          for (Index j = 0; j < n; ++j) {
            for (Index i = 0; i < n + gap; ++i) {
              double expected = before(i, j);
              if (i < j && (gap == 0 || i / kPanelRows == j / kPanelRows)) continue;
              for (Index k = 0; k < m && i >= j && i < n; ++k) {
                expected = std::fma(-W(i, k), W(j, k), expected);
              }
              ASSERT_EQ(P(i, j), expected) << n << ' ' << m << ' ' << gap << ": " << i << ' ' << j;
            }
          }
        }
      }
    }
  }
}

TEST(PanelKernel, ProductsWithARowAndSquaresAreSubtractedTermByTerm) {
  for (const PanelKernel* kernel : panel_kernels()) {
    for (const Index n : {1, 8, 21}) {
      for (const Index m : {0, 1, 6}) {
        const Matrix W = random_matrix(n, m, 10);
        const Vector y = random_matrix(n, 1, 11);
        const Panels panels(W, 16);
        for (const Index row : {Index{0}, n / 2, n - 1}) {
          Vector expected = y, squares = y;
          for (Index k = 0; k < m; ++k) {
            for (Index i = 0; i < n; ++i) {
              expected[i] = std::fma(-W(i, k), W(row, k), expected[i]);
              squares[i] = std::fma(-W(i, k), W(i, k), squares[i]);
            }
          }
          AlignedVector product = padded_vector(y), square = padded_vector(y);
          PanelProduct all{.y = product.data(),
                           .rows = n,
                           .W = panels.data.data(),
                           .panel_stride = panels.stride,
                           .columns = m};
          kernel->subtract(all, row);
          all.y = square.data();
          kernel->subtract_squares(all);
          EXPECT_EQ(first_of(product, n), expected) << n << ' ' << m << ' ' << row;
          EXPECT_EQ(first_of(square, n), squares) << n << ' ' << m;
        }
      }
    }
  }
}

// Of columns side by side each takes the row of its own, and has the bits that it has alone.
TEST(PanelKernel, ProductsWithSeveralRowsAreThoseWithOneAfterTheOther) {
  for (const PanelKernel* kernel : panel_kernels()) {
    for (const Index count : {1, 2, 3, 5}) {
      constexpr Index n = 21, m = 6, kFirst = 6;
      const Panels panels(random_matrix(n, m, 15), 16);
      const Matrix start = random_matrix(whole_panels(n), count, 16);
      Matrix together = start, single = start;
      PanelProduct product{.y = together.data(),
                           .rows = n,
                           .W = panels.data.data(),
                           .panel_stride = panels.stride,
                           .columns = m,
                           .count = count,
                           .y_stride = together.rows()};
      kernel->subtract(product, kFirst);
      product.count = 1;
      for (Index c = 0; c < count; ++c) {
        product.y = single.col(c).data();
        kernel->subtract(product, kFirst + c);
      }
      EXPECT_EQ(together.topRows(n), single.topRows(n)) << count;
      EXPECT_NE(together.topRows(n), start.topRows(n)) << count;
    }
  }
}

// In place, and in panels that have others between them.
TEST(PanelKernel, SeveralCombinationsAreThoseOneAfterTheOther) {
  for (const PanelKernel* kernel : panel_kernels()) {
    for (const Index count : {1, 2, 3}) {
      constexpr Index kRows = 24, kColumns = 3;
      const Matrix columns = random_matrix(kRows, kColumns, 17), factors = random_matrix(kColumns, count, 18);
      Matrix expected(kRows, count), in_place = columns;
      Matrix panels = Matrix::Zero(kPanelRows, 4 * kRows / kPanelRows);
      const double* from[kColumns] = {columns.col(0).data(), columns.col(1).data(), columns.col(2).data()};
      const double* own[kColumns] = {in_place.col(0).data(), in_place.col(1).data(), in_place.col(2).data()};
      for (Index j = 0; j < count; ++j) {
        kernel->combine({.columns = from, .count = kColumns, .factors = factors.col(j).data(), .rows = kRows},
                        {.y = expected.col(j).data()});
      }
      kernel->combine({.columns = own, .count = kColumns, .factors = factors.data(), .rows = kRows},
                      {.y = in_place.data(), .count = count, .step = kRows});
      kernel->combine({.columns = from, .count = kColumns, .factors = factors.data(), .rows = kRows},
                      {.y = panels.data(), .count = count, .step = kPanelRows, .panel_step = 4 * kPanelRows});
      EXPECT_EQ(in_place.leftCols(count), expected);
      EXPECT_EQ(in_place.rightCols(kColumns - count), columns.rightCols(kColumns - count));
      for (Index row = 0; row < kRows; row += kPanelRows) {
        for (Index j = 0; j < 4; ++j) {
          const Vector panel = panels.col(4 * row / kPanelRows + j);
          if (j < count) EXPECT_EQ(panel, expected.col(j).segment(row, kPanelRows));
          if (j >= count) EXPECT_EQ(panel, Vector::Zero(kPanelRows));
        }
      }
    }
  }
}

// Here each product is rounded before it is added.
TEST(PanelKernel, SumsAndCombinationsRoundEveryProduct) {
  for (const PanelKernel* kernel : panel_kernels()) {
    for (const Index n : {1, 8, 13}) {
      for (const Index m : {0, 1, 5}) {
        const Matrix W = random_matrix(n, m, 12), columns = random_matrix(whole_panels(n), m, 13);
        const Vector y = random_matrix(m, 1, 14);
        Vector squares = Vector::Zero(n), product = squares, combined = squares;
        std::vector<const double*> from;
        for (Index k = 0; k < m; ++k) {
          from.push_back(columns.col(k).data());
          for (Index i = 0; i < n; ++i) {
            squares[i] += W(i, k) * W(i, k);
            product[i] += y[k] * W(i, k);
            combined[i] += y[k] * columns(i, k);
          }
        }
        const Panels panels(W, 8);
        AlignedVector got_squares = padded_vector(Vector::Ones(n)), got_product = got_squares,
                      got_combined = got_squares;
        kernel->sums({.W = panels.data.data(),
                      .rows = n,
                      .panel_stride = panels.stride,
                      .columns = m,
                      .y = y.data(),
                      .squares = got_squares.data(),
                      .product = got_product.data()});
        kernel->combine({.columns = from.data(), .count = m, .factors = y.data(), .rows = n},
                        {.y = got_combined.data()});
        EXPECT_EQ(first_of(got_squares, n), squares) << n << ' ' << m;
        EXPECT_EQ(first_of(got_product, n), product) << n << ' ' << m;
        EXPECT_EQ(first_of(got_combined, n), combined) << n << ' ' << m;
      }
    }
  }
}

TEST(PanelKernel, EveryInstructionSetHasAKernelOfItsOwnOrIsRefused) {
  const PanelKernel& scalar = panel_kernel(InstructionSet::scalar);
  for (const InstructionSet set : {InstructionSet::avx2, InstructionSet::avx512}) {
    if (is_supported(set)) {
      EXPECT_NE(panel_kernel(set).factor, scalar.factor) << instruction_set_name(set);
    } else {
      EXPECT_THROW(panel_kernel(set), std::invalid_argument) << instruction_set_name(set);
    }
  }
}

}  // namespace
}  // namespace credence::internal
