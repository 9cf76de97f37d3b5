#pragma once

#include <span>

#include "core/simd/aligned_vector.h"
#include "core/simd/panel_kernel.h"
#include "core/simd/product_kernel.h"
#include "core/types.h"

namespace credence::internal {

/// S = L Lᵀ with what a filter makes of L, at the speed of the machine's widest registers and with the same
/// bits on every machine: W = Y L⁻ᵀ, y = L⁻¹ν, P − W Wᵀ. Keeps its memory, so that a matrix of no larger size
/// allocates nothing.
class PanelCholesky {
 public:
  /// Throws std::invalid_argument if this machine does not support `set`.
  explicit PanelCholesky(InstructionSet set = best_instruction_set())
      : kernel_(&panel_kernel(set)), product_(&product_kernel(set)) {}

  /// Factors S, m×m, whose lower triangle is read, and solves for Y, n×m, and ν: (m³/6 + n m²/2)
  /// multiply-adds. False if S is not positive definite; then nothing else has a meaning.
  bool compute(const MatrixRef& S, const MatrixRef& Y, const VectorRef& nu);
  /// The same with no row in Y.
  bool compute(const MatrixRef& S, const VectorRef& nu) { return compute(S, Matrix(0, S.cols()), nu); }

  /// Room for an n×m Y, to be written as solved_panels() are laid out, the last panel filled up with zeros,
  /// and then what compute() does with it.
  double* place(Index m, Index n);
  bool compute_placed(const MatrixRef& S, const VectorRef& nu);

  Index size() const { return columns_; }                                             ///< m
  Index rows() const { return rows_; }                                                ///< n, those of W
  double pivot(Index i) const { return data_[at(i, i)]; }                             ///< L_ii
  double log_determinant() const;                                                     ///< of S
  Eigen::Map<const Vector> whitened() const { return {whitened_.data(), columns_}; }  ///< y
  Matrix L() const;                                                                   ///< allocates
  Matrix W() const;                                                                   ///< allocates
  Matrix gain() const;                    ///< W L⁻¹ = Y S⁻¹; allocates
  void gain(Eigen::Ref<Matrix> K) const;  ///< into K, n×m

  /// (S⁻¹)_ii; W is gone afterwards. m³/2 multiply-adds.
  const Vector& inverse_diagonal();

  /// `squares`_i = Σ_k W_ik², `product` = W y; the first n of both, which have the length of whole panels.
  void sums(Vector& squares, Vector& product) const;

  /// x += W y, n.
  void add_correction(Eigen::Ref<Vector> x) const;

  /// y_j = Σ_c factors_jc columns_c, term by term; the columns and y have n rows, padded to whole panels.
  void combine(std::span<const double* const> columns, const double* factors, Index n,
               const PanelResults& y) const {
    kernel_->combine({.columns = columns.data(), .count = std::ssize(columns), .factors = factors, .rows = n},
                     y);
  }

  /// W in panels of eight rows, from one of which to the next it is so far; anything fills up the last.
  const double* solved_panels() const { return solved_panel(0); }
  Index solved_panel_stride() const { return kPanelRows * kPanelRows * triangle_; }

  /// P −= W Wᵀ for the first columns of P: n rows.
  void downdate_columns(Eigen::Ref<Matrix> P);

 private:
  std::size_t at(Index row, Index column) const {
    return static_cast<std::size_t>(panel_offset(row / kPanelRows, triangle_) + kPanelRows * column +
                                    row % kPanelRows);
  }
  const double* solved_panel(Index p) const { return data_.data() + panel_offset(triangle_ + p, triangle_); }
  void shape(Index columns, Index rows_below);
  void fill_up(Index first, Index end);
  void copy_rows(Eigen::Ref<Matrix> W) const;
  PanelTrapezoid trapezoid(Index first) {
    return {.data = data_.data(),
            .inverse = inverse_.data(),
            .triangle = triangle_,
            .panels = panels_,
            .first = first,
            .columns = columns_};
  }

  const PanelKernel* kernel_;
  const ProductKernel* product_;
  Index columns_ = 0, rows_ = 0;     ///< m, n
  Index triangle_ = 0, panels_ = 0;  ///< panels of S, and of all
  AlignedVector data_, inverse_, minus_;
  Vector whitened_;  ///< its first entries, so that it keeps its memory
  Vector inverse_diagonal_;
};

}  // namespace credence::internal
