#include "core/filters/panel_covariance.h"
#include "core/simd/fused_multiply_add.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace credence {
namespace {

/// Columns of W that may wait at most: beyond, W leaves the second-level cache and reading a column of P_ff
/// costs more than the flush it saves.
constexpr Index kMostPending = 32;

Index panels_for(Index map_size) { return (map_size + kPanelRows - 1) / kPanelRows; }

std::size_t to_size(Index i) { return static_cast<std::size_t>(i); }

std::size_t packed_at(Index row, Index column) { return to_size(packed_index(row, column)); }

void require(bool ok, const char* what, Index value) {
  if (!ok) throw std::invalid_argument(std::string("PanelCovariance: ") + what + std::to_string(value));
}

}  // namespace

PanelCovariance::PanelCovariance(Index vehicle, Index landmark, int flush_steps, InstructionSet set)
    : kernel_(&panel_kernel(set)), vehicle_(vehicle), landmark_(landmark), flush_steps_(flush_steps) {
  require(vehicle >= 1, "the vehicle's dimension is ", vehicle);
  require(landmark >= 1, "a landmark's dimension is ", landmark);
  require(flush_steps >= 1, "the number of steps between flushes is ", flush_steps);
  reset(Matrix::Zero(vehicle, vehicle));
}

void PanelCovariance::reset(MatrixRef P) {
  require(P.rows() == P.cols(), "P is not square: its columns are ", P.cols());
  require(P.rows() >= vehicle_ && (P.rows() - vehicle_) % landmark_ == 0, "P has a wrong size: ", P.rows());
  for (AlignedVector* v : {&triangle_, &rows_, &diagonal_, &W_}) v->clear();
  map_size_ = panels_ = pending_ = steps_ = 0;
  columns_ = rows_of_columns_ = 0;
  resize_map(P.rows() - vehicle_);
  replace(P);
}

void PanelCovariance::replace(MatrixRef P) {
  require(P.rows() == size() && P.cols() == size(), "P has a wrong size: ", P.rows());
  pending_ = steps_ = 0;
  P_rr_ = P.topLeftCorner(vehicle_, vehicle_).selfadjointView<Eigen::Lower>();
  F_ = Matrix::Identity(vehicle_, vehicle_);
  moved_ = false;
  for (Index i = 0; i < map_size_; ++i) {
    const Index row = vehicle_ + i;
    for (Index r = 0; r < vehicle_; ++r) {
      rows_[to_size(kPanelRows * (vehicle_ * (i / kPanelRows) + r) + i % kPanelRows)] = P(row, r);
    }
    diagonal_[to_size(i)] = P(row, row);
    for (Index j = 0; j <= i; ++j) {
      triangle_[packed_at(i, j)] = P(row, vehicle_ + j);
      if (j / kPanelRows == i / kPanelRows) triangle_[packed_at(j, i)] = P(row, vehicle_ + j);
    }
  }
}

/// Enlarges the map; what is new is zero, also in the pending columns.
void PanelCovariance::resize_map(Index map_size) {
  const Index old_panels = panels_;
  map_size_ = map_size;
  panels_ = panels_for(map_size);
  if (panels_ == old_panels) return;
  triangle_.resize(to_size(panel_offset(panels_)));
  rows_.resize(to_size(kPanelRows * vehicle_ * panels_));
  diagonal_.resize(to_size(kPanelRows * panels_));
  W_.resize(to_size(stride() * panels_));
  new_rows_.resize(rows_.size());
  new_diagonal_.resize(diagonal_.size());
  change_.resize(diagonal_.size());
}

PanelStorage PanelCovariance::storage() {
  return {.panels = panels_,
          .vehicle = vehicle_,
          .landmark = landmark_,
          .P = triangle_.data(),
          .rows = rows_.data(),
          .diagonal = diagonal_.data(),
          .W = W_.data(),
          .stride = stride(),
          .pending = pending_};
}

double PanelCovariance::trace() const {
  return P_rr_.trace() + Eigen::Map<const Vector>(diagonal_.data(), map_size_).sum();
}

