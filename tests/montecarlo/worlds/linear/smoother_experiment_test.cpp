#include "montecarlo/worlds/linear/smoother_experiment.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <atomic>
#include <string>
#include <vector>

#include "core/stop_point.h"
#include "montecarlo/engine/experiment.h"
#include "montecarlo/scenario/noise_switches.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {
namespace {

const std::string kSmoothed =
    "[world]\nmodel = \"linear\"\n"
    "F = [[1, 0.5], [-0.1, 0.9]]\nG = [[0.5], [1]]\nH = [[1, 0.2]]\nQ = [[0.3]]\nR = [[0.5]]\n"
    "P0 = [[4, 1], [1, 2]]\n[study]\nsteps = 12\n";

std::vector<TraceStep> smoothed_steps(const std::string& estimator, std::int64_t run) {
  const Scenario scenario =
      load_scenario_text(kSmoothed, "s.toml", std::vector<std::string>{"filter.estimator=" + estimator});
  std::vector<TraceStep> steps;
  const Outcome outcome =
      make_experiment(scenario)->visit(run, [&](const TraceStep& step) { steps.push_back(step); });
  EXPECT_EQ(outcome, Outcome::ok);
  return steps;
}

/// The law of all states given all measurements, without any recursion: y = (x_0, v_1 … v_T) is Gaussian,
/// every state and measurement is linear in it.
struct WholeRun {
  std::vector<Vector> mean;
  std::vector<Matrix> covariance;

  /// From x̂_0 and the measurements of steps 1 … T.
  WholeRun(const Vector& prior, const std::vector<Vector>& z) {
    const Matrix F{{1.0, 0.5}, {-0.1, 0.9}}, G{{0.5}, {1.0}}, H{{1.0, 0.2}}, P0{{4.0, 1.0}, {1.0, 2.0}};
    const auto steps = static_cast<Index>(z.size());
    Matrix of_y = Matrix::Zero(2 + steps, 2 + steps);
    of_y.topLeftCorner(2, 2) = P0;
    of_y.bottomRightCorner(steps, steps) = 0.3 * Matrix::Identity(steps, steps);
    std::vector<Matrix> to_x{Matrix::Identity(2, 2 + steps)};
    Matrix to_z(steps, 2 + steps);
    Vector seen(steps);
    for (Index k = 1; k <= steps; ++k) {
      Matrix to = F * to_x.back();
      to.col(1 + k) += G;
      to_x.push_back(to);
      to_z.row(k - 1) = H * to;
      seen[k - 1] = z[static_cast<std::size_t>(k - 1)][0];
    }
    Vector y = Vector::Zero(2 + steps);
    y.head(2) = prior;
    const Matrix S = to_z * of_y * to_z.transpose() + 0.5 * Matrix::Identity(steps, steps);
    const Matrix K = of_y * to_z.transpose() * S.inverse();
    const Vector posterior = y + K * (seen - to_z * y);
    const Matrix P = of_y - K * to_z * of_y;
    for (const Matrix& to : to_x) {
      mean.push_back(to * posterior);
      covariance.push_back(to * P * to.transpose());
    }
  }
};

TEST(SmootherExperiment, ARunCanBeStopped) {
  const std::atomic<bool> stop = true;
  const auto experiment = make_experiment(
      load_scenario_text(kSmoothed, "s.toml", std::vector<std::string>{"filter.estimator=smoother"}));
  const StopScope scope(&stop);
  EXPECT_THROW(experiment->visit(0, [](const TraceStep&) {}), Stopped);
}

TEST(SmootherExperiment, EveryStepIsTheLawGivenAllMeasurements) {
  for (const std::int64_t run : {0, 5}) {
    const std::vector<TraceStep> filter = smoothed_steps("kalman", run),
                                 smoother = smoothed_steps("smoother", run);
    ASSERT_EQ(filter.size(), 13U);
    ASSERT_EQ(smoother.size(), 13U);
    std::vector<Vector> z;
    for (std::size_t k = 1; k < filter.size(); ++k) z.push_back(filter[k].z);
    const WholeRun expected(filter.front().estimate, z);
    for (std::size_t k = 0; k < smoother.size(); ++k) {
      const TraceStep& step = smoother[k];
      EXPECT_EQ(step.truth, filter[k].truth) << "the same run";
      EXPECT_LT((step.estimate - expected.mean[k]).norm(), 1e-11) << k;
      EXPECT_LT((step.P - expected.covariance[k]).norm(), 1e-11) << k;
      EXPECT_LT((step.error - (step.estimate - step.truth)).norm(), 1e-15) << k;
      EXPECT_EQ(step.nees_dof, 2);
      const double nees = step.error.dot(expected.covariance[k].inverse() * step.error);
      EXPECT_NEAR(step.nees, nees, 1e-9 * (1.0 + nees)) << k;
      EXPECT_EQ(step.nis_dof, 0) << "all innovations are spent";
      EXPECT_EQ(step.innovation().size(), 0);
    }
    // The last step knows no more than the filter.
    EXPECT_LT((smoother.back().P - filter.back().P).norm(), 1e-12);
    EXPECT_LT(smoother[6].P.trace(), 0.9 * filter[6].P.trace());
  }
}

TEST(SmootherExperiment, AChunkHasTheRunsOfItsTraces) {
  const Scenario scenario =
      load_scenario_text(kSmoothed, "s.toml", std::vector<std::string>{"filter.estimator=smoother"});
  const StudyStatistics chunk = make_experiment(scenario)->run_chunk(3, 4);
  EXPECT_EQ(chunk.runs, 4);
  Moments at_seven;
  for (std::int64_t run = 3; run < 7; ++run) at_seven.add(smoothed_steps("smoother", run)[7].nees);
  EXPECT_NEAR(chunk.steps[6][Quantity::nees].mean, at_seven.mean, 1e-12);
  EXPECT_EQ(chunk.steps[6].nees_dof, 8);
  EXPECT_EQ(chunk.steps[6][Quantity::nis].count, 0);
  EXPECT_EQ(chunk.nees_of_runs.first.size(), 4U);
}

}  // namespace
}  // namespace credence::internal
