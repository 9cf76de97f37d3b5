#include <benchmark/benchmark.h>

#include <random>

#include "analysis/stability/riccati.h"
#include "analysis/stability/riccati_newton.h"
#include "bench/analysis/riccati_problems.h"
#include "core/models/linear_model.h"

namespace credence::internal {
namespace {

RiccatiProblem monobot_problem(Index landmarks, Index anchors) {
  const LinearModel model = monobot_model(landmarks, anchors, 0.1, 0.1, 1.0);
  return {model.F, model.H, model.G * model.Q * model.G.transpose(), model.R};
}

/// The whole solution with its certificate; the residual and the outcome are counters beside the time.
void solve(benchmark::State& state, const RiccatiProblem& problem, bool eigenvalues) {
  const Matrix P0 = Matrix::Identity(problem.state_dim(), problem.state_dim());
  RiccatiSolution solution;
  for (auto _ : state) {
    solution = solve_riccati(problem, P0, {.closed_loop_eigenvalues = eigenvalues});
    benchmark::DoNotOptimize(solution.P.data());
  }
  state.counters["residual"] = solution.residual;
  state.counters["kind"] = static_cast<double>(solution.kind);
  state.SetItemsProcessed(state.iterations());
  state.SetComplexityN(state.range(0));
}

void BM_RiccatiRegular(benchmark::State& state) { solve(state, random_problem(state.range(0)), false); }

void BM_RiccatiRegularWithEigenvalues(benchmark::State& state) {
  solve(state, random_problem(state.range(0)), true);
}

void BM_RiccatiMarginalMonobot(benchmark::State& state) {
  solve(state, monobot_problem(state.range(0) - 1, 0), false);
}

/// One doubling once Γ has the rank n, the fourth: 14 n³ operations, the unit in which the solution's cost is
/// counted.
void BM_RiccatiDoubling(benchmark::State& state) {
  const RiccatiProblem problem = random_problem(state.range(0));
  RiccatiMap start(problem);
  for (int k = 0; k < 3; ++k) start.square();
  RiccatiMap map = start;
  for (auto _ : state) {
    state.PauseTiming();
    map = start;
    state.ResumeTiming();
    benchmark::DoNotOptimize(map.square());
  }
  const double n = static_cast<double>(state.range(0));
  state.counters["flops"] =
      benchmark::Counter(14.0 * n * n * n, benchmark::Counter::kIsIterationInvariantRate);
}

/// A product of two n×n matrices, 2 n³ operations: ours, and below it Eigen's.
void BM_MatrixProduct(benchmark::State& state) {
  std::mt19937_64 generator(1);
  const Matrix A = random_matrix(state.range(0), state.range(0), generator);
  const Matrix B = random_matrix(state.range(0), state.range(0), generator);
  Matrix C;
  MatrixProduct multiply;
  for (auto _ : state) {
    multiply.set(C, A, B);
    benchmark::DoNotOptimize(C.data());
  }
  const double n = static_cast<double>(state.range(0));
  state.counters["flops"] =
      benchmark::Counter(2.0 * n * n * n, benchmark::Counter::kIsIterationInvariantRate);
}

void BM_MatrixProductEigen(benchmark::State& state) {
  std::mt19937_64 generator(1);
  const Matrix A = random_matrix(state.range(0), state.range(0), generator);
  const Matrix B = random_matrix(state.range(0), state.range(0), generator);
  Matrix C(state.range(0), state.range(0));
  for (auto _ : state) {
    C.noalias() = A * B;
    benchmark::DoNotOptimize(C.data());
  }
  const double n = static_cast<double>(state.range(0));
  state.counters["flops"] =
      benchmark::Counter(2.0 * n * n * n, benchmark::Counter::kIsIterationInvariantRate);
}

BENCHMARK(BM_RiccatiRegular)
    ->Arg(10)
    ->Arg(50)
    ->Arg(100)
    ->Arg(200)
    ->Unit(benchmark::kMicrosecond)
    ->Complexity();
BENCHMARK(BM_RiccatiRegularWithEigenvalues)
    ->Arg(10)
    ->Arg(50)
    ->Arg(100)
    ->Arg(200)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK(BM_RiccatiMarginalMonobot)->Arg(10)->Arg(50)->Arg(100)->Arg(200)->Unit(benchmark::kMicrosecond);
BENCHMARK(BM_RiccatiDoubling)->Arg(10)->Arg(50)->Arg(100)->Arg(200)->Unit(benchmark::kMicrosecond);
BENCHMARK(BM_MatrixProduct)->Arg(10)->Arg(50)->Arg(100)->Arg(200)->Unit(benchmark::kMicrosecond);
BENCHMARK(BM_MatrixProductEigen)->Arg(10)->Arg(50)->Arg(100)->Arg(200)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace credence::internal
