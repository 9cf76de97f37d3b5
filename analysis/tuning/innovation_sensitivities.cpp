#include "analysis/tuning/innovation_sensitivities.h"

#include <algorithm>
#include <utility>

#include "core/linear_algebra/cholesky.h"
#include "core/linear_algebra/mirror.h"
#include "core/stop_point.h"

namespace credence::internal {
namespace {

constexpr double kSettled = 1e-14;  // at which rounding moves it

/// Of a covariance every element by itself: a large variance that nobody sees hides no small state.
bool has_settled(const Matrix& now, const Matrix& before) {
  const Vector deviation = now.diagonal().cwiseMax(0.0).cwiseSqrt();
  return ((now - before).array().abs() <= kSettled * (deviation * deviation.transpose()).array()).all();
}

bool derivative_has_settled(const Matrix& now, const Matrix& before) {
  return (now - before).cwiseAbs().maxCoeff() <= kSettled * now.cwiseAbs().maxCoeff();
}

/// x += A B Aᵀ where there is a B.
void add_congruence(Matrix& x, const Matrix& A, const Matrix& B) {
  if (B.size() > 0) x += A * B * A.transpose();
}

}  // namespace

InnovationSensitivities::InnovationSensitivities(const LinearModel& model,
                                                 std::vector<NoiseDerivative> derivatives, Index steps)
    : H_(model.H), parameters_(std::ssize(derivatives)) {
  const Index n = model.state_dim();
  const auto predict = [&](const Matrix& P, const Matrix& Q) -> Matrix {
    Matrix next = model.F * P * model.F.transpose();
    add_congruence(next, model.G, Q);
    symmetrise(next);
    return next;
  };
  Matrix P = predict(model.P0, model.Q);
  std::vector<Matrix> P_dot;
  P_dot.reserve(derivatives.size());
  for (const NoiseDerivative& d : derivatives) {
    P_dot.push_back(predict(d.P0.size() > 0 ? d.P0 : Matrix::Zero(n, n), d.Q));
  }
  for (Index k = 0; k < steps; ++k) {
    stop_point();
    const Matrix before = P;
    const std::vector<Matrix> before_dot = P_dot;
    if (!add_step(model, derivatives, P, P_dot)) {
      ok_ = false;
      return;
    }
    P = predict(P, model.Q);
    bool still = has_settled(P, before);
    for (std::size_t i = 0; i < P_dot.size(); ++i) {
      P_dot[i] = predict(P_dot[i], derivatives[i].Q);
      still = still && derivative_has_settled(P_dot[i], before_dot[i]);
    }
    if (still) return;
  }
}

/// Adds the step from the prior P, which it updates.
bool InnovationSensitivities::add_step(const LinearModel& model,
                                       const std::vector<NoiseDerivative>& derivatives, Matrix& P,
                                       std::vector<Matrix>& P_dot) {
  const Matrix &F = model.F, &H = model.H;
  const Index n = F.rows(), m = H.rows();
  const Matrix PHt = P * H.transpose();
  Matrix S = H * PHt + model.R;
  symmetrise(S);
  const Eigen::LLT<Matrix> llt(S);
  if (!S.allFinite() || llt.info() != Eigen::Success) return false;
  InnovationStep& step = steps_.emplace_back();
  S_.push_back(S);
  step.S_inverse = llt.solve(Matrix::Identity(m, m));
  step.S_root_inverse = llt.matrixL().solve(Matrix::Identity(m, m));
  step.log_determinant = 2.0 * llt.matrixLLT().diagonal().array().log().sum();
  const Matrix K = llt.solve(PHt.transpose()).transpose();
  const Matrix A = Matrix::Identity(n, n) - K * H;
  step.FK = F * K;
  step.closed = F * A;
  step.FK_dot.resize(n * parameters_, m);
  step.trace.resize(parameters_);
  for (Index i = 0; i < parameters_; ++i) {
    Matrix& D = P_dot[static_cast<std::size_t>(i)];
    const Matrix& R_dot = derivatives[static_cast<std::size_t>(i)].R;
    const Matrix DHt = D * H.transpose();
    Matrix S_dot = H * DHt;
    if (R_dot.size() > 0) S_dot += R_dot;
    const Matrix K_dot = (DHt - K * S_dot) * step.S_inverse;
    step.FK_dot.middleRows(i * n, n) = F * K_dot;
    step.trace[i] = (step.S_inverse * S_dot).trace();
    step.S_dot.push_back(S_dot);
    D = (A * D * A.transpose()).eval();
    add_congruence(D, K, R_dot);
  }
  P = (A * P * A.transpose() + K * model.R * K.transpose()).eval();
  return P.allFinite();
}

Matrix InnovationSensitivities::expected_information(Index steps) const {
  const Index p = parameters_, n = H_.cols();
  Matrix information = Matrix::Zero(p, p), increment = information;
  Matrix moved = Matrix::Zero(n * p, n * p);  // covariance of the ẋ̂_i below each other
  for (Index k = 0; k < steps; ++k) {
    const InnovationStep& now = step(k);
    const Matrix& S = S_[static_cast<std::size_t>(std::min(k, std::ssize(S_) - 1))];
    const Matrix weight = H_.transpose() * now.S_inverse * H_;
    for (Index i = 0; i < p; ++i) {
      for (Index j = 0; j <= i; ++j) {
        const Matrix& first = now.S_dot[static_cast<std::size_t>(i)];
        const Matrix& second = now.S_dot[static_cast<std::size_t>(j)];
        increment(i, j) = increment(j, i) =
            0.5 * (now.S_inverse * first * now.S_inverse).cwiseProduct(second).sum() +
            weight.cwiseProduct(moved.block(i * n, j * n, n, n)).sum();
      }
    }
    information += increment;
    Matrix next = now.FK_dot * S * now.FK_dot.transpose();
    for (Index i = 0; i < p; ++i) {
      for (Index j = 0; j < p; ++j) {
        next.block(i * n, j * n, n, n) +=
            now.closed * moved.block(i * n, j * n, n, n) * now.closed.transpose();
      }
    }
    const bool still = k + 1 >= std::ssize(steps_) && derivative_has_settled(next, moved);
    moved = std::move(next);
    if (still) return information + static_cast<double>(steps - k - 1) * increment;
  }
  return information;
}

}  // namespace credence::internal