void PanelCovariance::predict(MatrixRef F, MatrixRef Q_r) {
  require(F.rows() == vehicle_ && F.cols() == vehicle_, "F has a wrong size: ", F.rows());
  require(Q_r.rows() == vehicle_ && Q_r.cols() == vehicle_, "Q_r has a wrong size: ", Q_r.rows());
  scratch_.noalias() = F.lazyProduct(P_rr_);
  for (Index r = 0; r < vehicle_; ++r) {
    for (Index s = 0; s <= r; ++s) {
      double x = Q_r(r, s);
      for (Index i = 0; i < vehicle_; ++i) x += scratch_(r, i) * F(s, i);
      P_rr_(r, s) = P_rr_(s, r) = x;
    }
  }
  scratch_.noalias() = F.lazyProduct(F_);
  F_.swap(scratch_);
  moved_ = true;
}

double PanelCovariance::vehicle_map(Index r, Index column) const {
  const double* x = rows_.data() + kPanelRows * vehicle_ * (column / kPanelRows) + column % kPanelRows;
  if (!moved_) return x[kPanelRows * r];
  double sum = 0.0;
  for (Index i = 0; i < vehicle_; ++i) sum += F_(r, i) * x[kPanelRows * i];
  return sum;
}

double PanelCovariance::map_element(Index row, Index column) const {
  if (column > row) std::swap(row, column);
  double x = triangle_[packed_at(row, column)];
  for (Index k = 0; k < pending_; ++k)
    x = fused_multiply_add(-W_[column_index(row, k)], W_[column_index(column, k)], x);
  return x;
}

double PanelCovariance::operator()(Index row, Index column) const {
  if (row < column) std::swap(row, column);
  if (row < vehicle_) return P_rr_(row, column);
  if (column < vehicle_) return vehicle_map(column, row - vehicle_);
  return map_element(row - vehicle_, column - vehicle_);
}

Matrix PanelCovariance::block(Index row, Index column, Index rows, Index columns) const {
  require(row >= 0 && rows >= 0 && row + rows <= size(), "a block has no such row: ", row);
  require(column >= 0 && columns >= 0 && column + columns <= size(), "a block has no such column: ", column);
  Matrix out(rows, columns);
  for (Index j = 0; j < columns; ++j) {
    for (Index i = 0; i < rows; ++i) out(i, j) = (*this)(row + i, column + j);
  }
  return out;
}

Matrix PanelCovariance::dense() const {
  PanelCovariance copy = *this;
  copy.flush();
  return copy.block(0, 0, size(), size());
}

/// Room for `columns` more in W, so that what waits is taken off first if it would become too much.
void PanelCovariance::make_room(Index columns) {
  if (pending_ > 0 && pending_ + columns > kMostPending) flush();
  const Index needed = pending_ + columns;
  if (needed <= capacity_) return;
  const Index old_stride = stride();
  const AlignedVector old = std::move(W_);
  capacity_ = std::max(needed, std::min(2 * capacity_, kMostPending));
  W_.assign(to_size(stride() * panels_), 0.0);
  for (Index p = 0; p < panels_ && pending_ > 0; ++p) {
    std::copy_n(old.data() + p * old_stride, kPanelRows * pending_, W_.data() + p * stride());
  }
}

/// The vehicle's rows of P Hᵀ.
void PanelCovariance::project_vehicle(const ObservationBatch& batch) {
  const Index q = batch.measurements();
  PHt_r_.resize(to_size(vehicle_ * batch.rows()));
  for (Index o = 0; o < batch.size(); ++o) {
    for (Index i = 0; i < q; ++i) {
      const double* H_r = batch.H_r(o) + i * vehicle_;
      const double* H_l = batch.H_l(o) + i * landmark_;
      for (Index r = 0; r < vehicle_; ++r) {
        double y = 0.0;
        for (Index s = 0; s < vehicle_; ++s) y += P_rr_(r, s) * H_r[s];
        for (Index a = 0; a < landmark_ && batch.column(o) >= 0; ++a) {
          y += vehicle_map(r, batch.column(o) + a) * H_l[a];
        }
        PHt_r_[to_size(r * batch.rows() + q * o + i)] = y;
      }
    }
  }
}

