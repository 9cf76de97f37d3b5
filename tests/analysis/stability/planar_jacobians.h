#pragma once

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "core/record/block_layout.h"
#include "core/types.h"

namespace credence::internal::testing {

/// Jacobians of planar range-bearing SLAM along a loop, written out from the model of theory, section 2.
///
/// x = (x, y, θ, l_1x, l_1y, …); a unicycle drives a circle; every landmark and anchor is seen at every step.
/// With `disturbance` > 0 each Jacobian is taken at a point that is off by so much (m, rad): an EKF's.
struct PlanarLoop {
  BlockLayout layout;
  Vector start;                 ///< the state at step 0
  std::vector<Matrix> F, G, H;  ///< G: noise of speed and turn rate

  PlanarLoop(Index landmarks, const Matrix& anchors, int steps, double disturbance = 0.0) {
    layout = {.vehicle = 3, .landmark = 2, .landmarks = landmarks};
    start = Vector::Zero(layout.state_dim());
    start.head(3) << 10.0, 0.0, 0.5 * std::numbers::pi;
    for (Index i = 0; i < landmarks; ++i) {
      const double angle = 2.4 * static_cast<double>(i);
      const double radius = 6.0 + 3.0 * static_cast<double>(i % 3);
      start.segment(layout.landmark_offset(i), 2) << radius * std::cos(angle), radius * std::sin(angle);
    }
    std::mt19937_64 generator(1);
    std::normal_distribution<double> normal(0.0, 1.0);
    Vector x = start;
    const double speed = 1.0, turn_rate = 0.1, dt = 1.0;
    for (int k = 0; k < steps; ++k) {
      Vector at = x;
      for (double& entry : at) entry += disturbance * normal(generator);
      H.push_back(measurement_jacobian(at, anchors));
      F.push_back(Matrix::Identity(layout.state_dim(), layout.state_dim()));
      F.back()(0, 2) = -speed * dt * std::sin(at[2]);
      F.back()(1, 2) = speed * dt * std::cos(at[2]);
      G.push_back(Matrix::Zero(layout.state_dim(), 2));
      G.back().topRows(3) << dt * std::cos(at[2]), 0.0, dt * std::sin(at[2]), 0.0, 0.0, dt;
      x[0] += speed * dt * std::cos(x[2]);
      x[1] += speed * dt * std::sin(x[2]);
      x[2] += turn_rate * dt;
    }
  }

 private:
  Matrix measurement_jacobian(const Vector& x, const Matrix& anchors) const {
    const Index N = layout.landmarks;
    Matrix H_k = Matrix::Zero(2 * (N + anchors.cols()), layout.state_dim());
    for (Index i = 0; i < N + anchors.cols(); ++i) {
      const Index offset = layout.landmark_offset(i);
      const Eigen::Vector2d landmark =
          i < N ? Eigen::Vector2d(x.segment(offset, 2)) : Eigen::Vector2d(anchors.col(i - N));
      const Eigen::Vector2d to = landmark - x.head(2);
      const double range = to.norm();
      Eigen::Matrix2d by_landmark;
      by_landmark << to.x() / range, to.y() / range, -to.y() / (range * range), to.x() / (range * range);
      H_k.block(2 * i, 0, 2, 2) = -by_landmark;
      H_k(2 * i + 1, 2) = -1.0;
      if (i < N) H_k.block(2 * i, offset, 2, 2) = by_landmark;
    }
    return H_k;
  }
};

}  // namespace credence::internal::testing
