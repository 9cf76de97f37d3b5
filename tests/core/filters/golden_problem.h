#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "core/filters/ekf_slam.h"

namespace credence::internal {

/// The deterministic EKF-SLAM step problem on which seven independent public implementations agree to nine
/// digits: bicycle with V = 3 m/s, γ = 0.1 rad, B = 4 m, dt = 0.025 s.
class GoldenProblem {
 public:
  explicit GoldenProblem(int landmarks) {
    Vehicle vehicle{VehicleKind::bicycle, {}};
    vehicle.geometry.wheel_base = 4.0;
    model_ = {.vehicle = vehicle, .dt_s = 0.025};
    for (int i = 0; i < landmarks; ++i) {
      const double r = 10.0 + 20.0 * fraction(0.6180339887 * i);
      const double a = 2.0 * std::numbers::pi * fraction(0.3819660113 * i);
      landmarks_.emplace_back(r * std::cos(a), r * std::sin(a));
    }
  }

  /// `rule_or_options` is the fourth argument of the filter's constructor.
  template <class Filter, class... Options>
  Filter make_filter(const Options&... rule_or_options) const {
    const Eigen::Matrix2d Q = Eigen::Vector2d(0.3 * 0.3, std::pow(3.0 * kRadiansPerDegree, 2)).asDiagonal();
    const Eigen::Matrix2d R = Eigen::Vector2d(0.1 * 0.1, std::pow(kRadiansPerDegree, 2)).asDiagonal();
    Filter filter(model_, Q, R, rule_or_options...);
    const Index n = 3 + 2 * static_cast<Index>(landmarks_.size());
    Vector x = Vector::Zero(n);
    std::vector<int> ids;
    for (std::size_t i = 0; i < landmarks_.size(); ++i) {
      x.segment<2>(3 + 2 * static_cast<Index>(i)) = landmarks_[i];
      ids.push_back(static_cast<int>(i));
    }
    Matrix B(n, 8);
    for (Index i = 0; i < n; ++i) {
      for (Index j = 0; j < 8; ++j) {
        const auto a = static_cast<double>(i), b = static_cast<double>(j);
        B(i, j) = std::sin(1.0 + 0.7 * a + 1.3 * b + 0.37 * a * b);
      }
    }
    filter.reset(x, 0.01 * Matrix::Identity(n, n) + 0.0025 * B * B.transpose(), ids);
    return filter;
  }

  template <class Filter>
  void step(Filter& filter, int k, int m) {
    truth_ = model_.vehicle.moved(truth_, kControl, model_.dt_s);
    filter.predict(kControl);
    std::vector<Observation<PlanarModel>> observations;
    for (int j = 0; j < m; ++j) {
      const int id = (k * m + j) % static_cast<int>(landmarks_.size());
      RangeBearing z = measure_range_bearing(truth_, landmarks_[static_cast<std::size_t>(id)]);
      z[0] += 0.1 * std::sin(k + j);
      z[1] = wrap_angle(z[1] + 0.017 * std::cos(1.3 * k + j));
      observations.push_back({id, z});
    }
    ASSERT_TRUE(filter.update(observations).ok);
  }

 private:
  static double fraction(double x) { return x - std::floor(x); }
  static inline const Control kControl{3.0, 0.1};

  PlanarModel model_;
  Pose truth_ = Pose::Zero();
  std::vector<Point> landmarks_;
};

/// What seven implementations have after ten steps with m landmarks each.
struct GoldenStep {
  int landmarks, m;
  double sum, trace;
};

inline constexpr GoldenStep kGoldenSteps[] = {{10, 1, 35.4217557, 0.221798597},
                                              {10, 10, 35.4241921, 0.106992477},
                                              {100, 1, 307.370102, 3.06177251},
                                              {100, 10, 307.353653, 1.54662081}};

}  // namespace credence::internal
