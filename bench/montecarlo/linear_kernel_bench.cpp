// One step of one run of the monobot, noise, NEES and NIS included: the lanes of LinearSimulator beside the
// plain loop that a textbook would give, with the random numbers of the standard library. Items are steps.

#include "montecarlo/linear_kernel.h"

#include <benchmark/benchmark.h>

#include <Eigen/Dense>
#include <random>
#include <vector>

#include "core/linear_filter.h"
#include "core/psd_root.h"

namespace credence {
namespace {

constexpr Index kSteps = 100;

LinearErrorSystem monobot(Index landmarks) {
  const LinearModel model = monobot_model(landmarks, 0, 0.1, 0.1, 1.0);
  LinearErrorSystem system{.F = model.F,
                           .noise_input = model.G * psd_root(model.Q),
                           .H = model.H,
                           .measurement_root = psd_root(model.R),
                           .initial_root = psd_root(model.P0),
                           .steps = {}};
  for (const LinearFilterStep& step : linear_filter_steps(model, {}, kSteps)) {
    system.steps.push_back({.K = step.K,
                            .innovation_whitening = psd_whitening(step.S),
                            .error_whitening = psd_whitening(step.P)});
  }
  return system;
}

/// The argument is N.
void lanes(benchmark::State& state, InstructionSet set) {
  if (!is_supported(set)) return state.SkipWithError("not supported by this machine");
  const Index runs = state.range(0) > 20 ? 64 : 512;
  const LinearSimulator simulator(monobot(state.range(0)));
  const NoiseSource noise(1, 0, set);
  std::vector<Moments> nees(kSteps), nis(kSteps);
  Index first_run = 0;
  for (auto _ : state) {
    simulator.simulate(noise, first_run, runs, nees, nis);
    benchmark::DoNotOptimize(nees.data());
    first_run += runs;
  }
  state.SetItemsProcessed(state.iterations() * runs * kSteps);
}
BENCHMARK_CAPTURE(lanes, scalar, InstructionSet::scalar)->Arg(1);
BENCHMARK_CAPTURE(lanes, avx2, InstructionSet::avx2)->Arg(1)->Arg(2)->Arg(5)->Arg(20)->Arg(100);
BENCHMARK_CAPTURE(lanes, avx512, InstructionSet::avx512)->Arg(1)->Arg(2)->Arg(5)->Arg(20)->Arg(100);

/// Only the noise of the same steps: one process noise and N measurements.
void noise_alone(benchmark::State& state, InstructionSet set) {
  if (!is_supported(set)) return state.SkipWithError("not supported by this machine");
  const Index slots = state.range(0) + 1;
  const NoiseSource noise(1, 0, set);
  constexpr Index kBlock = 20;
  std::vector<double> out(static_cast<std::size_t>(slots * kBlock * NoiseSource::kLanes));
  Index step = 1;
  for (auto _ : state) {
    noise.normals_of_runs(0, step, kBlock, NoisePurpose::measurement, slots, out);
    benchmark::DoNotOptimize(out.data());
    benchmark::ClobberMemory();
    step = (step + kBlock) % (1 << 20);
  }
  state.SetItemsProcessed(state.iterations() * kBlock * NoiseSource::kLanes);
}
BENCHMARK_CAPTURE(noise_alone, avx2, InstructionSet::avx2)->Arg(1)->Arg(2)->Arg(20);
BENCHMARK_CAPTURE(noise_alone, avx512, InstructionSet::avx512)->Arg(1)->Arg(2)->Arg(20);

/// The textbook: a Kalman filter with fixed sizes in every run (paper eqs (3)-(10), Joseph form), its NEES
/// and NIS by Cholesky solves.
template <int kLandmarks>
void plain_loop(benchmark::State& state) {
  constexpr int n = kLandmarks + 1, m = kLandmarks;
  using State = Eigen::Matrix<double, n, 1>;
  using Covariance = Eigen::Matrix<double, n, n>;
  using Measurement = Eigen::Matrix<double, m, 1>;
  const double q = 0.1, r = 0.1;
  Eigen::Matrix<double, m, n> H = Eigen::Matrix<double, m, n>::Zero();
  H.col(0).setConstant(-1.0);
  H.template rightCols<m>().setIdentity();
  const Eigen::Matrix<double, m, m> R = r * Eigen::Matrix<double, m, m>::Identity();
  std::mt19937_64 generator(1);
  std::normal_distribution<double> normal;
  std::vector<Moments> nees(kSteps), nis(kSteps);
  for (auto _ : state) {
    State x = State::Ones(), estimate = x;
    x[0] = -1.0;
    for (int i = 0; i < n; ++i) estimate[i] = x[i] - normal(generator);
    Covariance P = Covariance::Identity();
    for (std::size_t k = 0; k < kSteps; ++k) {
      x[0] += std::sqrt(q) * normal(generator);
      Measurement z = H * x;
      for (int i = 0; i < m; ++i) z[i] += std::sqrt(r) * normal(generator);
      P(0, 0) += q;
      const Measurement nu = z - H * estimate;
      const Eigen::Matrix<double, m, m> S = H * P * H.transpose() + R;
      const Eigen::LLT<Eigen::Matrix<double, m, m>> llt(S);
      const Eigen::Matrix<double, n, m> K = llt.solve(H * P).transpose();
      estimate += K * nu;
      const Covariance A = Covariance::Identity() - K * H;
      P = A * P * A.transpose() + K * R * K.transpose();
      const State e = x - estimate;
      nees[k].add(e.dot(P.llt().solve(e)));
      nis[k].add(nu.dot(llt.solve(nu)));
    }
    benchmark::DoNotOptimize(nees.data());
    benchmark::DoNotOptimize(nis.data());
  }
  state.SetItemsProcessed(state.iterations() * kSteps);
}
BENCHMARK(plain_loop<1>);
BENCHMARK(plain_loop<2>);
BENCHMARK(plain_loop<5>);

}  // namespace
}  // namespace credence
