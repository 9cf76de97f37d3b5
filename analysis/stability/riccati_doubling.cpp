#include "analysis/stability/riccati_doubling.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

#include "core/linear_algebra/decompositions.h"
#include "core/linear_algebra/mirror.h"

namespace credence::internal {
namespace {

void require_shape(const char* name, MatrixRef M, Index rows, Index cols) {
  if (M.rows() != rows || M.cols() != cols) {
    throw std::invalid_argument(
        fmt::format("{} is {}x{} and must be {}x{}", name, M.rows(), M.cols(), rows, cols));
  }
  if (!M.allFinite()) throw std::invalid_argument(fmt::format("{} has an entry that is not finite", name));
}

void require_symmetric(const char* name, MatrixRef M) {
  const double asymmetry = (M - M.transpose()).cwiseAbs().maxCoeff();
  if (asymmetry > 1e-9 * M.cwiseAbs().maxCoeff()) {
    throw std::invalid_argument(
        fmt::format("{} is not symmetric: two entries differ by {:g}", name, asymmetry));
  }
}

void require_psd(const char* name, MatrixRef M) {
  require_symmetric(name, M);
  const double slack = 1e-9 * M.cwiseAbs().maxCoeff();
  Matrix shifted = M;
  shifted.diagonal().array() += slack + std::numeric_limits<double>::min();
  if (Eigen::LLT<Matrix>(shifted).info() == Eigen::Success) return;
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(Matrix(M), Eigen::EigenvaluesOnly);
  throw std::invalid_argument(
      fmt::format("{} is not positive semidefinite: eigenvalue {:g}", name, eigen.eigenvalues().minCoeff()));
}

constexpr double kLargest = 1e100;  // squares of it are still finite
constexpr double kVisibleRounding = 1e-3;
constexpr double kSignificantIncrement = 1e-5;

/// Another point of the trajectory, near enough for the same P0 to be followed from it.
Matrix second_centre(const RiccatiProblem& problem, const Matrix& P0) {
  return riccati_step(problem, riccati_step(problem, riccati_step(problem, P0)));
}

double safe_log2_ratio(double now, double before) {
  return now > 0.0 && before > 0.0 ? std::log2(now / before) : 0.0;
}

/// h of the three traces before `end`.
double increment_exponent_at(const std::vector<double>& traces, std::size_t end) {
  if (end < 3) return 0.0;
  const double last = traces[end - 1] - traces[end - 2];
  const double before = traces[end - 2] - traces[end - 3];
  const double significant = kSignificantIncrement * traces[end - 1];
  return last > significant && before > 0.25 * significant ? std::log2(last / before) : 0.0;
}

}  // namespace

void require_valid(const RiccatiProblem& problem, MatrixRef P0) {
  const Index n = problem.F.rows();
  const Index m = problem.H.rows();
  if (n == 0) throw std::invalid_argument("a Riccati problem needs at least one state");
  require_shape("F", problem.F, n, n);
  require_shape("H", problem.H, m, n);
  require_shape("Qt", problem.Qt, n, n);
  require_shape("R", problem.R, m, m);
  require_shape("P0", P0, n, n);
  require_psd("Qt", problem.Qt);
  require_psd("P0", P0);
  if (m == 0) return;
  require_symmetric("R", problem.R);
  if (problem.R.llt().info() != Eigen::Success) throw std::invalid_argument("R is not positive definite");
}

Matrix riccati_step(const RiccatiProblem& problem, MatrixRef P) {
  const Matrix FP = problem.F * P;
  Matrix next = FP * problem.F.transpose() + problem.Qt;
  if (problem.H.rows() > 0) {
    const Matrix S = problem.H * P * problem.H.transpose() + problem.R;
    const Matrix FPHt = FP * problem.H.transpose();
    const Eigen::LLT<Matrix> llt(S);
    const Matrix E = llt.matrixL().solve(FPHt.transpose());
    next -= E.transpose() * E;
  }
  return 0.5 * (next + next.transpose());
}

RiccatiMap::RiccatiMap(const RiccatiProblem& problem)
    : A_(problem.F), Theta_(problem.Qt), N_(0, problem.state_dim()) {
  const Index n = problem.state_dim();
  centre_ = Matrix::Zero(n, n);
  if (problem.H.rows() > 0) {
    const Eigen::LLT<Matrix> llt(problem.R);
    N_ = llt.matrixL().solve(problem.H);
  }
  allocate();
}

RiccatiMap::RiccatiMap(const RiccatiProblem& problem, const Matrix& centre)
    : centre_(centre),
      A_(problem.F),
      Theta_(riccati_step(problem, centre) - centre),
      N_(0, problem.state_dim()) {
  if (problem.H.rows() > 0) {
    const Matrix PHt = centre * problem.H.transpose();
    const Eigen::LLT<Matrix> llt(problem.H * PHt + problem.R);
    N_ = llt.matrixL().solve(problem.H);
    A_ -= problem.F * llt.solve(PHt.transpose()).transpose() * problem.H;
  }
  allocate();
}

void RiccatiMap::allocate() {
  const Index n = A_.rows();
  for (Matrix* M : {&W_, &X_, &product_, &next_Gamma_, &next_Theta_}) M->resize(n, n);
  lu_ = Eigen::PartialPivLU<Matrix>(n);
  if (!is_factored()) densify();
}

void RiccatiMap::densify() {
  Gamma_ = Matrix::Zero(A_.rows(), A_.rows());
  multiply_.add_lower(Gamma_, ProductFactor::transposed(N_), N_);
  mirror_lower(Gamma_);
  dense_ = true;
}

bool RiccatiMap::square() {
  if (!dense_) return square_factored();
  return square_dense();
}

// With Γ = NᵀN and S = I + N Θ Nᵀ = L Lᵀ: X = (I + ΘΓ)⁻¹ A = A − Θ Nᵀ S⁻¹ N A, and Γ' has the factor
// [N; L⁻¹ N A], of twice the rows. Θ + centre ⪰ 0, but Θ need not be: S is checked.
bool RiccatiMap::square_factored() {
  const Index n = A_.rows(), r = N_.rows();
  const Matrix N_Theta = N_ * Theta_;
  Matrix S = N_Theta * N_.transpose();
  S.diagonal().array() += 1.0;
  const Eigen::LLT<Matrix> llt(S);
  if (llt.info() != Eigen::Success) {
    densify();
    return square_dense();
  }
  const Matrix E = llt.matrixL().solve(N_Theta);
  Matrix next_N(2 * r, n);
  next_N.topRows(r) = N_;
  next_N.bottomRows(r) = llt.matrixL().solve(N_ * A_);
  X_ = A_;
  X_.noalias() -= E.transpose() * next_N.bottomRows(r);

  multiply_.set(product_, A_, Theta_);
  next_Theta_.setZero();
  multiply_.add_lower(next_Theta_, product_, ProductFactor::transposed(A_));
  if (r > 0) {
    const Matrix EA = E * A_.transpose();
    next_Theta_.triangularView<Eigen::Lower>() -= EA.transpose() * EA;
  }
  const double change = add_to_Theta();
  multiply_.set(product_, A_, X_);
  const double size = next_Theta_.norm();
  if (!std::isfinite(size) || !product_.allFinite() || !next_N.allFinite()) return false;
  A_.swap(product_);
  N_.swap(next_N);
  Theta_.swap(next_Theta_);
  last_change_ = size > 0.0 ? change / size : 0.0;
  ++doublings_;
  if (!is_factored()) densify();
  return true;
}

void RiccatiMap::factorise() {
  multiply_.set(W_, Theta_, Gamma_);
  W_.diagonal().array() += 1.0;
  lu_.compute(W_);
}

/// Completes next_Theta_, whose lower triangle holds what is added, and returns the size of that.
double RiccatiMap::add_to_Theta() {
  mirror_lower(next_Theta_);
  const double change = next_Theta_.norm();
  next_Theta_ += Theta_;
  return change;
}

// A' = A X, Γ' = Γ + Aᵀ Γ X, Θ' = Θ + A Θ Y with X = (I + ΘΓ)⁻¹ A and Y = (I + ΓΘ)⁻¹ Aᵀ.
bool RiccatiMap::square_dense() {
  factorise();
  X_ = lu_.solve(A_);
  multiply_.set(product_, Gamma_, X_);
  next_Gamma_ = Gamma_;
  multiply_.add_lower(next_Gamma_, ProductFactor::transposed(A_), product_);
  mirror_lower(next_Gamma_);

  W_ = lu_.transpose().solve(A_.transpose());
  multiply_.set(product_, Theta_, W_);
  next_Theta_.setZero();
  multiply_.add_lower(next_Theta_, A_, product_);
  const double change = add_to_Theta();

  multiply_.set(product_, A_, X_);
  const double size = next_Theta_.norm();
  if (!std::isfinite(size) || !product_.allFinite() || !next_Gamma_.allFinite()) return false;
  A_.swap(product_);
  Gamma_.swap(next_Gamma_);
  Theta_.swap(next_Theta_);
  last_change_ = size > 0.0 ? change / size : 0.0;
  ++doublings_;
  return true;
}

Matrix RiccatiMap::next_Theta() {
  if (!dense_) densify();
  factorise();
  W_ = lu_.transpose().solve(A_.transpose());
  multiply_.set(product_, Theta_, W_);
  next_Theta_.setZero();
  multiply_.add_lower(next_Theta_, A_, product_);
  add_to_Theta();
  return next_Theta_;
}

Matrix RiccatiMap::after(const Matrix& P) const {
  const Matrix D = P - centre_;
  Matrix W = dense_ ? Matrix(Gamma_ * D) : Matrix(N_.transpose() * (N_ * D));
  W.diagonal().array() += 1.0;
  const Eigen::PartialPivLU<Matrix> lu(W);
  const Matrix Y = lu.solve(A_.transpose());
  const Matrix result = A_ * (D * Y) + Theta_ + centre_;
  return 0.5 * (result + result.transpose());
}

double RiccatiGrowth::steps() const { return std::exp2(static_cast<double>(traces.size()) - 1.0); }

double RiccatiGrowth::exponent() const {
  if (traces.size() < 2) return 0.0;
  return safe_log2_ratio(traces[traces.size() - 1], traces[traces.size() - 2]);
}

double RiccatiGrowth::increment_exponent() const { return increment_exponent_at(traces, traces.size()); }

double RiccatiGrowth::trace_per_step() const {
  if (traces.size() < 2) return 0.0;
  return (traces[traces.size() - 1] - traces[traces.size() - 2]) / (0.5 * steps());
}

bool RiccatiGrowth::grows() const {
  if (overflowed || exponent() > 0.5) return true;
  return increment_exponent() > 0.5 && increment_exponent_at(traces, traces.size() - 1) > 0.5;
}

RiccatiGrowth riccati_growth(const RiccatiProblem& problem, const Matrix& P0, int doublings,
                             GrowthGuard guard) {
  RiccatiMap map(problem, P0);
  std::optional<RiccatiMap> other;
  if (guard == GrowthGuard::two_maps) other.emplace(problem, second_centre(problem, P0));
  RiccatiGrowth growth;
  growth.P = growth.P_before = map.after_centre();
  growth.traces.push_back(growth.P.trace());
  while (map.doublings() < doublings) {
    const bool finite = map.square() && (!other || other->square());
    const Matrix P = map.after_centre();
    if (!finite || P.cwiseAbs().maxCoeff() > kLargest) {
      growth.overflowed = true;
      break;
    }
    if (other && !((other->after(P0) - P).norm() <= kVisibleRounding * P.norm())) {
      growth.rounded = true;
      break;
    }
    growth.P_before = std::move(growth.P);
    growth.P = P;
    growth.traces.push_back(P.trace());
  }
  return growth;
}

}  // namespace credence::internal
