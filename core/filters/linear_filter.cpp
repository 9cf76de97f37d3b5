#include "core/filters/linear_filter.h"

#include <stdexcept>

#include "core/filters/sequential_update.h"
#include "core/linear_algebra/cholesky.h"
#include "core/linear_algebra/mirror.h"
#include "core/linear_algebra/psd_root.h"
#include "core/stop_point.h"

namespace credence::internal {
namespace {

/// Gain and Joseph-form update; false when S is not positive definite.
bool joseph_update(const LinearModel& model, LinearFilterStep& step) {
  if (model.measurement_dim() == 0) {
    step.K.resize(model.state_dim(), 0);
    step.P = step.P_prior;
    return true;
  }
  const Eigen::LLT<Matrix> llt(step.S);
  if (llt.info() != Eigen::Success) return false;
  step.K = llt.solve(model.H * step.P_prior).transpose();
  const Matrix A = Matrix::Identity(model.state_dim(), model.state_dim()) - step.K * model.H;
  step.P.noalias() = A * step.P_prior * A.transpose();
  step.P.noalias() += step.K * model.R * step.K.transpose();
  symmetrise(step.P);
  return true;
}

void require_diagonal(const LinearModel& assumed) {
  if (!assumed.R.isDiagonal(0.0)) {
    throw std::invalid_argument("this linear filter needs a diagonal measurement noise R");
  }
}

Matrix process_covariance(const LinearModel& model) { return model.G * model.Q * model.G.transpose(); }

/// From the posterior P of the step before.
LinearFilterStep advance(const LinearModel& model, const InflationRule& rule, const Matrix& GQG,
                         const Matrix& P, InflationAlongRun& along, SequentialWorkspace& workspace) {
  LinearFilterStep step;
  step.P_prior = model.F * P * model.F.transpose() + GQG;
  symmetrise(step.P_prior);
  const Matrix before = step.P_prior;
  if (rule.constant.size() > 0) step.P_prior += rule.constant;
  step.converged = along.apply(step.P_prior, model.layout, rule).converged;
  step.inflation = step.P_prior - before;
  step.S = model.H * step.P_prior * model.H.transpose() + model.R;
  symmetrise(step.S);
  if (rule.is_sequential()) {
    step.P = step.P_prior;
    step.K.resize(step.P.rows(), model.H.rows());
    step.ok = sequential_update(step.P, model.layout, model.H, model.R.diagonal(), step.K, workspace,
                                *rule.map_bound());
  } else {
    step.ok = joseph_update(model, step);
  }
  step.ok = step.ok && step.P.allFinite();  // what is unstable and not observed grows beyond all numbers
  if (step.ok) clear_rounded_variances(step.P, step.P_prior.diagonal());
  return step;
}

}  // namespace

LinearFilter::LinearFilter(LinearModel assumed, InflationRule rule)
    : LinearFilter(std::vector{std::move(assumed)}, std::move(rule)) {}

LinearFilter::LinearFilter(std::vector<LinearModel> period, InflationRule rule)
    : period_(std::move(period)), seen_(period_.front()), rule_(std::move(rule)) {
  for (const LinearModel& model : period_) {
    if (rule_.is_sequential()) require_diagonal(model);
    GQG_.push_back(process_covariance(model));
  }
  reset();
}

void LinearFilter::reset() { reset(period_.front().P0); }

void LinearFilter::reset(Matrix P) {
  step_ = {};
  step_.P = std::move(P);
  steps_ = 0;
  inflation_.reset();
}

const LinearFilterStep& LinearFilter::step() {
  const auto phase = static_cast<std::size_t>(steps_++ % std::ssize(period_));
  step_ = advance(period_[phase], rule_, GQG_[phase], step_.P, inflation_, workspace_);
  return step_;
}

const LinearFilterStep& LinearFilter::step(std::span<const Index> rows) {
  const auto phase = static_cast<std::size_t>(steps_++ % std::ssize(period_));
  if (period_.size() > 1) seen_.F = period_[phase].F;
  seen_.H = period_[phase].H(rows, Eigen::all);
  seen_.R = period_[phase].R(rows, rows);
  step_ = advance(seen_, rule_, GQG_[phase], step_.P, inflation_, workspace_);
  return step_;
}

std::vector<LinearFilterStep> linear_filter_steps(const LinearModel& assumed, const InflationRule& rule,
                                                  Index steps) {
  return linear_filter_steps(std::span(&assumed, 1), rule, steps);
}

std::vector<LinearFilterStep> linear_filter_steps(std::span<const LinearModel> period,
                                                  const InflationRule& rule, Index steps) {
  LinearFilter filter({period.begin(), period.end()}, rule);
  std::vector<LinearFilterStep> result;
  result.reserve(static_cast<std::size_t>(steps));
  for (Index k = 0; k < steps; ++k) {
    stop_point();
    result.push_back(filter.step());
    if (!result.back().ok) break;
  }
  return result;
}

}  // namespace credence::internal
