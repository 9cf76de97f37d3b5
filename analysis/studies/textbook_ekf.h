#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "core/filters/ekf_slam.h"

namespace credence::internal {

/// EKF-SLAM in the plane as a textbook states it, of a map that is known from the start: dense products of
/// Eigen, Joseph's form. What a fast filter is timed against.
class TextbookEkf {
 public:
  TextbookEkf(const PlanarModel& model, const Eigen::Matrix2d& Q, const Eigen::Matrix2d& R);

  void reset(VectorRef x, MatrixRef P, std::span<const int> ids);
  void predict(const Control& u);
  UpdateResult update(std::span<const Observation<PlanarModel>> observations);

  const Vector& state() const { return x_; }
  const Matrix& covariance() const { return P_; }
  Pose pose() const { return x_.head<3>(); }
  Index offset_of(int id) const { return 3 + 2 * (std::ranges::find(ids_, id) - ids_.begin()); }

 private:
  PlanarModel model_;
  Eigen::Matrix2d Q_, R_;
  Vector x_;
  Matrix P_;
  std::vector<int> ids_;
};

}  // namespace credence::internal
