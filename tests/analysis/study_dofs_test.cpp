#include "analysis/study_dofs.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace credence {
namespace {

TEST(StudyDofs, AreTheSumsOfEveryStep) {
  StudyStatistics statistics;
  statistics.steps.resize(2);
  statistics.steps[0].nees_dof = 6;
  statistics.steps[1].nees_dof = 8;
  statistics.steps[1].nis_dof = 3;
  EXPECT_EQ(study_dofs(statistics, Quantity::nees), (std::vector<double>{6.0, 8.0}));
  EXPECT_EQ(study_dofs(statistics, Quantity::nis), (std::vector<double>{0.0, 3.0}));
  EXPECT_THROW(study_dofs(statistics, Quantity::trace), std::invalid_argument);
}

}  // namespace
}  // namespace credence
