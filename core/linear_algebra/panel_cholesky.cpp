#include "core/linear_algebra/panel_cholesky.h"

#include <algorithm>
#include <stdexcept>

#include "core/linear_algebra/logarithm.h"

namespace credence::internal {
namespace {

using Panel = Eigen::Matrix<double, kPanelRows, 1>;
using PanelColumns = Eigen::Map<const Eigen::Matrix<double, kPanelRows, Eigen::Dynamic>>;

/// Rows 8 p … of the first `columns` columns of M, filled up with zeros.
void pack_panel(const MatrixRef& M, Index p, Index columns, double* to) {
  const Index row = kPanelRows * p, rows = std::min<Index>(kPanelRows, M.rows() - row);
  for (Index k = 0; k < columns; ++k, to += kPanelRows) {
    const double* from = M.data() + k * M.outerStride() + row;
    if (rows == kPanelRows) {
      Eigen::Map<Panel>{to} = Eigen::Map<const Panel>(from);
      continue;
    }
    for (Index i = 0; i < rows; ++i) to[i] = from[i];
    for (Index i = rows; i < kPanelRows; ++i) to[i] = 0.0;
  }
}

}  // namespace

/// Room for S and `rows_below` rows; what is solved of the columns that fill up the last panel of S are those
/// of the identity.
void PanelCholesky::shape(Index columns, Index rows_below) {
  columns_ = columns;
  triangle_ = panels_of(columns);
  panels_ = triangle_ + panels_of(rows_below);
  const auto size = static_cast<std::size_t>(panel_offset(panels_, triangle_));
  if (data_.size() < size) data_.resize(size);
  inverse_.resize(static_cast<std::size_t>(kPanelRows * triangle_));
  if (columns == 0) return;
  const Index last = kPanelRows * (triangle_ - 1), end = last + solved_columns(columns - last);
  fill_up(triangle_ - 1, end);
  for (Index k = columns; k < end; ++k) data_[at(k, k)] = 1.0;
}

/// Zeros in the columns from m to `end` of the panels from `first` on.
void PanelCholesky::fill_up(Index first, Index end) {
  for (Index p = first; columns_ < end && p < panels_; ++p) {
    std::fill_n(&data_[at(kPanelRows * p, columns_)], kPanelRows * (end - columns_), 0.0);
  }
}

bool PanelCholesky::compute(const MatrixRef& S, const MatrixRef& Y, const VectorRef& nu) {
  const Index m = S.cols();
  if (S.rows() != m || Y.cols() != m || nu.size() != m) {
    throw std::invalid_argument("PanelCholesky: the shapes do not match");
  }
  double* panel = place(m, Y.rows());
  for (Index p = 0; p < panels_of(rows_); ++p, panel += solved_panel_stride()) pack_panel(Y, p, m, panel);
  return compute_placed(S, nu);
}

double* PanelCholesky::place(Index m, Index n) {
  rows_ = n;
  shape(m, n + 1);
  return data_.data() + panel_offset(triangle_, triangle_);
}

bool PanelCholesky::compute_placed(const MatrixRef& S, const VectorRef& nu) {
  const Index m = columns_, below = kPanelRows * triangle_;
  if (S.rows() != m || S.cols() != m || nu.size() != m) {
    throw std::invalid_argument("PanelCholesky: S or ν is not of the size that was placed");
  }
  for (Index p = 0; p < triangle_; ++p)
    pack_panel(S, p, std::min(m, kPanelRows * (p + 1)), &data_[at(kPanelRows * p, 0)]);
  if (rows_ % kPanelRows == 0) std::fill_n(&data_[at(below + rows_, 0)], kPanelRows * m, 0.0);
  for (Index k = 0; k < m; ++k) data_[at(below + rows_, k)] = nu[k];
  if (!kernel_->factor(trapezoid(0))) return false;
  if (whitened_.size() < m) whitened_.resize(m);
  for (Index k = 0; k < m; ++k) whitened_[k] = data_[at(below + rows_, k)];
  return true;
}

double PanelCholesky::log_determinant() const {
  double sum = 0.0;
  for (Index i = 0; i < columns_; ++i) sum += natural_logarithm(pivot(i));
  return 2.0 * sum;
}

Matrix PanelCholesky::L() const {
  Matrix L = Matrix::Zero(columns_, columns_);
  for (Index row = 0; row < columns_; row += kPanelRows) {
    const Index count = std::min<Index>(kPanelRows, columns_ - row);
    const PanelColumns rows(&data_[at(row, 0)], kPanelRows, row + count);
    L.block(row, 0, count, row) = rows.topLeftCorner(count, row);
    L.block(row, row, count, count).triangularView<Eigen::Lower>() = rows.block(0, row, count, count);
  }
  return L;
}

Matrix PanelCholesky::W() const {
  Matrix W(rows_, columns_);
  copy_rows(W);
  return W;
}

void PanelCholesky::copy_rows(Eigen::Ref<Matrix> W) const {
  for (Index row = 0; row < rows_; row += kPanelRows) {
    const Index count = std::min<Index>(kPanelRows, rows_ - row);
    W.middleRows(row, count) =
        PanelColumns(solved_panel(row / kPanelRows), kPanelRows, columns_).topRows(count);
  }
}

void PanelCholesky::gain(Eigen::Ref<Matrix> K) const {
  copy_rows(K);
  for (Index k = columns_ - 1; k >= 0; --k) {
    for (Index i = k + 1; i < columns_; ++i) K.col(k) -= data_[at(i, k)] * K.col(i);
    K.col(k) /= pivot(k);
  }
}

Matrix PanelCholesky::gain() const {
  Matrix K(rows_, columns_);
  gain(K);
  return K;
}

const Vector& PanelCholesky::inverse_diagonal() {
  // The rows of the identity become those of L⁻ᵀ.
  const Index m = columns_, below = kPanelRows * triangle_;
  shape(m, m);
  rows_ = 0;
  for (Index p = triangle_; p < panels_; ++p) std::fill_n(&data_[at(kPanelRows * p, 0)], kPanelRows * m, 0.0);
  for (Index i = 0; i < m; ++i) data_[at(below + i, i)] = 1.0;
  kernel_->factor(trapezoid(triangle_));
  inverse_diagonal_.resize(m);
  for (Index p = 0; p < triangle_; ++p) {
    Panel sum = Panel::Zero();
    const PanelColumns rows(solved_panel(p), kPanelRows, m);
    for (Index k = kPanelRows * p; k < m; ++k) sum += rows.col(k).cwiseAbs2();
    const Index count = std::min<Index>(kPanelRows, m - kPanelRows * p);
    inverse_diagonal_.segment(kPanelRows * p, count) = sum.head(count);
  }
  return inverse_diagonal_;
}

void PanelCholesky::sums(Vector& squares, Vector& product) const {
  squares.resize(kPanelRows * panels_of(rows_));
  product.resize(squares.size());
  kernel_->sums({.W = solved_panels(),
                 .rows = rows_,
                 .panel_stride = solved_panel_stride(),
                 .columns = columns_,
                 .y = whitened_.data(),
                 .squares = squares.data(),
                 .product = product.data()});
}

void PanelCholesky::add_correction(Eigen::Ref<Vector> x) const {
  if (x.size() != rows_) throw std::invalid_argument("PanelCholesky: x does not match W");
  for (Index row = 0; row < rows_; row += kPanelRows) {
    const PanelColumns W(solved_panel(row / kPanelRows), kPanelRows, columns_);
    Panel sum = Panel::Zero();
    for (Index k = 0; k < columns_; ++k) sum += whitened_[k] * W.col(k);
    const Index count = std::min<Index>(kPanelRows, rows_ - row);
    x.segment(row, count) += sum.head(count);
  }
}

void PanelCholesky::downdate_columns(Eigen::Ref<Matrix> P) {
  if (P.rows() != rows_ || P.cols() > rows_) {
    throw std::invalid_argument("PanelCholesky: P does not match W");
  }
  const Index depth = kPanelRows * triangle_;
  fill_up(triangle_, depth);
  const auto panels = static_cast<std::size_t>(panels_of(P.cols()) * kPanelRows * depth);
  if (minus_.size() < panels) minus_.resize(panels);
  std::transform(solved_panel(0), solved_panel(0) + panels, minus_.data(), [](double w) { return -w; });
  product_->multiply({.A = solved_panel(0),
                      .B = minus_.data(),
                      .rows = rows_,
                      .columns = P.cols(),
                      .depth = depth,
                      .C = P.data(),
                      .stride = P.outerStride(),
                      .add = true,
                      .lower = false});
}

}  // namespace credence::internal
