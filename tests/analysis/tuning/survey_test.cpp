// The example of the survey [Dunik 2017], on many data sets: errors against the bound of Cramér and Rao,
// coverage of the intervals, and what other methods lose on the same data.

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <utility>

#include "analysis/tuning/tuning.h"
#include "core/parallel_tasks.h"
#include "montecarlo/engine/moments.h"
#include "tests/analysis/tuning/local_level.h"
#include "tests/analysis/tuning/other_methods.h"

namespace credence::internal {
namespace {

using testing::simulate;
using testing::survey_model;

constexpr Index kSteps = 1001;

/// CREDENCE_SURVEY_SETS=1000 makes the study of docs/tune.md and prints its numbers.
const char* asked_sets() { return std::getenv("CREDENCE_SURVEY_SETS"); }
Index data_sets() { return asked_sets() == nullptr ? 200 : std::atol(asked_sets()); }

/// Q11, Q21, Q22, R11, R22 of one method over the data sets.
struct Errors {
  Matrix squared;  ///< 5 × data sets
  Vector rmse() const { return squared.rowwise().mean().cwiseSqrt(); }
};

TEST(Survey, ReachesTheBoundOfCramerAndRaoAndCovers) {
  const LinearModel truth = survey_model();
  const Index sets = data_sets();
  const Vector values{{2.0, -0.5, 1.0, 3.0, 2.0}};
  LinearModel present = truth;
  present.Q = present.R = Matrix::Identity(2, 2);
  const NoiseParameters at_truth(truth, parse_free_noise("full(Q),diag(R)"));
  const InnovationSensitivities filter(truth, at_truth.derivatives(at_truth.start()), kSteps);
  Matrix gradients(5, 5);
  const std::vector<NoiseValue> named = at_truth.values(at_truth.start());
  for (Index i = 0; i < 5; ++i) gradients.row(i) = named[static_cast<std::size_t>(i)].gradient;
  const Matrix information = filter.expected_information(kSteps);
  const Vector bound = (gradients * information.inverse() * gradients.transpose()).diagonal().cwiseSqrt();

  std::vector<NoiseDerivative> basis(5);
  for (std::size_t i = 0; i < 5; ++i) {
    Matrix& A = i < 3 ? basis[i].Q : basis[i].R;
    A = Matrix::Zero(2, 2);
    const auto [row, column] =
        std::array<std::pair<Index, Index>, 5>{{{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}}}[i];
    A(row, column) = A(column, row) = 1.0;
  }
  const testing::AutocovarianceLeastSquares least_squares(present, basis, 15);

  Matrix covered = Matrix::Zero(5, sets);
  Errors likelihood{Matrix(5, sets)}, autocovariance{Matrix(5, sets)}, nis{Matrix(5, sets)};
  for_each_task(sets, 0, nullptr, [&](std::int64_t set) {
    const auto runs = simulate(truth, 1, kSteps, 1000 + static_cast<std::uint64_t>(set));
    const LinearScore score({present, parse_free_noise("full(Q),diag(R)")}, runs, 1);
    const Tuning tuning = tune(score, score.noise().start());
    for (std::size_t i = 0; i < 5; ++i) {
      const TunedParameter& p = tuning.parameters[i];
      const auto at = static_cast<Index>(i);
      likelihood.squared(at, set) = std::pow(p.value - values[at], 2);
      covered(at, set) = p.lower <= values[at] && values[at] <= p.upper ? 1.0 : 0.0;
    }
    autocovariance.squared.col(set) = (least_squares.estimate(runs.front(), 50) - values).cwiseAbs2();
    const auto by_nis = score.values(testing::tune_by_nis(score, score.noise().start()));
    for (Index i = 0; i < 5; ++i) {
      nis.squared(i, set) = std::pow(by_nis[static_cast<std::size_t>(i)].value - values[i], 2);
    }
  });
  const Vector coverage = covered.rowwise().mean();
  if (asked_sets() != nullptr) {
    const Eigen::IOFormat row(4, 0, "  ", "  ");
    std::cout << "Q11, Q21, Q22, R11, R22 of " << sets << " data sets"
              << "\nbound                 " << bound.format(row) << "\nRMSE / bound          "
              << likelihood.rmse().cwiseQuotient(bound).format(row) << "\nautocovariance, same  "
              << autocovariance.rmse().cwiseQuotient(bound).format(row) << "\nNIS cost, same        "
              << nis.rmse().cwiseQuotient(bound).format(row) << "\ncoverage              "
              << coverage.format(row) << "\nof all                " << coverage.mean() << "\n";
  }
  const auto count = static_cast<double>(sets);
  for (Index i = 0; i < 5; ++i) {
    // The RMSE of a normal estimate has the relative standard error 1/√(2 sets).
    EXPECT_NEAR(likelihood.rmse()[i] / bound[i], 1.0, 5.0 / std::sqrt(2.0 * count)) << i;
    EXPECT_NEAR(coverage[i], 0.95, 5.0 * std::sqrt(0.95 * 0.05 / count)) << i;
    EXPECT_GT(nis.rmse()[i], 1.5 * likelihood.rmse()[i]) << i;
  }
  EXPECT_GT(autocovariance.rmse().cwiseQuotient(likelihood.rmse()).maxCoeff(), 1.1);
}

}  // namespace
}  // namespace credence::internal
