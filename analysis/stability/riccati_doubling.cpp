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

/// allFinite() at the width of a vector register.
bool is_finite(MatrixRef M) { return (M.array() * 0.0).sum() == 0.0; }

void require_shape(const char* name, MatrixRef M, Index rows, Index cols) {
  if (M.rows() != rows || M.cols() != cols) {
    throw std::invalid_argument(
        fmt::format("{} is {}x{} and must be {}x{}", name, M.rows(), M.cols(), rows, cols));
  }
  if (!is_finite(M)) throw std::invalid_argument(fmt::format("{} has an entry that is not finite", name));
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
  if (PanelCholesky().compute(shifted, Vector::Zero(M.rows()))) return;
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(Matrix(M), Eigen::EigenvaluesOnly);
  throw std::invalid_argument(
      fmt::format("{} is not positive semidefinite: eigenvalue {:g}", name, eigen.eigenvalues().minCoeff()));
}

constexpr double kLargest = 1e100;  // squares of it are still finite
constexpr double kVisibleRounding = 1e-3;
// The differences of the factored form are in error by ‖A‖² roundings, of which Newton's correction is to
// have few digits left to make good.
constexpr double kLargeTransition = 1e4;
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
    : A_(problem.F), Theta_(problem.Qt), C_(problem.state_dim(), 0) {
  const Index n = problem.state_dim();
  centre_ = Matrix::Zero(n, n);
  if (problem.H.rows() > 0) {
    const Eigen::LLT<Matrix> llt(problem.R);
    C_ = llt.matrixL().solve(problem.H).transpose();
  }
  allocate();
}

RiccatiMap::RiccatiMap(const RiccatiProblem& problem, const Matrix& centre)
    : centre_(centre),
      A_(problem.F),
      Theta_(riccati_step(problem, centre) - centre),
      C_(problem.state_dim(), 0) {
  if (problem.H.rows() > 0) {
    const Matrix PHt = centre * problem.H.transpose();
    const Eigen::LLT<Matrix> llt(problem.H * PHt + problem.R);
    C_ = llt.matrixL().solve(problem.H).transpose();
    A_ -= problem.F * llt.solve(PHt.transpose()).transpose() * problem.H;
  }
  allocate();
}

void RiccatiMap::allocate() {
  const Index n = A_.rows();
  for (Matrix* M : {&X_, &Z_, &product_, &next_Gamma_, &next_Theta_}) M->resize(n, n);
  if (C_.cols() <= n) return;
  copy_gamma(next_Gamma_);
  Gamma_.swap(next_Gamma_);
  factor_gamma();
}

void RiccatiMap::copy_gamma(Matrix& to) {
  if (Gamma_.size() > 0) {
    to = Gamma_;
  } else {
    multiply_.set_lower(to, C_, ProductFactor::transposed(C_));
    mirror_lower(to);
  }
}

/// C of Gamma_.
void RiccatiMap::factor_gamma() {
  const Index n = A_.rows();
  dense_ = !cholesky_.compute(Gamma_, Vector::Zero(n));
  if (!dense_) C_ = cholesky_.L();
}

ProductFactor RiccatiMap::C() const { return Gamma_.size() > 0 ? ProductFactor::lower(C_) : C_; }

bool RiccatiMap::square() {
  if (!dense_ && !factorise(Factored::with_A)) densify();
  return dense_ ? square_dense() : square_factored();
}

void RiccatiMap::densify() {
  copy_gamma(next_Gamma_);
  Gamma_.swap(next_Gamma_);
  dense_ = true;
}

// With Γ = C Cᵀ and S = I + CᵀΘC = L Lᵀ: W = [Θ; Aᵀ] C L⁻ᵀ = [Eᵀ; Mᵀ]. Θ + centre ⪰ 0, but Θ need not be: S
// is checked.
bool RiccatiMap::factorise(Factored what) {
  const Index n = A_.rows(), r = C_.cols();
  if (!(A_.norm() <= kLargeTransition)) return false;
  Y_.resize(what == Factored::with_A ? 2 * n : n, r);
  multiply_.set(product_, Theta_, C());
  Y_.topRows(n) = product_;
  multiply_.set_lower(S_, ProductFactor::transposed(C()), product_);
  S_.diagonal().array() += 1.0;
  if (what == Factored::with_A) {
    multiply_.set(product_, ProductFactor::transposed(A_), C());
    Y_.bottomRows(n) = product_;
  }
  if (!cholesky_.compute(S_, Y_, Vector::Zero(r))) return false;
  W_ = cholesky_.W();
  return true;
}

