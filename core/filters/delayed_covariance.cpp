#include "core/filters/delayed_covariance.h"

#include <algorithm>
#include <stdexcept>

#include "core/linear_algebra/mirror.h"

namespace credence::internal {
namespace {

/// Entries `stride` apart, `count` of them, of rows that stand side by side, into as many columns.
template <int kColumns>
void copy_rows(const double* from, Index stride, Index count, double* to, Index to_stride) {
  for (Index i = 0; i < count; ++i, from += stride) {
    for (int c = 0; c < kColumns; ++c) to[c * to_stride + i] = from[c];
  }
}

}  // namespace

void DelayedCovariance::set(const MatrixRef& P) {
  P_ = P;
  waiting_.resize(static_cast<std::size_t>(panels_of(size()) * kWaitingStride));
  waiting_columns_ = 0;
  columns_.setZero(whole_panels(size()), vehicle_);
  variances_.setZero(whole_panels(size()));
  take_vehicle();
  is_whole_ = true;
}

void DelayedCovariance::take_vehicle() {
  const Index n = size();
  for (Index c = 0; c < vehicle_; ++c) std::copy_n(P_.col(c).data(), n, columns_.col(c).data());
  variances_.head(n) = P_.diagonal();
}

void DelayedCovariance::put_vehicle() const {
  for (Index c = 0; c < vehicle_; ++c) std::copy_n(columns_.col(c).data(), size(), P_.col(c).data());
}

void DelayedCovariance::vehicle_changed() {
  variances_.head(vehicle_) = columns_.diagonal();
  is_whole_ = false;
}

double DelayedCovariance::trace() const {
  double sum = 0.0;
  for (Index i = 0; i < size(); ++i) sum += variances_[i];
  return sum;
}

void DelayedCovariance::copy_columns(Index first, Index count, Eigen::Map<Matrix> to) const {
  const Index n = size(), rows = to.rows();
  for (Index c = 0; c < count;) {
    const Index at = first + c;
    double* column = to.data() + c * rows;
    const auto take = [&]<int kColumns>() {
      copy_rows<kColumns>(columns_.data() + at, columns_.rows(), vehicle_, column, rows);
      copy_rows<kColumns>(P_.data() + vehicle_ * n + at, n, at - vehicle_, column + vehicle_, rows);
      return kColumns;
    };
    c += count - c >= 2 ? take.template operator()<2>() : take.template operator()<1>();
  }
  for (Index c = 0; c < count; ++c) {
    const Index at = first + c;
    double* column = to.data() + c * rows;
    if (c % 2 == 1) column[at - 1] = P_(at, at - 1);
    std::copy_n(P_.col(at).data() + at, n - at, column + at);
    std::fill(column + n, column + rows, 0.0);
  }
  if (waiting_columns_ == 0) return;
  kernel_->subtract({.y = to.data(),
                     .rows = n,
                     .W = waiting_.data(),
                     .panel_stride = kWaitingStride,
                     .columns = waiting_columns_,
                     .count = count,
                     .y_stride = rows},
                    first);
}

void DelayedCovariance::downdate(const PanelCholesky& factor) {
  const Index n = size(), m = factor.size(), from = factor.solved_panel_stride();
  const double* W = factor.solved_panels();
  if (factor.rows() != n) throw std::invalid_argument("DelayedCovariance: the factor is of other states");
  if (m >= kMostWaiting) {
    put_vehicle();
    pass();
    pass(W, from, m);
    take_vehicle();
    is_whole_ = false;
    return;
  }
  is_whole_ = false;
  PanelProduct product{.y = variances_.data(), .rows = n, .W = W, .panel_stride = from, .columns = m};
  kernel_->subtract_squares(product);
  product.y = columns_.data();
  product.count = vehicle_;
  product.y_stride = columns_.rows();
  kernel_->subtract(product, 0);
  double* waiting = waiting_.data() + kPanelRows * waiting_columns_;
  using Panel = Eigen::Matrix<double, kPanelRows, Eigen::Dynamic>;
  for (Index p = 0; p < panels_of(n); ++p)
    Eigen::Map<Panel>(waiting + p * kWaitingStride, kPanelRows, m) =
        Eigen::Map<const Panel>(W + p * from, kPanelRows, m);
  const auto clear = [&](Index row) {
    double* at = waiting + row / kPanelRows * kWaitingStride + row % kPanelRows;
    for (Index k = 0; k < m; ++k) at[kPanelRows * k] = 0.0;
  };
  for (Index row = 0; row < vehicle_; ++row) clear(row);
  for (Index row = n; row < whole_panels(n); ++row) clear(row);
  waiting_columns_ += m;
  if (waiting_columns_ >= kMostWaiting) pass();
}

void DelayedCovariance::append(const MatrixRef& cross, const MatrixRef& own) {
  const Index n = size(), l = own.rows(), rows = whole_panels(n + l);
  P_.conservativeResize(n + l, n + l);
  P_.bottomLeftCorner(l, n) = cross;
  P_.bottomRightCorner(l, l) = own;
  columns_.conservativeResize(rows, vehicle_);
  columns_.middleRows(n, l) = cross.leftCols(vehicle_);
  columns_.bottomRows(rows - n - l).setZero();
  variances_.conservativeResize(rows);
  variances_.segment(n, l) = own.diagonal();
  variances_.tail(rows - n - l).setZero();
  waiting_.resize(static_cast<std::size_t>(panels_of(n + l) * kWaitingStride));
  is_whole_ = false;
}

const Matrix& DelayedCovariance::whole() const {
  if (is_whole_) return P_;
  lower();
  mirror_lower(P_);
  is_whole_ = true;
  return P_;
}

const Matrix& DelayedCovariance::lower() const {
  if (is_whole_) return P_;
  pass();
  put_vehicle();
  return P_;
}

void DelayedCovariance::pass() const {
  if (waiting_columns_ > 0) pass(waiting_.data(), kWaitingStride, waiting_columns_);
  waiting_columns_ = 0;
}

void DelayedCovariance::pass(const double* W, Index panel_stride, Index columns) const {
  kernel_->downdate({.P = P_.data(),
                     .rows = size(),
                     .stride = size(),
                     .W = W,
                     .panel_stride = panel_stride,
                     .columns = columns});
}

}  // namespace credence::internal
