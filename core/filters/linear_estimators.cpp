#include "core/filters/linear_estimators.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "core/linear_algebra/cholesky.h"
#include "core/linear_algebra/mirror.h"
#include "core/linear_algebra/psd_root.h"

namespace credence::internal {
namespace {

/// A step from the posterior P of the one before; `gain(P⁻, factor of S)` gives K.
template <class Gain>
LinearFilterStep step_from(const LinearModel& model, const Matrix& P, const Gain& gain) {
  LinearFilterStep step;
  const Index n = model.state_dim();
  step.P_prior = model.F * P * model.F.transpose() + model.G * model.Q * model.G.transpose();
  symmetrise(step.P_prior);
  step.inflation = Matrix::Zero(n, n);
  step.S = model.H * step.P_prior * model.H.transpose() + model.R;
  symmetrise(step.S);
  const Eigen::LLT<Matrix> factor(step.S);
  if (factor.info() != Eigen::Success) {
    step.ok = false;
    return step;
  }
  step.K = gain(step.P_prior, factor);
  const Matrix A = Matrix::Identity(n, n) - step.K * model.H;
  step.P = A * step.P_prior * A.transpose() + step.K * model.R * step.K.transpose();
  symmetrise(step.P);
  step.ok = step.P.allFinite();
  return step;
}

template <class Gain>
std::vector<LinearFilterStep> steps_with(const LinearModel& model, Index steps, const Gain& gain) {
  std::vector<LinearFilterStep> result;
  result.reserve(static_cast<std::size_t>(steps));
  while (std::ssize(result) < steps && (result.empty() || result.back().ok)) {
    result.push_back(step_from(model, result.empty() ? model.P0 : result.back().P, gain));
  }
  return result;
}

Matrix kalman_gain(const LinearModel& model, const Matrix& P, const Eigen::LLT<Matrix>& factor) {
  return factor.solve(model.H * P).transpose();
}

}  // namespace

std::vector<LinearFilterStep> constant_gain_steps(const LinearModel& assumed, const Matrix& K, Index steps) {
  return steps_with(assumed, steps, [&](const Matrix&, const Eigen::LLT<Matrix>&) { return K; });
}

std::vector<LinearFilterStep> consider_steps(const LinearModel& assumed, std::span<const Index> considered,
                                             Index steps) {
  return steps_with(assumed, steps, [&](const Matrix& P, const Eigen::LLT<Matrix>& factor) {
    Matrix K = kalman_gain(assumed, P, factor);
    for (const Index i : considered) K.row(i).setZero();
    return K;
  });
}

Matrix steady_state_gain(const LinearModel& assumed) {
  constexpr Index kMostSteps = 100'000;
  constexpr double kSettled = 1e-13;
  const auto gain = [&](const Matrix& P, const Eigen::LLT<Matrix>& factor) {
    return kalman_gain(assumed, P, factor);
  };
  LinearFilterStep step = step_from(assumed, assumed.P0, gain);
  for (Index k = 1; k < kMostSteps && step.ok; ++k) {
    LinearFilterStep next = step_from(assumed, step.P, gain);
    if (!next.ok) break;
    const bool settled = (next.K - step.K).norm() <= kSettled * next.K.norm();
    if (settled) return next.K;
    step = std::move(next);
  }
  throw std::invalid_argument(
      fmt::format("the gain of the Kalman filter does not settle within {} steps", kMostSteps));
}

RtsSmoother::RtsSmoother(const LinearModel& assumed, std::span<const LinearFilterStep> steps)
    : F_(assumed.F), C_(steps.size()), P_(steps.size() + 1) {
  const auto failed = std::ranges::find(steps, false, &LinearFilterStep::ok);
  if (failed != steps.end()) {
    throw std::invalid_argument(
        fmt::format("a smoother needs an S that is positive definite at every step: that of step {} is not",
                    failed - steps.begin() + 1));
  }
  P_.back() = steps.empty() ? assumed.P0 : steps.back().P;
  for (std::size_t k = steps.size(); k-- > 0;) {
    const Matrix& P = k == 0 ? assumed.P0 : steps[k - 1].P;
    const Matrix& prior = steps[k].P_prior;
    const Matrix whitening = psd_whitening(prior);
    C_[k] = P * F_.transpose() * whitening.transpose() * whitening;
    P_[k] = P + C_[k] * (P_[k + 1] - prior) * C_[k].transpose();
    symmetrise(P_[k]);
  }
}

void RtsSmoother::smooth(std::span<Vector> estimates) const {
  if (estimates.size() != P_.size()) {
    throw std::invalid_argument(
        fmt::format("a smoother over {} estimates was given {}", P_.size(), estimates.size()));
  }
  for (std::size_t k = C_.size(); k-- > 0;) {
    const Vector change = C_[k] * (estimates[k + 1] - F_ * estimates[k]);
    estimates[k] += change;
  }
}

}  // namespace credence::internal