// Θ' = Θ + A Z Aᵀ with Z = (I + ΘΓ)⁻¹ Θ = Θ − EᵀE.
double RiccatiMap::combine_Theta() {
  const ProductFactor Et = ProductFactor::rows_of(W_, 0, A_.rows());
  Z_ = Theta_;
  multiply_.add_lower(Z_, ProductFactor::minus(Et), ProductFactor::transposed(Et));
  mirror_lower(Z_);
  multiply_.set(product_, A_, ProductFactor::transposed(Z_));
  multiply_.set_lower(next_Theta_, product_, ProductFactor::transposed(A_));
  return complete_Theta();
}

/// Completes next_Theta_, whose lower triangle holds what is added, and returns the size of that.
double RiccatiMap::complete_Theta() {
  mirror_lower(next_Theta_);
  const double change = next_Theta_.norm();
  next_Theta_ += Theta_;
  return change;
}

// A' = A X with X = (I + ΘΓ)⁻¹ A = A − EᵀM, and C' = [C Mᵀ] or the Cholesky factor of Γ' = Γ + MᵀM.
bool RiccatiMap::square_factored() {
  const Index n = A_.rows(), r = C_.cols();
  const ProductFactor Et = ProductFactor::rows_of(W_, 0, n), Mt = ProductFactor::rows_of(W_, n, n);
  const double change = combine_Theta();
  X_ = A_;
  multiply_.add(X_, ProductFactor::minus(Et), ProductFactor::transposed(Mt));
  multiply_.set(product_, A_, X_);
  if (2 * r <= n) {
    if (!is_finite(W_) || !accept(change)) return false;
    C_.conservativeResize(n, 2 * r);
    C_.rightCols(r) = W_.bottomRows(n);
    return true;
  }
  copy_gamma(next_Gamma_);
  multiply_.add_lower(next_Gamma_, Mt, ProductFactor::transposed(Mt));
  mirror_lower(next_Gamma_);
  if (!is_finite(next_Gamma_) || !accept(change)) return false;
  Gamma_.swap(next_Gamma_);
  factor_gamma();
  return true;
}

/// Makes next_Theta_ and the A' in product_ the map's own, unless they are not finite.
bool RiccatiMap::accept(double change) {
  const double size = next_Theta_.norm();
  if (!std::isfinite(size) || !is_finite(product_)) return false;
  A_.swap(product_);
  Theta_.swap(next_Theta_);
  last_change_ = size > 0.0 ? change / size : 0.0;
  ++doublings_;
  return true;
}

void RiccatiMap::factorise_dense() {
  multiply_.set(product_, Theta_, Gamma_);
  product_.diagonal().array() += 1.0;
  lu_.compute(product_);
}

// Θ' = Θ + A Θ Y with Y = (I + ΓΘ)⁻¹ Aᵀ.
double RiccatiMap::combine_Theta_dense() {
  Z_ = lu_.transpose().solve(A_.transpose());
  multiply_.set(product_, Theta_, Z_);
  multiply_.set_lower(next_Theta_, A_, product_);
  return complete_Theta();
}

// A' = A X, Γ' = Γ + Aᵀ Γ X with X = (I + ΘΓ)⁻¹ A.
bool RiccatiMap::square_dense() {
  factorise_dense();
  X_ = lu_.solve(A_);
  multiply_.set(product_, Gamma_, X_);
  next_Gamma_ = Gamma_;
  multiply_.add_lower(next_Gamma_, ProductFactor::transposed(A_), product_);
  mirror_lower(next_Gamma_);
  const double change = combine_Theta_dense();
  multiply_.set(product_, A_, X_);
  if (!is_finite(next_Gamma_) || !accept(change)) return false;
  Gamma_.swap(next_Gamma_);
  return true;
}

Matrix RiccatiMap::next_Theta() {
  if (!dense_ && !factorise(Factored::Theta_alone)) densify();
  if (dense_) {
    factorise_dense();
    combine_Theta_dense();
  } else {
    combine_Theta();
  }
  return next_Theta_;
}

Matrix RiccatiMap::after(const Matrix& P) const {
  const Matrix D = P - centre_;
  MatrixProduct multiply;
  Matrix W, product;
  if (dense_) {
    multiply.set(W, Gamma_, D);
  } else {
    multiply.set(product, ProductFactor::transposed(C_), D);
    multiply.set(W, C_, product);
  }
  W.diagonal().array() += 1.0;
  const Eigen::PartialPivLU<Matrix> lu(W);
  const Matrix Y = lu.solve(A_.transpose());
  multiply.set(product, D, Y);
  Matrix result = Theta_ + centre_;
  multiply.add_lower(result, A_, product);
  mirror_lower(result);
  return result;
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
    if (other && !((other->after(P0) - P).norm() <= kVisibleRounding * P.norm())) break;
    growth.P_before = std::move(growth.P);
    growth.P = P;
    growth.traces.push_back(P.trace());
  }
  return growth;
}

}  // namespace credence::internal
