#include "core/linear_filter.h"

#include <Eigen/Cholesky>
#include <stdexcept>

#include "core/mirror.h"
#include "core/sequential_update.h"

namespace credence {
namespace {

/// Gain and Joseph-form update; false when S is not positive definite.
bool joseph_update(const LinearModel& model, LinearFilterStep& step) {
  const Eigen::LLT<Matrix> llt(step.S);
  if (llt.info() != Eigen::Success) return false;
  step.K = llt.solve(model.H * step.P_prior).transpose();
  const Matrix A = Matrix::Identity(model.state_dim(), model.state_dim()) - step.K * model.H;
  step.P.noalias() = A * step.P_prior * A.transpose();
  step.P.noalias() += step.K * model.R * step.K.transpose();
  symmetrise(step.P);
  return true;
}

}  // namespace

std::vector<LinearFilterStep> linear_filter_steps(const LinearModel& assumed, const InflationRule& rule,
                                                  Index steps) {
  if (rule.is_sequential() && !assumed.R.isDiagonal(0.0)) {
    throw std::invalid_argument("the sequential inflation needs a diagonal measurement noise R");
  }
  const Matrix GQG = assumed.G * assumed.Q * assumed.G.transpose();
  MinTraceState warm_start;
  SequentialWorkspace workspace;
  Matrix P = assumed.P0;
  std::vector<LinearFilterStep> result;
  result.reserve(static_cast<std::size_t>(steps));
  for (Index k = 0; k < steps; ++k) {
    LinearFilterStep step;
    step.P_prior = assumed.F * P * assumed.F.transpose() + GQG;
    symmetrise(step.P_prior);
    const Matrix before = step.P_prior;
    if (rule.constant.size() > 0) step.P_prior += rule.constant;
    if (!rule.is_sequential()) {
      step.converged =
          inflate(step.P_prior, assumed.layout, rule.inflation, rule.solution, warm_start).converged;
    }
    step.inflation = step.P_prior - before;
    step.S = assumed.H * step.P_prior * assumed.H.transpose() + assumed.R;
    symmetrise(step.S);
    if (rule.is_sequential()) {
      step.P = step.P_prior;
      step.K.resize(step.P.rows(), assumed.H.rows());
      step.ok = sequential_update(step.P, assumed.layout, assumed.H, assumed.R.diagonal(), step.K, workspace,
                                  *rule.map_bound());
    } else {
      step.ok = joseph_update(assumed, step);
    }
    P = step.P;
    const bool ok = step.ok;
    result.push_back(std::move(step));
    if (!ok) break;
  }
  return result;
}

}  // namespace credence
