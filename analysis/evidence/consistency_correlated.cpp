#include "analysis/evidence/consistency_correlated.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>
#include <vector>

#include "analysis/evidence/consistency_judge.h"
#include "core/linear_algebra/decompositions.h"

namespace credence {
namespace {

constexpr int kDraws = 20000;

void require_correlation(MatrixRef correlation, std::size_t steps) {
  const Index T = static_cast<Index>(steps);
  if (correlation.rows() != T || correlation.cols() != T) {
    throw std::invalid_argument(
        fmt::format("correlation of {}x{} for {} steps", correlation.rows(), correlation.cols(), steps));
  }
  constexpr double kRounding = 1e-9;
  if (T > 0 && !(correlation.cwiseAbs().maxCoeff() <= 1.0 + kRounding)) {
    throw std::invalid_argument("an entry of the correlation is not in [-1, 1]");
  }
}

// The standard deviations of the sums at the steps, √(2 dof).
Vector deviations(const std::vector<double>& dofs) {
  return (2.0 * Eigen::Map<const Vector>(dofs.data(), static_cast<Index>(dofs.size()))).cwiseSqrt();
}

SumLaw correlated_sum(const std::vector<double>& dofs, const Matrix& correlation) {
  const Vector deviation = deviations(dofs);
  const double mean = 0.5 * deviation.squaredNorm();
  const double variance = deviation.dot(correlation * deviation);
  return cumulant_law({.mean = mean, .variance = variance, .third = 2.0 * variance * variance / mean});
}

// Largest |score| over the steps and their weighted sum, in draws from N(0, correlation).
std::vector<double> draw_largest_scores(const std::vector<double>& dofs, const Matrix& correlation) {
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(correlation);
  // An empirical correlation has the rank of its runs: the rest needs no random numbers.
  const Index rank =
      std::max<Index>(1, (eigen.eigenvalues().array() > 1e-10 * eigen.eigenvalues().maxCoeff()).count());
  const Matrix root = eigen.eigenvectors().rightCols(rank) *
                      eigen.eigenvalues().tail(rank).cwiseMax(0.0).cwiseSqrt().asDiagonal();
  const Vector deviation = deviations(dofs);
  const double sum_deviation = std::sqrt(deviation.dot(correlation * deviation));

  std::mt19937_64 generator(20040901);
  std::normal_distribution<double> normal;
  std::vector<double> largest(kDraws);
  constexpr int kBlock = 200;
  for (Index first = 0; first < kDraws; first += kBlock) {
    const Matrix white = Matrix::NullaryExpr(rank, kBlock, [&] { return normal(generator); });
    const Matrix scores = root * white;
    const Vector sums = scores.transpose() * deviation / sum_deviation;
    for (Index i = 0; i < kBlock; ++i) {
      largest[static_cast<std::size_t>(first + i)] =
          std::max(scores.col(i).cwiseAbs().maxCoeff(), std::abs(sums(i)));
    }
  }
  std::sort(largest.begin(), largest.end());
  return largest;
}

std::vector<double> dofs_of(const std::vector<StepTest>& tested) {
  std::vector<double> dofs;
  dofs.reserve(tested.size());
  for (const StepTest& step : tested) dofs.push_back(step.total_dof);
  return dofs;
}

// The law drawn for some relative weights of the steps serves any number of runs.
void require_same_steps(const std::vector<StepTest>& tested, const CorrelatedSteps& steps) {
  if (tested.size() != steps.dofs.size()) {
    throw std::invalid_argument(
        fmt::format("{} steps with data, but the law is that of {} steps", tested.size(), steps.dofs.size()));
  }
}

}  // namespace

CorrelatedSteps correlated_steps(MatrixRef correlation, std::span<const double> total_dof_per_step) {
  require_correlation(correlation, total_dof_per_step.size());
  std::vector<Index> kept;
  CorrelatedSteps steps;
  for (std::size_t k = 0; k < total_dof_per_step.size(); ++k) {
    if (!(total_dof_per_step[k] > 0.0)) continue;
    kept.push_back(static_cast<Index>(k));
    steps.dofs.push_back(total_dof_per_step[k]);
  }
  steps.correlation = correlation(kept, kept);
  if (!kept.empty()) steps.largest_scores = draw_largest_scores(steps.dofs, steps.correlation);
  return steps;
}

ConsistencyVerdict judge_correlated_nees(std::span<const Moments> per_step,
                                         std::span<const double> total_dof_per_step,
                                         const CorrelatedSteps& steps, double confidence) {
  return judge_sums(per_step, total_dof_per_step, confidence,
                    {.step = [](double total_dof, double /*count*/) { return chi_square_law(total_dof); },
                     .overall =
                         [&](const std::vector<StepTest>& tested) {
                           return correlated_sum(dofs_of(tested), steps.correlation);
                         },
                     .method = "every step and the sum over steps by their largest normal score, "
                               "with the correlation in time given",
                     .largest_scores =
                         [&](const std::vector<StepTest>& tested) {
                           require_same_steps(tested, steps);
                           return steps.largest_scores;
                         }});
}

}  // namespace credence
