#include "datasets/logs/conventions/reading_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace credence::internal {
namespace {

using RowsOfErrors = std::vector<Vector>;

ReadingFit fit_of(const RowsOfErrors& errors, const Matrix& P,
                  const std::vector<std::vector<Index>>& parts = {}) {
  return fit_reading(errors.size(), P.rows(), parts, [&](std::size_t i, Vector& error, Matrix& covariance) {
    error = errors[i];
    covariance = P;
    return true;
  });
}

RowsOfErrors gaussian_errors(int count, Index dim, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  RowsOfErrors errors;
  for (int i = 0; i < count; ++i) errors.push_back(Vector::NullaryExpr(dim, [&] { return normal(random); }));
  return errors;
}

TEST(ReadingFit, NumbersOfTwoRowsByHand) {
  // P = [2 1; 1 2] has determinant 3 and inverse [2 −1; −1 2]/3: ε = 2/3 of (1, 0), 2 of (1, −1).
  const Matrix P{{2.0, 1.0}, {1.0, 2.0}};
  const ReadingFit fit = fit_of({Vector{{1.0, 0.0}}, Vector{{1.0, -1.0}}}, P);
  EXPECT_NEAR(fit.nees, 4.0 / 3.0, 1e-14);
  EXPECT_NEAR(fit.log_likelihood, -0.5 * (4.0 / 3.0) - 0.5 * std::log(3.0), 1e-14);
  EXPECT_FALSE(fit.all_tested) << "two rows tell nothing of a mean";
}

TEST(ReadingFit, TheLargestRowIsBoundedByAllRowsAndTests) {
  // One row of twenty is far out: two tests of the whole and of both components make 6, two-sided. Of the
  // whole P(χ²₂ > x) = e^{−x/2}, and of one component erfc(√(x/2)), whatever comes first.
  RowsOfErrors errors(20, Vector{{0.5, -0.5}});
  errors[7] = Vector{{4.0, 4.0}};
  const ReadingFit fit = fit_of(errors, Matrix::Identity(2, 2));
  const double whole = 6.0 * 2.0 * 20.0 * std::exp(-16.0);
  const double component = 6.0 * 2.0 * 20.0 * std::erfc(std::sqrt(8.0));
  ASSERT_LT(whole, component);
  EXPECT_NEAR(fit.p_value, whole, 1e-10 * whole);
}

TEST(ReadingFit, APartSeesMoreOfItsOwnThanTheWhole) {
  // Two components of six are alike, and P says that they are opposed; each by itself is right.
  RowsOfErrors errors = gaussian_errors(60, 6, 3);
  for (Vector& e : errors) e[1] = std::sqrt(0.5) * (e[0] + e[1]);
  Matrix opposed = Matrix::Identity(6, 6);
  opposed(0, 1) = opposed(1, 0) = -0.3;
  const double whole = fit_of(errors, opposed).p_value, part = fit_of(errors, opposed, {{0, 1}}).p_value;
  EXPECT_LT(part, 0.1 * whole);
  // What is right gets no smaller by more tests.
  const RowsOfErrors right = gaussian_errors(400, 4, 4);
  const Matrix P = Matrix::Identity(4, 4);
  EXPECT_GE(fit_of(right, P, {{0, 1}}).p_value, fit_of(right, P).p_value);
}

TEST(ReadingFit, AnErrorThatStaysMisfitsOnlyFarOff) {
  RowsOfErrors errors = gaussian_errors(400, 3, 5);
  for (Vector& e : errors) e[2] = 0.1;  // a small one, of unit variance: mean NEES 2 of 3
  const ReadingFit small = fit_of(errors, Matrix::Identity(3, 3));
  EXPECT_FALSE(small.misfits()) << small.p_value;
  EXPECT_FALSE(small.fits()) << "it is not tested";
  for (Vector& e : errors) e[2] = 5.0;
  EXPECT_TRUE(fit_of(errors, Matrix::Identity(3, 3)).misfits());
}

TEST(ReadingFit, FalseAlarmsAreNoMoreThanItsLevel) {
  constexpr int kStudies = 400;
  int misfits = 0;
  for (int i = 0; i < kStudies; ++i) {
    misfits +=
        fit_of(gaussian_errors(200, 3, 100U + static_cast<unsigned>(i)), Matrix::Identity(3, 3), {{0, 1}})
            .misfits();
  }
  constexpr double kLevel = ReadingFit::kLevel;
  EXPECT_LE(misfits, kStudies * kLevel + 5.0 * std::sqrt(kStudies * kLevel * (1.0 - kLevel)));
}

TEST(ReadingFit, FactorsOnPAreFoundOnBothSides) {
  const RowsOfErrors errors = gaussian_errors(500, 3, 9);
  EXPECT_TRUE(fit_of(errors, Matrix::Identity(3, 3)).fits());
  EXPECT_TRUE(fit_of(errors, 2.0 * Matrix::Identity(3, 3)).misfits());
  EXPECT_TRUE(fit_of(errors, 0.5 * Matrix::Identity(3, 3)).misfits());
}

// The oracle is the fit with all its numbers: of rows that are correlated or not, few or many, and P times a
// factor.
TEST(ReadingFit, AskedNoMoreThanWhetherItMisfitsItSaysTheSame) {
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  int misfits = 0, fits = 0;
  for (const double memory : {0.0, 0.5, 0.9, 0.97, 0.995, 1.0}) {
    for (const int rows : {20, 40, 150, 600, 2000}) {
      for (const double factor : {0.3, 0.7, 0.85, 0.95, 1.0, 1.1, 1.3, 1.6, 3.0}) {
        RowsOfErrors errors;
        Vector e = Vector::NullaryExpr(3, [&] { return normal(random); });
        for (int k = 0; k < rows; ++k) {
          errors.push_back(e);
          for (double& x : e) x = memory * x + std::sqrt(1.0 - memory * memory) * normal(random);
        }
        const Matrix P = factor * Matrix::Identity(3, 3);
        const auto found =
            misfitting_reading(errors.size(), 3, {{0, 1}}, [&](std::size_t i, Vector& error, Matrix& C) {
              error = errors[i];
              C = P;
              return true;
            });
        const ReadingFit all = fit_of(errors, P, {{0, 1}});
        ASSERT_EQ(found.has_value(), all.misfits()) << memory << " " << rows << " " << factor;
        ++(found ? misfits : fits);
        if (found) EXPECT_EQ(found->nees, all.nees);
      }
    }
  }
  EXPECT_GT(misfits, 60);
  EXPECT_GT(fits, 60);
}

TEST(ReadingFit, WhatIsNoCovarianceOrCannotBeReadIsImpossible) {
  const RowsOfErrors errors = gaussian_errors(50, 2, 5);
  const Matrix P = Matrix::Identity(2, 2);
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  struct Hostile {
    Vector error;
    Matrix P;
    bool read;
  };
  const Hostile cases[] = {{errors[0], P, false},
                           {Vector{{nan, 0.0}}, P, true},
                           {Vector{{inf, 0.0}}, P, true},
                           {errors[0], Matrix{{1.0, 2.0}, {2.0, 1.0}}, true},
                           {errors[0], Matrix{{1.0, nan}, {nan, 1.0}}, true},
                           {errors[0], Matrix::Zero(2, 2), true}};
  for (const Hostile& hostile : cases) {
    const ReadingFit fit =
        fit_reading(errors.size(), 2, {}, [&](std::size_t i, Vector& e, Matrix& covariance) {
          const bool last = i + 1 == errors.size();
          e = last ? hostile.error : errors[i];
          covariance = last ? hostile.P : P;
          return !last || hostile.read;
        });
    EXPECT_TRUE(fit.misfits());
    EXPECT_FALSE(fit.fits());
    EXPECT_EQ(fit.log_likelihood, -inf);
    EXPECT_EQ(misfit_text(fit, 2), "no covariance, as it is not positive definite");
  }
  EXPECT_EQ(misfit_text({.nees = 12.125}, 6), "mean NEES 12.12 of 6");
}

}  // namespace
}  // namespace credence::internal
