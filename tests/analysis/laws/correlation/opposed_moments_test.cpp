#include "analysis/laws/correlation/opposed_moments.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

namespace credence::internal {
namespace {

using Random = std::mt19937_64;

double draw(Random& random) { return std::normal_distribution<double>()(random); }

// Sums 2 of eight values each: P(χ²(8) > 16) = 0.0423801 (scipy), of differences that are all 0; twice, as
// there are two.
TEST(OpposedMoments, OfKnownValues) {
  for (const double sign : {1.0, -1.0}) {
    VectorMoments moments;
    for (const double u : {1.0, -1.0, 1.0, -1.0, 1.0, 1.0, 1.0, -1.0}) moments.add(Vector{{u, sign * u}});
    EXPECT_NEAR(opposed_moments_p_value(moments, 1), 2.0 * 0.0423801, 1e-6);
  }
}

// A common error that is larger than claimed is in the sum alone, and the difference has its law: of the two
// one is tested at half the level.
TEST(OpposedMoments, HoldsItsLevelOfAnErrorThatAllShare) {
  Random random(5);
  constexpr int kStudies = 4000;
  for (const double sign : {1.0, -1.0}) {
    int alarms = 0;
    for (int i = 0; i < kStudies; ++i) {
      VectorMoments moments;
      for (int k = 0; k < 100; ++k) {
        const double shared = draw(random);
        moments.add(Vector{{draw(random) + shared, draw(random) + sign * shared}});
      }
      alarms += opposed_moments_p_value(moments, 1) <= 0.05;
    }
    EXPECT_NEAR(alarms / static_cast<double>(kStudies), 0.025, 5.0 * std::sqrt(0.025 * 0.975 / kStudies));
  }
}

// An error that decays, with a rough sensor and after it a fine one that has another sign, of filters whose
// Q, or R, is wrong by a factor; both updates use the same prior, or come in turn.
VectorMoments innovations(double Q, double R, bool one_prior, Random& random) {
  constexpr double kF = 0.9, kQ = 0.3, kRough = 1.0, kFine = 0.02;
  VectorMoments moments;
  for (int run = 0; run < 20; ++run) {
    double error = 0.0, P = 0.02;
    for (int k = 0; k < 100; ++k) {
      error = kF * error + std::sqrt(kQ) * draw(random);  // estimate less truth
      P = kF * kF * P + Q * kQ;
      const double z1 = std::sqrt(kRough) * draw(random), z2 = std::sqrt(kFine) * draw(random);
      const double S1 = P + R * kRough, nu1 = z1 - error, prior = error;
      error += P / S1 * nu1;
      P -= P * P / S1;
      const double S2 = P + R * kFine, nu2 = z2 + (one_prior ? prior : error);
      error -= P / S2 * nu2;
      P -= P * P / S2;
      moments.add(Vector{{nu1 / std::sqrt(S1), nu2 / std::sqrt(S2)}});
    }
  }
  return moments;
}

TEST(OpposedMoments, TellOnePriorFromNoiseThatIsWrongInOneDirection) {
  Random random(6);
  for (const auto& [Q, R] :
       {std::pair{1.0, 1.0}, {0.2, 1.0}, {5.0, 1.0}, {1.0, 0.25}, {1.0, 4.0}, {0.2, 0.25}}) {
    const VectorMoments in_turn = innovations(Q, R, false, random);
    EXPECT_GT(opposed_moments_p_value(in_turn, 1), 0.01) << Q << " " << R;
    if (Q * R != 1.0) EXPECT_GT(std::abs(in_turn.scatter(0, 1)), 0.1 * static_cast<double>(in_turn.count));
  }
  EXPECT_LT(opposed_moments_p_value(innovations(1.0, 1.0, true, random), 1), 1e-9);
}

TEST(OpposedMoments, NeedBothGroups) {
  EXPECT_EQ(opposed_moments_p_value({}, 1), 1.0);
  VectorMoments moments;
  moments.add(Vector{{1.0, 2.0}});
  EXPECT_THROW(opposed_moments_p_value(moments, 0), std::invalid_argument);
  EXPECT_THROW(opposed_moments_p_value(moments, 2), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
