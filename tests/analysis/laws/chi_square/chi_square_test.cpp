#include "analysis/laws/chi_square/chi_square.h"

#include <gtest/gtest.h>

#include <boost/math/special_functions/gamma.hpp>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace credence::internal {
namespace {

struct TableRow {
  double dof, probability, quantile;
};

// Computed apart from this library: Newton's method on the power series of the regularised incomplete gamma
// function, 40 digits (mpmath); dof 1 as 2 erf⁻¹(p)², dof 2 as −2 ln(1 − p).
constexpr TableRow kTable[] = {
    {1, 0.0005, 3.9269913310292249125e-7},    {1, 0.005, 0.000039270422220515902135},
    {1, 0.025, 0.00098206911717525591234},    {1, 0.5, 0.45493642311957275194},
    {1, 0.975, 5.0238861873148889562},        {1, 0.995, 7.8794385766224173574},
    {1, 0.9995, 12.115665146397175901},       {2, 0.0005, 0.0010002500833645958385},
    {2, 0.005, 0.010025083647088564086},      {2, 0.025, 0.050635615968579750807},
    {2, 0.5, 1.3862943611198906188},          {2, 0.975, 7.3777589082278726057},
    {2, 0.995, 10.596634733096073355},        {2, 0.9995, 15.201804919084164723},
    {3, 0.0005, 0.01527896724324294892},      {3, 0.005, 0.071721774586491976495},
    {3, 0.025, 0.21579528262389786845},       {3, 0.5, 2.3659738843753382661},
    {3, 0.975, 9.3484036044961477961},        {3, 0.995, 12.838156466598651741},
    {3, 0.9995, 17.729996228945926883},       {7, 0.0005, 0.4848749910269358609},
    {7, 0.005, 0.98925568313295026784},       {7, 0.025, 1.6898691806773545806},
    {7, 0.5, 6.3458111955215175357},          {7, 0.975, 16.012764274629324233},
    {7, 0.995, 20.277739874962624858},        {7, 0.9995, 26.017767709014762923},
    {30, 0.0005, 10.804364672440002742},      {30, 0.005, 13.786719859502713183},
    {30, 0.025, 16.79077226556662494},        {30, 0.5, 29.336031516661585933},
    {30, 0.975, 46.97924224367115662},        {30, 0.995, 53.671961930240591422},
    {30, 0.9995, 62.161852869180648953},      {1000, 0.0005, 859.36150558063028186},
    {1000, 0.005, 888.56352318146832384},     {1000, 0.025, 914.25715379925893461},
    {1000, 0.5, 999.33341240338096875},       {1000, 0.975, 1089.5309127749134998},
    {1000, 0.995, 1118.9480663231916526},     {1000, 0.9995, 1153.7378500648333273},
    {1000000, 0.0005, 995353.0431881858826},  {1000000, 0.005, 996360.98393538223538},
    {1000000, 0.025, 997230.08714329010253},  {1000000, 0.5, 999999.33333341234574},
    {1000000, 0.975, 1002773.7014679260262},  {1000000, 0.995, 1003646.5292584807566},
    {1000000, 0.9995, 1004660.0602293107867},
};

TEST(ChiSquare, QuantilesAgreeWithIndependentTable) {
  for (const TableRow& row : kTable) {
    const double tolerance = 1e-11 * row.quantile;
    EXPECT_NEAR(chi_square_quantile(row.probability, row.dof), row.quantile, tolerance) << row.dof;
    EXPECT_NEAR(chi_square_cdf(row.quantile, row.dof), row.probability, 1e-11 * row.probability);
    EXPECT_NEAR(chi_square_survival(row.quantile, row.dof), 1.0 - row.probability, 1e-12);
    // 1 − p rounds, which the quantile magnifies by 1 / (density × quantile).
    const double rounding = 1e-16 / (chi_square_density(row.quantile, row.dof));
    EXPECT_NEAR(chi_square_upper_quantile(1.0 - row.probability, row.dof), row.quantile,
                tolerance + rounding);
  }
}

// scipy.stats.f.sf; F of 2 and 2 dof is 1/(1 + x), and turned round it is the other tail.
TEST(ChiSquare, TheRatioOfTwoIsF) {
  EXPECT_NEAR(f_survival(3.0, 2.0, 2.0), 0.25, 1e-15);
  EXPECT_NEAR(f_survival(2.5, 5.0, 9.0), 0.10997418756336795, 1e-14);
  EXPECT_NEAR(f_survival(40.0, 17.0, 17.0), 2.071764997354669e-10, 1e-21);
  EXPECT_NEAR(f_survival(1.0 / 2.5, 9.0, 5.0), 1.0 - f_survival(2.5, 5.0, 9.0), 1e-14);
  EXPECT_EQ(f_survival(-1.0, 3.0, 4.0), 1.0);
  EXPECT_EQ(f_survival(std::numeric_limits<double>::infinity(), 3.0, 4.0), 0.0);
  EXPECT_TRUE(std::isnan(f_survival(std::nan(""), 3.0, 4.0)));
  EXPECT_THROW(f_survival(1.0, 0.0, 4.0), std::invalid_argument);
  EXPECT_THROW(f_survival(1.0, 3.0, -1.0), std::invalid_argument);
}

TEST(ChiSquare, MatchesPrintedTable) {
  // [Bar-Shalom 2001], table 1.5.4-1.
  EXPECT_NEAR(chi_square_quantile(0.025, 30.0), 16.791, 5e-4);
  EXPECT_NEAR(chi_square_quantile(0.975, 100.0), 129.561, 5e-4);
  EXPECT_NEAR(chi_square_quantile(0.025, 100.0), 74.222, 5e-4);
}

TEST(ChiSquare, EvenDofIsAPoissonSum) {
  // P(χ²(2k) > x) = e^{−x/2} Σ_{j<k} (x/2)^j / j!
  for (const int k : {1, 2, 5, 40}) {
    for (const double x : {0.1, 3.0, 20.0, 90.0}) {
      double term = std::exp(-0.5 * x);
      double sum = 0.0;
      for (int j = 0; j < k; ++j) {
        sum += term;
        term *= 0.5 * x / (j + 1);
      }
      EXPECT_NEAR(chi_square_survival(x, 2.0 * k), sum, 1e-13) << "k " << k << " x " << x;
    }
  }
}

// Against the incomplete gamma function in long double, in both tails and where the two sums meet.
TEST(ChiSquare, OfEvenDofKeepsItsDigitsInBothTails) {
  for (const double dof : {4.0, 6.0, 20.0, 62.0, 64.0}) {
    for (const double ratio : {1e-3, 0.1, 0.5, 0.999, 1.0, 1.001, 2.0, 5.0}) {
      const double x = ratio * dof;
      const double exact = static_cast<double>(boost::math::gamma_p(0.5L * dof, 0.5L * x));
      EXPECT_NEAR(chi_square_cdf(x, dof), exact, 1e-13 * exact) << x << " of " << dof;
    }
    EXPECT_EQ(chi_square_cdf(1e300, dof), 1.0);
    EXPECT_EQ(chi_square_cdf(5e-324, dof), 0.0);
  }
}

TEST(ChiSquare, QuantileInvertsForHugeDof) {
  for (const double dof : {1e6, 1e7, 1e8, 9.9e8, 1e9, 1.1e9, 1e12}) {
    for (const double p : {1e-12, 1e-4, 0.025, 0.5}) {
      EXPECT_NEAR(chi_square_cdf(chi_square_quantile(p, dof), dof) / p, 1.0, 1e-6) << dof << " " << p;
      EXPECT_NEAR(chi_square_survival(chi_square_upper_quantile(p, dof), dof) / p, 1.0, 1e-6) << dof;
    }
  }
}

TEST(ChiSquare, ApproximationMeetsExactLawWhereTheyJoin) {
  for (const double p : {1e-6, 0.025, 0.5, 0.975}) {
    const double below = (chi_square_quantile(p, 1e9) - 1e9) / std::sqrt(2e9);
    const double above_dof = std::nextafter(1e9, 2e9);
    const double above = (chi_square_quantile(p, above_dof) - above_dof) / std::sqrt(2.0 * above_dof);
    EXPECT_NEAR(below, above, 1e-6) << p;
    EXPECT_NEAR(chi_square_density(1e9, 1e9) / chi_square_density(1e9, above_dof), 1.0, 1e-6);
  }
}

TEST(ChiSquare, MeanBoundsScaleWithCount) {
  // 50 runs of a state of 2: the 95 % region of the ANEES is [74.222, 129.561] / 50.
  const ChiSquareBounds bounds = mean_bounds(100.0, 50.0, 0.95);
  EXPECT_NEAR(bounds.lower, 74.2219 / 50.0, 1e-5);
  EXPECT_NEAR(bounds.upper, 129.5612 / 50.0, 1e-5);
}

TEST(ChiSquare, PValueMeetsConfidenceAtTheBounds) {
  for (const double dof : {1.0, 7.0, 300.0, 1e5, 1e9}) {
    const ChiSquareBounds bounds = mean_bounds(dof, 1.0, 0.99);
    EXPECT_NEAR(two_sided_p_value(bounds.lower, dof), 0.01, 1e-8);
    EXPECT_NEAR(two_sided_p_value(bounds.upper, dof), 0.01, 1e-8);
    for (const double x : {0.3 * dof, 0.9 * dof, dof - 0.7, dof - 0.6, dof, 1.1 * dof, 3.0 * dof}) {
      const double smaller = std::min(chi_square_cdf(x, dof), chi_square_survival(x, dof));
      EXPECT_EQ(two_sided_p_value(x, dof), std::min(1.0, 2.0 * smaller)) << x << " of " << dof;
    }
  }
}

TEST(ChiSquare, TailMeansAgreeWithQuadrature) {
  // E[X; X > q] = dof P(χ²(dof + 2) > q), another identity than the one used.
  for (const double dof : {0.7, 1.0, 2.0, 3.0, 50.0, 2e4}) {
    for (const double p : {1e-9, 0.0125, 0.4, 0.9}) {
      const double upper = chi_square_upper_quantile(p, dof);
      const double lower = chi_square_quantile(p, dof);
      const double expected_upper = dof * chi_square_survival(upper, dof + 2.0) / p;
      const double expected_lower = dof * chi_square_cdf(lower, dof + 2.0) / p;
      EXPECT_NEAR(chi_square_upper_tail_mean(p, dof), expected_upper, 1e-9 * expected_upper);
      EXPECT_NEAR(chi_square_lower_tail_mean(p, dof), expected_lower, 1e-9 * (lower + 1e-3 * dof));
    }
  }
  EXPECT_EQ(chi_square_upper_tail_mean(1.0, 3.0), 3.0);
  EXPECT_EQ(chi_square_lower_tail_mean(1.0, 3.0), 3.0);
}

TEST(ChiSquare, TailMeanOfManyDofIsTheNormalOne) {
  // φ(1.96) / 0.025 = 2.3378 standard deviations, up to the skewness of order 1/√dof.
  for (const double dof : {1e8, 1e10}) {
    const double deviations = (chi_square_upper_tail_mean(0.025, dof) - dof) / std::sqrt(2.0 * dof);
    EXPECT_NEAR(deviations, 2.3378, 1e-3) << dof;
  }
}

TEST(ChiSquare, ExtremeStatisticsAreData) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  for (const double dof : {1.0, 1e3, 1e6, 1e9, 1e12}) {
    EXPECT_EQ(two_sided_p_value(kInf, dof), 0.0);
    EXPECT_EQ(two_sided_p_value(1e300, dof), 0.0);
    EXPECT_EQ(two_sided_p_value(0.0, dof), 0.0);
    EXPECT_EQ(two_sided_p_value(-1.0, dof), 0.0);
    EXPECT_TRUE(std::isnan(two_sided_p_value(std::nan(""), dof)));
    EXPECT_EQ(chi_square_cdf(kInf, dof), 1.0);
    EXPECT_EQ(chi_square_quantile(0.0, dof), 0.0);
    EXPECT_EQ(chi_square_quantile(1.0, dof), kInf);
    EXPECT_EQ(chi_square_upper_quantile(0.0, dof), kInf);
  }
}

TEST(ChiSquare, RejectsImpossibleArguments) {
  EXPECT_THROW(chi_square_cdf(1.0, 0.0), std::invalid_argument);
  EXPECT_THROW(chi_square_cdf(1.0, -2.0), std::invalid_argument);
  EXPECT_THROW(chi_square_cdf(1.0, std::nan("")), std::invalid_argument);
  EXPECT_THROW(chi_square_quantile(1.5, 1.0), std::invalid_argument);
  EXPECT_THROW(chi_square_quantile(std::nan(""), 1.0), std::invalid_argument);
  EXPECT_THROW(mean_bounds(10.0, 0.0, 0.95), std::invalid_argument);
  EXPECT_THROW(mean_bounds(10.0, 5.0, 1.0), std::invalid_argument);
  EXPECT_THROW(mean_bounds(10.0, 5.0, 95.0), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
