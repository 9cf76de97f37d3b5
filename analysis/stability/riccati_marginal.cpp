#include "analysis/stability/riccati_marginal.h"

#include <fmt/format.h>

#include <limits>

#include "analysis/stability/dense_svd.h"
#include "analysis/stability/marginal_modes.h"
#include "analysis/stability/riccati_newton.h"
#include "core/linear_algebra/decompositions.h"
#include "core/number_text.h"

namespace credence::internal {
namespace {

constexpr int kMaxDoublings = 60;
constexpr int kMeasuredDoublings = 21;
constexpr Index kAlwaysGuarded = 64;  // states; above it the guard against rounding is used where it matters
constexpr double kAgreement = 1e-3;   // of the limit with P after 2^21 steps …
constexpr double kLearning = 100.0;   // … and over the steps, since static states are learnt as 1/k
constexpr double kHalved = 0.55;      // of a distance over twice the steps: 0.5 for 1/k, 1 from another limit
constexpr double kNearLimit = 0.1;    // of the limit, where that is asked
constexpr double kFixedPointLimit = 1e-8;  // a residual above it is no solution

/// A problem on the range of orthonormal columns that its covariance never leaves.
struct Restricted {
  Matrix basis;
  RiccatiProblem problem;
  Matrix P0;
};

Restricted restrict_to(const Matrix& basis, const RiccatiProblem& problem, const Matrix& P0) {
  Restricted part;
  part.basis = basis;
  part.problem = {basis.transpose() * problem.F * basis, problem.H * basis,
                  basis.transpose() * problem.Qt * basis, problem.R};
  part.P0 = basis.transpose() * P0 * basis;
  return part;
}

/// The states that the initial covariance or the noise ever reaches.
Restricted reachable_part(const RiccatiProblem& problem, const Matrix& P0) {
  const Matrix noise = psd_range(problem.Qt);
  const Matrix start = psd_range(P0);
  Matrix both(problem.state_dim(), noise.cols() + start.cols());
  both << noise, start;
  const Controllability reach = controllability(problem.F, both);
  const Index n = problem.state_dim();
  if (reach.decision.rank == n) return {Matrix::Identity(n, n), problem, P0};
  return restrict_to(reach.controllable, problem, P0);
}

/// The functionals that no noise touches and that measurements determine: learnt perfectly. Columns.
Matrix learnt_functionals(const MarginalModes& modes) {
  const Matrix& T = modes.untouched;
  if (T.cols() == 0 || modes.undetectable.cols() == 0) return T;
  const DenseSvd svd = dense_svd(T.transpose() * modes.undetectable, SvdVectors::full_left);
  const Index rank = (svd.s.array() > kPairingTolerance).count();
  return T * svd.U.rightCols(T.cols() - rank);
}

/// P0 given that Tᵀ x = 0 exactly, by projecting its square root: stays psd and may be singular.
Matrix conditioned(const Matrix& P0, const Matrix& T) {
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(P0);
  const Matrix root = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
  const DenseSvd svd = dense_svd(T.transpose() * root, SvdVectors::right);
  const Index rank = (svd.s.array() > 1e-12 * svd.s.maxCoeff()).count();
  const Matrix V = svd.V.leftCols(rank);
  const Matrix left = root - (root * V) * V.transpose();
  return left * left.transpose();
}

/// The problem with everything known that will be learnt perfectly.
Restricted deflated(const Restricted& part, const MarginalModes& modes) {
  const Matrix T = learnt_functionals(modes);
  if (T.cols() == 0) return {Matrix::Identity(part.basis.cols(), part.basis.cols()), part.problem, part.P0};
  const Index n = T.rows();
  const Eigen::HouseholderQR<Matrix> qr(T);
  const Matrix Q = orthonormal_columns(qr.householderQ(), n);
  return restrict_to(Q.rightCols(n - T.cols()), part.problem, conditioned(part.P0, T));
}

/// Doubles until P stands still. False when it never does.
bool double_to_limit(const Restricted& part, bool has_unstable_free_modes, Matrix& P) {
  Matrix start = part.P0;
  if (has_unstable_free_modes) {
    // Around a P that the measurements have already tamed; around zero A would grow without bound.
    for (int k = 0; k < 8; ++k) start = riccati_step(part.problem, start);
  }
  RiccatiMap map = has_unstable_free_modes ? RiccatiMap(part.problem, start) : RiccatiMap(part.problem);
  P = map.after(start);
  double last_change = std::numeric_limits<double>::infinity();
  while (map.doublings() < kMaxDoublings && map.square()) {
    const Matrix next = map.after(start);
    if (!next.allFinite()) return false;
    const double change = (next - P).norm() / std::max(next.norm(), std::numeric_limits<double>::min());
    if (change > 0.5 * last_change && change < 1e-9) return true;  // rounding; more steps only add to it
    P = next;
    if (change <= std::numeric_limits<double>::epsilon()) return true;
    last_change = change;
  }
  return last_change < 1e-9;
}

/// The limit within one reachable part. False with a reason when it is not found. `certified` when a stable
/// closed loop proves it.
bool find_limit(const Restricted& part, const MarginalModes& modes, RiccatiSolution& solution,
                bool& certified) {
  const Restricted rest = deflated(part, modes);
  Matrix P = rest.P0;
  if (rest.basis.cols() > 0 && !double_to_limit(rest, modes.unstable_uncontrollable > 0, P)) {
    solution.reason = "doubling did not come to rest";
    return false;
  }
  RiccatiResidual residual;
  const bool is_regular = modes.undetectable.cols() == 0;
  if (rest.basis.cols() > 0 && is_regular && !newton_refine(rest.problem, P, residual)) {
    solution.reason = "the closed loop of the limit is not stable";
    return false;
  }
  certified = is_regular && modes.untouched.cols() == 0;
  const Matrix basis = part.basis * rest.basis;
  solution.P = basis * P * basis.transpose();
  return true;
}

void keep_measured(const Restricted& part, const RiccatiGrowth& growth, RiccatiSolution& solution) {
  solution.P = part.basis * growth.P * part.basis.transpose();
  solution.growth_exponent = growth.exponent();
  solution.steps = growth.steps();
}

/// Compares a limit that no stable closed loop certifies with P after many steps, in units where R = I: P is
/// there, or was twice as far away after half of the steps.
bool agrees_with_measured(const RiccatiProblem& problem, const Matrix& P0, const Matrix& measured,
                          const Matrix& before, RiccatiSolution& solution) {
  const double start = std::min(1.0, P0.norm());
  const double scale = std::max({measured.norm(), solution.P.norm(), problem.Qt.norm(), start});
  const double difference = (measured - solution.P).norm();
  if (difference <= kAgreement * scale + kLearning / solution.steps) return true;
  if (difference <= std::min(kHalved * (before - solution.P).norm(), kNearLimit * scale)) return true;
  solution.reason = fmt::format("after {} steps P is still {} (relative) away from the limit found",
                                number_text(solution.steps, 3), number_text(difference / scale, 3));
  return false;
}

bool is_fixed_point(const RiccatiProblem& problem, RiccatiSolution& solution) {
  solution.residual = riccati_residual(problem, solution.P).relative;
  if (solution.residual <= kFixedPointLimit) return true;
  solution.reason =
      fmt::format("the limit found is no fixed point: residual {}", number_text(solution.residual, 2));
  return false;
}

RiccatiKind kind_of_limit(const RiccatiProblem& problem, const Restricted& part, const MarginalModes& modes) {
  MarginalModes all = modes;
  if (part.basis.cols() < problem.state_dim()) {
    all = marginal_modes(problem.F, problem.H, problem.Qt);
    if (!all.ok) return RiccatiKind::undecided;
  }
  if (all.undetectable.cols() > 0) return RiccatiKind::depends_on_initial;
  // Unstable free modes outside the reachable part stay unstable in the closed loop: another P0 moves P.
  if (all.unstable_uncontrollable > modes.unstable_uncontrollable) return RiccatiKind::depends_on_initial;
  return all.untouched.cols() > 0 ? RiccatiKind::strong : RiccatiKind::stabilising;
}

/// Whether modes of a part, all on the unit circle, have different eigenvalues: their covariances then turn.
bool turn(const Restricted& part, const Matrix& modes) {
  constexpr double kSame = 1e-6;
  if (modes.cols() == 0) return false;
  const Eigen::EigenSolver<Matrix> eigen(Matrix(modes.transpose() * part.problem.F * modes), false);
  return eigen.info() == Eigen::Success &&
         ((eigen.eigenvalues().array() - eigen.eigenvalues()[0]).abs() > kSame).any();
}

/// Replaces the measured P by its limit where one is found and confirmed.
void accept_limit(const RiccatiProblem& problem, const Matrix& P0, const Restricted& part,
                  const MarginalModes& modes, const RiccatiGrowth& growth, RiccatiSolution& solution) {
  const Matrix measured = solution.P, before = part.basis * growth.P_before * part.basis.transpose();
  bool certified = false;
  if (find_limit(part, modes, solution, certified) && is_fixed_point(problem, solution) &&
      (certified || agrees_with_measured(problem, P0, measured, before, solution))) {
    solution.kind = kind_of_limit(problem, part, modes);
    if (solution.kind == RiccatiKind::undecided) solution.reason = "the eigenvalues of F did not converge";
  } else {
    solution.P = measured;
    solution.residual = riccati_residual(problem, measured).relative;
    if (!turn(part, modes.undetectable)) return;
    solution.kind = RiccatiKind::oscillating;
    solution.reason.clear();
  }
}

RiccatiGrowth measure(const Restricted& part, const MarginalModes& modes) {
  const GrowthGuard cheap = part.P0.rows() > kAlwaysGuarded ? GrowthGuard::none : GrowthGuard::two_maps;
  RiccatiGrowth growth = riccati_growth(part.problem, part.P0, kMeasuredDoublings, cheap);
  const bool disagrees = modes.ok && modes.paired() == growth.grows();
  if (disagrees && cheap == GrowthGuard::none) {
    growth = riccati_growth(part.problem, part.P0, kMeasuredDoublings, GrowthGuard::two_maps);
  }
  return growth;
}

}  // namespace

RiccatiSolution solve_marginal_riccati(const RiccatiProblem& problem, const Matrix& P0) {
  RiccatiSolution solution;
  const Restricted part = reachable_part(problem, P0);
  if (part.basis.cols() == 0) {
    solution.P = Matrix::Zero(problem.state_dim(), problem.state_dim());
    solution.kind = kind_of_limit(problem, part, MarginalModes{});
    solution.stays_bounded = true;
    return solution;
  }
  const MarginalModes modes = marginal_modes(part.problem.F, part.problem.H, part.problem.Qt);
  const RiccatiGrowth growth = measure(part, modes);
  keep_measured(part, growth, solution);
  solution.residual = riccati_residual(problem, solution.P).relative;
  if (!modes.ok) {
    solution.reason = "the eigenvalues of F did not converge";
    return solution;
  }
  if (modes.paired() == growth.grows()) {
    solution.reason = fmt::format("predicted {}, but the growth exponent after {} steps is {}",
                                  modes.paired() ? "bounded" : "unbounded", number_text(solution.steps, 3),
                                  number_text(growth.exponent(), 3));
    return solution;
  }
  if (growth.grows()) {
    solution.kind = RiccatiKind::unbounded;
    solution.exponential = modes.unstable_undetectable > 0;
    return solution;
  }
  solution.stays_bounded = true;
  accept_limit(problem, P0, part, modes, growth, solution);
  // Rounding mixes what grows with what is reached, and a P that moves so much and does not oscillate may
  // grow.
  constexpr double kStill = 1e-3;
  if (solution.kind == RiccatiKind::undecided && !(solution.residual <= kStill))
    solution.stays_bounded = false;
  return solution;
}

}  // namespace credence::internal
