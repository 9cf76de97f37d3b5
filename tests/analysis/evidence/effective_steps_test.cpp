#include "analysis/evidence/effective_steps.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "analysis/laws/effective_sample.h"

namespace credence {
namespace {

TEST(EffectiveSteps, RunsAreTheRowsOfTheEmpiricalLaw) {
  const Matrix nees{{1.0, 2.0, 0.5}, {3.0, 2.5, 1.0}, {0.2, 0.1, 4.0}, {2.0, 3.0, 1.5}};
  std::vector<std::vector<double>> runs;
  for (Index run = 0; run < nees.rows(); ++run) runs.emplace_back(nees.row(run).begin(), nees.row(run).end());
  EXPECT_EQ(measured_effective_steps(runs), empirical_nees_time_law(nees).effective_steps);
  EXPECT_THROW(measured_effective_steps(std::span(runs).first(1)), std::invalid_argument);
  runs[3].pop_back();
  EXPECT_THROW(measured_effective_steps(runs), std::invalid_argument);
}

}  // namespace
}  // namespace credence