/// H (P Hᵀ) of what was just projected.
void PanelCovariance::innovation_covariance(const ObservationBatch& batch, Eigen::Ref<Matrix> HPHt) const {
  const Index q = batch.measurements();
  for (Index row = 0; row < columns_; ++row) {
    const Index o = row / q, i = row % q;
    for (Index j = 0; j <= row; ++j) {
      double sum = 0.0;
      for (Index r = 0; r < vehicle_; ++r) {
        sum += batch.H_r(o)[i * vehicle_ + r] * PHt_r_[to_size(r * columns_ + j)];
      }
      for (Index a = 0; a < landmark_ && batch.column(o) >= 0; ++a) {
        sum += batch.H_l(o)[i * landmark_ + a] * W_[column_index(batch.column(o) + a, first_column_ + j)];
      }
      HPHt(row, j) = HPHt(j, row) = sum;
    }
  }
}

void PanelCovariance::project(const ObservationBatch& batch, Eigen::Ref<Matrix> HPHt) {
  require(batch.vehicle() == vehicle_, "observations of a wrong vehicle: ", batch.vehicle());
  require(batch.landmark() == landmark_, "observations of a wrong landmark: ", batch.landmark());
  require(HPHt.rows() == batch.rows() && HPHt.cols() == batch.rows(), "S has a wrong size: ", HPHt.rows());
  for (Index o = 0; o < batch.size(); ++o) {
    const Index column = batch.column(o);
    require(column == -1 || (column >= 0 && column + landmark_ <= map_size_),
            "an observed landmark is not in the map: ", column);
  }
  make_room(batch.rows());
  project_vehicle(batch);

  // (P_fr Fᵀ) H_rᵀ = P_fr (H_r F)ᵀ
  const Index q = batch.measurements();
  H_r_.resize(to_size(batch.rows() * vehicle_));
  observations_.resize(to_size(batch.size()));
  for (Index o = 0; o < batch.size(); ++o) {
    double* H = H_r_.data() + o * q * vehicle_;
    for (Index i = 0; i < q; ++i) {
      for (Index s = 0; s < vehicle_; ++s) {
        double sum = 0.0;
        for (Index r = 0; r < vehicle_; ++r) sum += batch.H_r(o)[i * vehicle_ + r] * F_(r, s);
        H[i * vehicle_ + s] = sum;
      }
    }
    observations_[to_size(o)] = {batch.column(o), H, batch.H_l(o)};
  }
  first_column_ = pending_;
  columns_ = batch.rows();
  rows_of_columns_ = map_size_;
  kernel_->observe(storage(), observations_.data(), batch.size(), q);
  innovation_covariance(batch, HPHt);
}

/// The vehicle's rows of W; false if one of its variances would become negative.
bool PanelCovariance::whiten_vehicle(MatrixRef L, VectorRef whitened_innovation) {
  W_r_.resize(to_size(vehicle_ * columns_));
  change_r_.setZero(vehicle_);
  bool ok = true;
  for (Index r = 0; r < vehicle_; ++r) {
    double* w = W_r_.data() + r * columns_;
    double variance = P_rr_(r, r);
    for (Index k = 0; k < columns_; ++k) {
      double y = PHt_r_[to_size(r * columns_ + k)];
      for (Index j = 0; j < k; ++j) y -= L(k, j) * w[j];
      w[k] = y * inverse_[to_size(k)];
      change_r_[r] += w[k] * whitened_innovation[k];
      variance -= w[k] * w[k];
    }
    ok = ok && variance >= 0.0;
  }
  return ok;
}

bool PanelCovariance::whiten(MatrixRef L, VectorRef whitened_innovation) {
  require(L.rows() == columns_ && L.outerStride() == columns_, "L has a wrong size: ", L.rows());
  require(whitened_innovation.size() == columns_, "ν has a wrong size: ", whitened_innovation.size());
  inverse_.resize(to_size(columns_));
  for (Index k = 0; k < columns_; ++k) inverse_[to_size(k)] = 1.0 / L(k, k);
  F_row_major_.resize(to_size(vehicle_ * vehicle_));
  for (Index r = 0; r < vehicle_; ++r) {
    for (Index s = 0; s < vehicle_; ++s) F_row_major_[to_size(r * vehicle_ + s)] = F_(r, s);
  }
  const bool vehicle_ok = whiten_vehicle(L, whitened_innovation);
  const bool map_ok = kernel_->correct(storage(), {.columns = columns_,
                                                   .L = L.data(),
                                                   .inverse = inverse_.data(),
                                                   .whitened = whitened_innovation.data(),
                                                   .F = F_row_major_.data(),
                                                   .W_r = W_r_.data(),
                                                   .rows = new_rows_.data(),
                                                   .diagonal = new_diagonal_.data(),
                                                   .state_change = change_.data()});
  return vehicle_ok && map_ok;
}

