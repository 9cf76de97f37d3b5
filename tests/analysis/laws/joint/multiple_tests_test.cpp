#include "analysis/laws/joint/multiple_tests.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include "tests/analysis/evidence/synthetic_studies.h"

namespace credence::internal {
namespace {

using ::testing::DoubleNear;
using ::testing::Pointwise;

MATCHER(NearlyEqual, "") { return std::abs(std::get<0>(arg) - std::get<1>(arg)) < 1e-12; }

TEST(MultipleTests, KnownAdjustments) {
  // By hand; the same as p.adjust of R for this vector.
  const std::vector<double> p{0.01, 0.04, 0.03, 0.005};
  EXPECT_THAT(holm(p), Pointwise(NearlyEqual(), std::vector<double>{0.03, 0.06, 0.06, 0.02}));
  const double c = 1.0 + 0.5 + 1.0 / 3.0 + 0.25;
  EXPECT_THAT(benjamini_yekutieli(p),
              Pointwise(NearlyEqual(), std::vector<double>{0.02 * c, 0.04 * c, 0.04 * c, 0.02 * c}));
}

TEST(MultipleTests, OneTestIsUnchangedAndNoneIsNone) {
  const std::vector<double> one{0.2};
  EXPECT_EQ(holm(one), one);
  EXPECT_EQ(benjamini_yekutieli(one), one);
  EXPECT_TRUE(holm({}).empty());
}

TEST(MultipleTests, TestsWithoutDataAreNoMembers) {
  const std::vector<double> p{0.02, std::nan(""), 0.5};
  const std::vector<double> by_holm = holm(p), by_by = benjamini_yekutieli(p);
  EXPECT_NEAR(by_holm[0], 0.04, 1e-12);
  EXPECT_TRUE(std::isnan(by_holm[1]));
  EXPECT_NEAR(by_holm[2], 0.5, 1e-12);
  EXPECT_NEAR(by_by[0], 0.04 * 1.5, 1e-12);
  EXPECT_TRUE(std::isnan(by_by[1]));
  EXPECT_NEAR(by_by[2], 0.5 * 1.5, 1e-12);
  EXPECT_THROW(holm(std::vector<double>{1.1}), std::invalid_argument);
  EXPECT_THROW(benjamini_yekutieli(std::vector<double>{-0.1}), std::invalid_argument);
}

TEST(MultipleTests, ErrorRatesAreKept) {
  // 40 tests of which 10 are far from their hypothesis: Holm keeps P(any false) ≤ 5 %, Benjamini and
  // Yekutieli the share of false discoveries, of independent tests at 5 % × 30/40 / Σ 1/i exactly.
  constexpr int kStudies = 4000;
  std::mt19937_64 generator(2);
  std::uniform_real_distribution<double> uniform;
  int any_false = 0;
  double false_share = 0.0;
  double found = 0.0;
  for (int study = 0; study < kStudies; ++study) {
    std::vector<double> p(40);
    for (std::size_t i = 0; i < 40; ++i) p[i] = i < 10 ? 1e-3 * uniform(generator) : uniform(generator);
    const std::vector<double> by_holm = holm(p);
    const std::vector<double> by_by = benjamini_yekutieli(p);
    any_false += std::any_of(by_holm.begin() + 10, by_holm.end(), [](double q) { return q <= 0.05; });
    const auto discoveries = std::count_if(by_by.begin(), by_by.end(), [](double q) { return q <= 0.05; });
    const auto wrong = std::count_if(by_by.begin() + 10, by_by.end(), [](double q) { return q <= 0.05; });
    false_share += discoveries == 0 ? 0.0 : static_cast<double>(wrong) / static_cast<double>(discoveries);
    found += static_cast<double>(discoveries - wrong) / 10.0;
  }
  EXPECT_LE(any_false, kStudies * (0.05 + 5.0 * test::binomial_standard_error(0.05, kStudies)));
  EXPECT_GE(any_false, kStudies * 0.02);
  // Nearly always none or one of eleven: a standard deviation of 0.03.
  EXPECT_NEAR(false_share / kStudies, 0.0375 / 4.278543, 5.0 * 0.03 / std::sqrt(kStudies));
  EXPECT_GT(found / kStudies, 0.99);
}

}  // namespace
}  // namespace credence::internal
