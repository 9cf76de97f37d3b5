#pragma once

#include <vector>

#include "core/types.h"

namespace credence {

/// The Jacobian H of a batch of observations, each of one landmark: a block on the vehicle and one on the
/// landmark, the rest is zero. Keeps its memory when cleared.
class ObservationBatch {
 public:
  /// Empties the batch; each observation will have `measurements` rows, the vehicle `vehicle` and a landmark
  /// `landmark` states.
  void clear(Index vehicle, Index landmark, Index measurements) {
    vehicle_ = vehicle;
    landmark_ = landmark;
    measurements_ = measurements;
    columns_.clear();
    H_.clear();
  }

  /// Adds an observation of the landmark that starts at state `column` of the map (0: the first landmark),
  /// or of one that is no state (−1). H_r is measurements × vehicle, H_l measurements × landmark.
  template <typename DerivedR, typename DerivedL>
  void add(Index column, const Eigen::MatrixBase<DerivedR>& H_r, const Eigen::MatrixBase<DerivedL>& H_l) {
    columns_.push_back(column);
    for (Index i = 0; i < measurements_; ++i) {
      for (Index j = 0; j < vehicle_; ++j) H_.push_back(H_r(i, j));
    }
    for (Index i = 0; i < measurements_; ++i) {
      for (Index j = 0; j < landmark_; ++j) H_.push_back(H_l(i, j));
    }
  }

  Index size() const { return static_cast<Index>(columns_.size()); }
  Index vehicle() const { return vehicle_; }
  Index landmark() const { return landmark_; }
  Index measurements() const { return measurements_; }
  Index rows() const { return measurements_ * size(); }  ///< of H
  Index column(Index o) const { return columns_[static_cast<std::size_t>(o)]; }
  /// Row-major blocks of observation `o`.
  const double* H_r(Index o) const { return H_.data() + o * measurements_ * (vehicle_ + landmark_); }
  const double* H_l(Index o) const { return H_r(o) + measurements_ * vehicle_; }

 private:
  Index vehicle_ = 0, landmark_ = 0, measurements_ = 0;
  std::vector<Index> columns_;
  std::vector<double> H_;
};

}  // namespace credence