void PanelCovariance::commit() {
  std::swap(rows_, new_rows_);
  std::swap(diagonal_, new_diagonal_);
  for (Index r = 0; r < vehicle_; ++r) {
    for (Index s = 0; s <= r; ++s) {
      double x = P_rr_(r, s);
      for (Index k = 0; k < columns_; ++k) {
        x -= W_r_[to_size(r * columns_ + k)] * W_r_[to_size(s * columns_ + k)];
      }
      P_rr_(r, s) = P_rr_(s, r) = x;
    }
  }
  F_.setIdentity();
  moved_ = false;
  pending_ += columns_;
  if (++steps_ >= flush_steps_) flush();
}

void PanelCovariance::add_state_change(Vector& x) const {
  x.head(vehicle_) += change_r_;
  x.tail(map_size_) += Eigen::Map<const Vector>(change_.data(), map_size_);
}

Matrix PanelCovariance::whitened_columns() const {
  Matrix out(vehicle_ + rows_of_columns_, columns_);
  for (Index k = 0; k < columns_; ++k) {
    for (Index r = 0; r < vehicle_; ++r) out(r, k) = W_r_[to_size(r * columns_ + k)];
    for (Index i = 0; i < rows_of_columns_; ++i) {
      out(vehicle_ + i, k) = W_[column_index(i, first_column_ + k)];
    }
  }
  return out;
}

void PanelCovariance::flush() {
  kernel_->downdate(triangle_.data(), panels_, W_.data(), stride(), pending_);
  pending_ = steps_ = 0;
}

/// Lets the vehicle's rows catch up with its motion.
void PanelCovariance::settle_motion() {
  if (!moved_) return;
  Vector x(vehicle_);
  for (Index i = 0; i < map_size_; ++i) {
    for (Index r = 0; r < vehicle_; ++r) x[r] = vehicle_map(r, i);
    for (Index r = 0; r < vehicle_; ++r) {
      rows_[to_size(kPanelRows * (vehicle_ * (i / kPanelRows) + r) + i % kPanelRows)] = x[r];
    }
  }
  F_.setIdentity();
  moved_ = false;
}

void PanelCovariance::append(MatrixRef J_r, MatrixRef own) {
  require(J_r.rows() == landmark_ && J_r.cols() == vehicle_, "J_r has a wrong size: ", J_r.rows());
  require(own.rows() == landmark_ && own.cols() == landmark_, "P_ll has a wrong size: ", own.rows());
  settle_motion();
  const Index old = map_size_;
  resize_map(old + landmark_);
  for (Index a = 0; a < landmark_; ++a) {
    const Index i = old + a;
    for (Index j = 0; j < old; ++j) {
      double x = 0.0;
      for (Index r = 0; r < vehicle_; ++r) x += J_r(a, r) * vehicle_map(r, j);
      triangle_[packed_at(i, j)] = x;
      if (j / kPanelRows == i / kPanelRows) triangle_[packed_at(j, i)] = x;
    }
    for (Index b = 0; b <= a; ++b) {
      triangle_[packed_at(i, old + b)] = own(a, b);
      if ((old + b) / kPanelRows == i / kPanelRows) triangle_[packed_at(old + b, i)] = own(a, b);
    }
    diagonal_[to_size(i)] = own(a, a);
    for (Index r = 0; r < vehicle_; ++r) {
      double x = 0.0;
      for (Index s = 0; s < vehicle_; ++s) x += J_r(a, s) * P_rr_(s, r);
      rows_[to_size(kPanelRows * (vehicle_ * (i / kPanelRows) + r) + i % kPanelRows)] = x;
    }
  }
}

}  // namespace credence
