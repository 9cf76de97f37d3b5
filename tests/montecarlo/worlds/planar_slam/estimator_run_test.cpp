#include "montecarlo/worlds/planar_slam/estimator_run.h"

#include <gtest/gtest.h>

#include "core/nan.h"
#include "core/record/normalised_error.h"

namespace credence::internal {
namespace {

Matrix correlated(double correlation) {
  Matrix P = Matrix::Identity(3, 3);
  P(1, 0) = P(0, 1) = correlation;
  return P;
}

TEST(SingularNees, CountsTheDirectionsOfNonZeroVariance) {
  SingularNees solver;
  const Vector e = Vector::Ones(3);
  EXPECT_DOUBLE_EQ(solver.solve(e, correlated(1.0)).value, 2.0);
  EXPECT_EQ(solver.solve(e, correlated(1.0)).dof, 2);
  EXPECT_EQ(solver.solve(e, correlated(1.0 + 1e-15)).dof, 2) << "rounding";
  EXPECT_EQ(solver.solve(e, Matrix::Zero(3, 3)).dof, 0);
}

// As a row of a log that is rejected: its NEES is infinite.
TEST(SingularNees, DoesNotJudgeAnErrorWhereCertaintyIsClaimed) {
  SingularNees solver;
  const auto dof = [&solver](const Vector& error, const Matrix& P) {
    return solver.judge(error, P, Vector::Zero(3)).dof;
  };
  EXPECT_EQ(dof(Vector{{1.0, 1.0 + 1e-6, 1.0}}, correlated(1.0)), 0);
  EXPECT_EQ(dof(Vector{{1.0, 1.0 + 1e-12, 1.0}}, correlated(1.0)), 2) << "rounding";
  EXPECT_EQ(dof(Vector{{1.0, -1.0, 1.0}}, correlated(0.5)), 3);
  Matrix known = correlated(0.0);
  known(2, 2) = 0.0;
  EXPECT_EQ(dof(Vector{{1.0, 1.0, 1e-6}}, known), 0);
  EXPECT_EQ(dof(Vector{{1.0, 1.0, 1e-12}}, known), 2) << "rounding";
}

// A study and the log that it writes have the same dof.
TEST(SingularNees, HasTheDofOfALog) {
  SingularNees solver;
  const Vector e{{1.0, 1.0, 1.0}};
  for (const double correlation :
       {0.9, 1.0 - 1e-9, 1.0 - 1e-12, 1.0 - 1e-13, 1.0 - 1e-15, 1.0, 1.0 + 1e-13}) {
    const NormalisedError of_log = normalised_error(e, correlated(correlation));
    ASSERT_TRUE(of_log.ok) << correlation - 1.0;
    const NeesValue nees = solver.solve(e, correlated(correlation));
    EXPECT_EQ(nees.dof, of_log.dof) << correlation - 1.0;
    EXPECT_NEAR(nees.value, of_log.value, 1e-12) << correlation - 1.0;
  }
  EXPECT_EQ(solver.solve(e, correlated(1.0 - 1e-13)).dof, 3);
}

// Of an estimate of 9.5 a σ of 1e-18 is rounding, however it is correlated; of one of 0 it is a σ.
TEST(SingularNees, LeavesOutWhatIsCertainOfItsEstimate) {
  SingularNees solver;
  Matrix P = Vector{{1e-36, 1.0, 4.0}}.asDiagonal();
  P(1, 0) = 0.5e-18;
  const Vector e{{1e-15, 1.0, 2.0}};
  const NeesValue known = solver.solve(e, P, Vector{{9.5, 1.0, 1.0}});
  EXPECT_EQ(known.dof, 2);
  EXPECT_NEAR(known.value, 2.0, 1e-12);
  const NeesValue open = solver.solve(e, P, Vector{{0.0, 1.0, 1.0}});
  EXPECT_EQ(open.dof, 3);
  EXPECT_GT(open.value, 1e5);
}

TEST(SingularNees, KnowsNoValueOfWhatIsNoCovariance) {
  SingularNees solver;
  const Vector e = Vector::Ones(3);
  EXPECT_EQ(solver.solve(e, correlated(2.0)).dof, -1);
  EXPECT_EQ(solver.solve(e, correlated(1.0 + 1e-9)).dof, -1);
  EXPECT_EQ(solver.solve(e, correlated(kNaN)).dof, -1);
  Matrix certain = correlated(0.5);
  certain(0, 0) = 0.0;
  EXPECT_EQ(solver.solve(e, certain).dof, -1) << "a covariance with a state that is known";
  Matrix negative = correlated(0.5);
  negative(2, 2) = -1.0;
  EXPECT_EQ(solver.solve(e, negative).dof, -1);
  EXPECT_EQ(solver.solve(Vector::Constant(3, kNaN), correlated(1.0)).dof, -1);
  EXPECT_EQ(solver.solve(e, correlated(0.5)).dof, 3) << "the next one is as if there had been none before";
}

}  // namespace
}  // namespace credence::internal
