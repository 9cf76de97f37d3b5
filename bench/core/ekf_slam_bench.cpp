// One step (predict and update) of EKF-SLAM.

#include "core/filters/ekf_slam.h"

#include <benchmark/benchmark.h>

#include <numbers>
#include <vector>

namespace credence::internal {
namespace {

/// A filter that has seen all landmarks on a ring around it.
EkfSlam<PlanarModel> planar_filter(Index landmarks, Inflation inflation) {
  const Eigen::Matrix2d Q = Eigen::Vector2d(0.01, 0.0025).asDiagonal();
  const Eigen::Matrix2d R = Eigen::Vector2d(0.01, 0.0003).asDiagonal();
  InflationRule rule;
  rule.inflation = inflation;
  EkfSlam<PlanarModel> filter({.vehicle = {}, .dt_s = 0.1}, Q, R, rule);
  filter.reset(Pose::Zero(), 0.01 * Eigen::Matrix3d::Identity());
  std::vector<Observation<PlanarModel>> all;
  for (Index i = 0; i < landmarks; ++i) {
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(landmarks);
    all.push_back({static_cast<int>(i), RangeBearing(10.0, wrap_angle(angle))});
  }
  filter.update(all);
  return filter;
}

/// The argument is N; one landmark is observed at each step.
void planar_step(benchmark::State& state, Inflation inflation) {
  const auto landmarks = static_cast<int>(state.range(0));
  const EkfSlam<PlanarModel> start = planar_filter(landmarks, inflation);
  EkfSlam<PlanarModel> filter = start;
  int k = 0;
  for (auto _ : state) {
    filter.predict({0.0, 0.0});
    const int id = k % landmarks;
    const Index offset = filter.offset_of(id);
    const Observation<PlanarModel> z{id,
                                     measure_range_bearing(filter.pose(), filter.state().segment<2>(offset))};
    benchmark::DoNotOptimize(filter.update({&z, 1}));
    ++k;
  }
  state.SetItemsProcessed(state.iterations());
}

BENCHMARK_CAPTURE(planar_step, none, Inflation::none)->Arg(10)->Arg(100);
BENCHMARK_CAPTURE(planar_step, map_pairwise, Inflation::map)->Arg(10)->Arg(100);

void monobot_step(benchmark::State& state) {
  using Scalar = MonobotModel::Scalar;
  const auto n = static_cast<int>(state.range(0));
  EkfSlam<MonobotModel> filter({}, Scalar(0.1), Scalar(0.1));
  std::vector<int> ids;
  std::vector<Observation<MonobotModel>> z;
  for (int i = 0; i < n; ++i) {
    ids.push_back(i);
    z.push_back({i, Scalar(0.0)});
  }
  filter.reset(Vector::Zero(n + 1), Matrix::Identity(n + 1, n + 1), ids);
  for (auto _ : state) {
    filter.predict(Scalar(0.0));
    benchmark::DoNotOptimize(filter.update(z));
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(monobot_step)->Arg(1)->Arg(2)->Arg(10);

}  // namespace
}  // namespace credence::internal
