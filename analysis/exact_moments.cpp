#include "analysis/exact_moments.h"

#include "core/psd_root.h"

namespace credence {
namespace {

/// tr(A⁺ B) on the range of A.
double normalised_trace(const Matrix& A, const Matrix& B) {
  const Matrix W = psd_whitening(A);
  return (W * B * W.transpose()).trace();
}

}  // namespace

std::vector<ExactMoments> exact_moments(const LinearModel& truth, std::span<const LinearFilterStep> steps) {
  const Matrix GQG = truth.G * truth.Q * truth.G.transpose();
  const Matrix I = Matrix::Identity(truth.state_dim(), truth.state_dim());
  Matrix Sigma = truth.P0;
  std::vector<ExactMoments> result;
  for (const LinearFilterStep& step : steps) {
    if (!step.ok) break;
    ExactMoments e;
    e.Sigma_prior = truth.F * Sigma * truth.F.transpose() + GQG;
    const Matrix A = I - step.K * truth.H;
    e.Sigma = A * e.Sigma_prior * A.transpose() + step.K * truth.R * step.K.transpose();
    e.nees = normalised_trace(step.P, e.Sigma);
    e.nis = normalised_trace(step.S, truth.H * e.Sigma_prior * truth.H.transpose() + truth.R);
    Sigma = e.Sigma;
    result.push_back(std::move(e));
  }
  return result;
}

}  // namespace credence
