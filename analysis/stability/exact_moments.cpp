#include "analysis/stability/exact_moments.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/linear_algebra/decompositions.h"
#include "core/linear_algebra/mirror.h"
#include "core/linear_algebra/psd_root.h"
#include "core/models/model_mismatch.h"

namespace credence::internal {
namespace {

constexpr double kLeastReciprocalCondition = 1e-12;

void require_sizes(const LinearModel& truth, const LinearFilterStep& step) {
  const Index n = truth.state_dim(), m = truth.measurement_dim();
  if (step.P.rows() != n || step.P.cols() != n || step.K.rows() != n || step.K.cols() != m ||
      step.S.rows() != m || step.S.cols() != m) {
    throw std::invalid_argument(fmt::format(
        "a step with P {}x{}, K {}x{} and S {}x{} does not go with {} states and {} measurements",
        step.P.rows(), step.P.cols(), step.K.rows(), step.K.cols(), step.S.rows(), step.S.cols(), n, m));
  }
}

/// States with a variance, scaled to unit diagonal of P.
struct UnitDiagonal {
  std::vector<Index> states;
  Matrix P, Sigma;
};

UnitDiagonal unit_diagonal(MatrixRef P, MatrixRef Sigma, VectorRef before) {
  UnitDiagonal unit{.states = states_with_variance(P, before), .P = {}, .Sigma = {}};
  const Vector d = P.diagonal()(unit.states).cwiseSqrt().cwiseInverse();
  unit.P = d.asDiagonal() * P(unit.states, unit.states) * d.asDiagonal();
  unit.Sigma = d.asDiagonal() * Sigma(unit.states, unit.states) * d.asDiagonal();
  return unit;
}

/// The value on the range of a singular P, and what of Σ lies outside it.
void add_on_range(const UnitDiagonal& unit, ExpectedSquare& result) {
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(unit.P);
  const Index n = unit.P.rows();
  const double threshold =
      static_cast<double>(n) * kLeastReciprocalCondition * eigen.eigenvalues().maxCoeff();
  double outside = 0.0;
  for (Index i = 0; i < n; ++i) {
    const Vector direction = eigen.eigenvectors().col(i);
    const double variance = direction.dot(unit.Sigma * direction);
    if (eigen.eigenvalues()[i] > threshold) {
      result.value += variance / eigen.eigenvalues()[i];
      ++result.dof;
    } else {
      outside += variance;
    }
  }
  const double total = unit.Sigma.trace();
  if (total > 0.0) result.outside = std::max(result.outside, outside / total);
}

double zero_variance_share(const std::vector<Index>& states, MatrixRef Sigma) {
  const double total = Sigma.trace();
  return total > 0.0 ? (total - Sigma.diagonal()(states).sum()) / total : 0.0;
}

}  // namespace

ExpectedSquare expected_square(MatrixRef P, MatrixRef Sigma) {
  return expected_square(P, Sigma, Vector::Zero(P.rows()));
}

ExpectedSquare expected_square(MatrixRef P, MatrixRef Sigma, VectorRef before) {
  ExpectedSquare result;
  const UnitDiagonal unit = unit_diagonal(P, Sigma, before);
  if (std::ssize(unit.states) < P.rows()) result.outside = zero_variance_share(unit.states, Sigma);
  const Index n = unit.P.rows();
  if (n == 0) return result;
  const Eigen::LLT<Matrix> llt(unit.P);
  if (llt.info() == Eigen::Success && llt.rcond() > kLeastReciprocalCondition) {
    result.value = llt.solve(unit.Sigma).trace();
    result.dof = n;
  } else {
    add_on_range(unit, result);
  }
  return result;
}

std::vector<ExactMoments> exact_moments(const LinearModel& truth,
                                        const std::vector<LinearFilterStep>& steps) {
  return exact_moments(std::span(&truth, 1), std::span(&truth, 1), steps);
}

std::vector<ExactMoments> exact_moments(std::span<const LinearModel> truth,
                                        std::span<const LinearModel> assumed,
                                        const std::vector<LinearFilterStep>& steps) {
  const std::vector<LinearModel> models = error_models(truth, assumed);
  const Index n = truth.front().state_dim(), states = models.front().state_dim();
  std::vector<Matrix> GQG;
  GQG.reserve(models.size());
  for (const LinearModel& model : models) GQG.emplace_back(model.G * model.Q * model.G.transpose());
  std::vector<ExactMoments> moments;
  moments.reserve(steps.size());
  Matrix Sigma = models.front().P0;
  for (const LinearFilterStep& step : steps) {
    if (!step.ok) break;
    const std::size_t phase = moments.size() % models.size();
    const LinearModel& model = models[phase];
    require_sizes(truth[phase], step);
    ExactMoments now;
    const Matrix prior = symmetrised(model.F * Sigma * model.F.transpose() + GQG[phase]);
    const Matrix K = padded(step.K, states, step.K.cols());
    const Matrix A = Matrix::Identity(states, states) - K * model.H;
    Sigma = symmetrised(A * prior * A.transpose() + K * model.R * K.transpose());
    now.Sigma = Sigma.topLeftCorner(n, n);
    const ExpectedSquare nees = expected_square(step.P, now.Sigma, step.P_prior.diagonal());
    now.nees = nees.value;
    now.nees_dof = nees.dof;
    now.outside = nees.outside;
    const ExpectedSquare nis =
        expected_square(step.S, symmetrised(model.H * prior * model.H.transpose() + model.R));
    now.nis = nis.value;
    now.nis_dof = nis.dof;
    if (!std::isfinite(now.nees) || !std::isfinite(now.nis)) break;
    moments.push_back(std::move(now));
  }
  return moments;
}

}  // namespace credence::internal
