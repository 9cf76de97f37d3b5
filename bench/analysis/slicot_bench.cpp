// SLICOT's solvers of the same discrete Riccati equation, where Debian's libslicot-dev is installed, with the
// BLAS that is installed: SB02OD by the Schur form of a pencil, SB02MD by that of the symplectic matrix,
// which needs F⁻¹.

#ifdef CREDENCE_HAS_SLICOT

#include <benchmark/benchmark.h>

#include <vector>

#include "bench/analysis/riccati_problems.h"

// The Fortran interface: every argument by address, the lengths of the characters at the end.
extern "C" void sb02od_(const char* dico, const char* jobb, const char* fact, const char* uplo,
                        const char* jobl, const char* sort, const int* n, const int* m, const int* p,
                        const double* a, const int* lda, const double* b, const int* ldb, const double* q,
                        const int* ldq, const double* r, const int* ldr, const double* l, const int* ldl,
                        double* rcond, double* x, const int* ldx, double* alfar, double* alfai, double* beta,
                        double* s, const int* lds, double* t, const int* ldt, double* u, const int* ldu,
                        const double* tol, int* iwork, double* dwork, const int* ldwork, int* bwork,
                        int* info, std::size_t, std::size_t, std::size_t, std::size_t, std::size_t,
                        std::size_t);
extern "C" void sb02md_(const char* dico, const char* hinv, const char* uplo, const char* scal,
                        const char* sort, const int* n, double* a, const int* lda, double* g, const int* ldg,
                        double* q, const int* ldq, double* rcond, double* wr, double* wi, double* s,
                        const int* lds, double* u, const int* ldu, int* iwork, double* dwork,
                        const int* ldwork, int* bwork, int* info, std::size_t, std::size_t, std::size_t,
                        std::size_t, std::size_t);

namespace credence::internal {
namespace {

/// The control equation of A = Fᵀ, B = Hᵀ has the filter's solution.
struct SlicotSolver {
  explicit SlicotSolver(const RiccatiProblem& problem)
      : n(static_cast<int>(problem.F.rows())),
        m(static_cast<int>(problem.H.rows())),
        A(problem.F.transpose()),
        B(problem.H.transpose()),
        Q(problem.Qt),
        R(problem.R),
        X(n, n),
        S(2 * n + m, 2 * n + m),
        T(2 * n + m, 2 * n),
        U(2 * n, 2 * n),
        alphas(static_cast<std::size_t>(6 * n)),
        work(static_cast<std::size_t>(std::max({7 * (2 * n + 1) + 16, 16 * n, 2 * n + m, 3 * m}) + 64 * n)),
        integers(static_cast<std::size_t>(std::max(m, 2 * n))),
        booleans(static_cast<std::size_t>(2 * n)) {}

  int solve() {
    const int n2 = 2 * n, lds = 2 * n + m, p = 0, workspace = static_cast<int>(work.size());
    const double tolerance = 0.0;
    double rcond = 0.0;
    int info = 0;
    sb02od_("D", "B", "N", "U", "Z", "S", &n, &m, &p, A.data(), &n, B.data(), &n, Q.data(), &n, R.data(), &m,
            nullptr, &n, &rcond, X.data(), &n, alphas.data(), alphas.data() + n2, alphas.data() + 2 * n2,
            S.data(), &lds, T.data(), &lds, U.data(), &n2, &tolerance, integers.data(), work.data(),
            &workspace, booleans.data(), &info, 1, 1, 1, 1, 1, 1);
    return info;
  }

  /// The solution replaces Q, and A is inverted in place, so that each call has copies of its own. The matrix
  /// is the one with F⁻¹ (HINV = "D"), whose unstable subspace (SORT = "U") has the stabilising solution.
  int solve_symplectic() {
    const int n2 = 2 * n, workspace = static_cast<int>(work.size());
    Matrix inverse = A, G = B * R.llt().solve(B.transpose());
    X = Q;
    double rcond = 0.0;
    int info = 0;
    sb02md_("D", "D", "U", "N", "U", &n, inverse.data(), &n, G.data(), &n, X.data(), &n, &rcond,
            alphas.data(), alphas.data() + n2, S.data(), &n2, U.data(), &n2, integers.data(), work.data(),
            &workspace, booleans.data(), &info, 1, 1, 1, 1, 1);
    return info;
  }

  int n, m;
  Matrix A, B, Q, R, X, S, T, U;
  std::vector<double> alphas, work;
  std::vector<int> integers, booleans;
};

void solve(benchmark::State& state, int (SlicotSolver::*method)()) {
  const RiccatiProblem problem = random_problem(state.range(0));
  SlicotSolver slicot(problem);
  for (auto _ : state) {
    if ((slicot.*method)() != 0) return state.SkipWithError("SLICOT failed");
    benchmark::DoNotOptimize(slicot.X.data());
  }
  const RiccatiSolution ours =
      solve_riccati(problem, Matrix::Identity(slicot.n, slicot.n), {.closed_loop_eigenvalues = false});
  state.counters["difference"] = (slicot.X - ours.P).norm() / ours.P.norm();
}

void BM_RiccatiSlicot(benchmark::State& state) { solve(state, &SlicotSolver::solve); }

void BM_RiccatiSlicotSymplectic(benchmark::State& state) { solve(state, &SlicotSolver::solve_symplectic); }

BENCHMARK(BM_RiccatiSlicot)->Arg(50)->Arg(100)->Arg(200)->Unit(benchmark::kMicrosecond);
BENCHMARK(BM_RiccatiSlicotSymplectic)->Arg(50)->Arg(100)->Arg(200)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace credence::internal

#endif
