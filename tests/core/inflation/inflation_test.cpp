#include "core/inflation/inflation.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <random>
#include <stdexcept>

#include "core/models/linear_model.h"

namespace credence::internal {
namespace {

Matrix random_covariance(Index n, Index rank, unsigned seed) {
  std::mt19937_64 bits(seed);
  std::normal_distribution<double> normal;
  Matrix root(n, rank);
  for (double& entry : root.reshaped()) entry = normal(bits);
  Matrix P = root * root.transpose();
  P.triangularView<Eigen::StrictlyUpper>() = P.transpose();
  return P;
}

double min_eigenvalue(const Matrix& M) {
  return Eigen::SelfAdjointEigenSolver<Matrix>(M, Eigen::EigenvaluesOnly).eigenvalues()(0);
}

/// Whether the pair of states belongs to one block of the set, to the set, or to nothing that may change.
enum class Place { block, off_block, outside };
Place place(Index i, Index j, const BlockLayout& layout, Inflation inflation) {
  const auto block = [&](Index s) {
    return s < layout.vehicle ? Index{-1} : (s - layout.vehicle) / layout.landmark;
  };
  if (inflation == Inflation::map && (i < layout.vehicle || j < layout.vehicle)) return Place::outside;
  return block(i) == block(j) ? Place::block : Place::off_block;
}

struct Case {
  BlockLayout layout;
  Inflation inflation;
  InflationSolution solution;
};

class InflateProperties : public testing::TestWithParam<Case> {};

TEST_P(InflateProperties, BlockDiagonalToTheLastBitPsdAndNothingElseTouched) {
  const auto& [layout, inflation, solution] = GetParam();
  const Index n = layout.state_dim();
  for (Index rank : {Index{1}, Index{2}, n, n + 3}) {
    const Matrix P = random_covariance(n, rank, static_cast<unsigned>(17 + rank));
    Matrix D = P;
    inflate(D, layout, inflation, solution);
    for (Index i = 0; i < n; ++i) {
      for (Index j = 0; j < n; ++j) {
        EXPECT_EQ(D(i, j), D(j, i)) << i << ", " << j;
        const Place where = place(i, j, layout, inflation);
        if (where == Place::off_block) {
          EXPECT_EQ(D(i, j), 0.0) << i << ", " << j;
        }
        if (where == Place::outside) {
          EXPECT_EQ(D(i, j), P(i, j)) << i << ", " << j;
        }
      }
    }
    EXPECT_GE(min_eigenvalue(D - P), -1e-13 * P.trace()) << "rank " << rank;
  }
}

constexpr BlockLayout kMonobot{.vehicle = 1, .landmark = 1, .landmarks = 6};
constexpr BlockLayout kPlanar{.vehicle = 3, .landmark = 2, .landmarks = 5};
constexpr BlockLayout kBody{.vehicle = 2, .landmark = 3, .landmarks = 3};
constexpr BlockLayout kLarge{.vehicle = 6, .landmark = 4, .landmarks = 2};
constexpr BlockLayout kPoint{.vehicle = 2, .landmark = 2, .landmarks = 3};

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const BlockLayout& layout : {kMonobot, kPlanar, kBody, kLarge, kPoint}) {
    for (Inflation inflation : {Inflation::full, Inflation::map}) {
      for (InflationSolution solution : {InflationSolution::pairwise, InflationSolution::min_trace}) {
        all.push_back({layout, inflation, solution});
      }
    }
  }
  return all;
}
INSTANTIATE_TEST_SUITE_P(Layouts, InflateProperties, testing::ValuesIn(cases()));

TEST(Inflate, NoneLeavesTheCovarianceAlone) {
  const Matrix P = random_covariance(13, 13, 1);
  Matrix D = P;
  inflate(D, kPlanar, Inflation::none, InflationSolution::pairwise);
  EXPECT_TRUE(D == P);
}

TEST(Inflate, RejectsWhatItCannotDo) {
  Matrix P = Matrix::Identity(4, 4);
  EXPECT_THROW(inflate(P, kPlanar, Inflation::full, InflationSolution::pairwise), std::invalid_argument);
  EXPECT_THROW(inflate(P, kPlanar, Inflation::none, InflationSolution::pairwise), std::invalid_argument);
  Matrix P13 = Matrix::Identity(13, 13);
  EXPECT_THROW(inflate(P13, kPlanar, Inflation::map, InflationSolution::sequential), std::invalid_argument);
}

TEST(Inflate, OneLandmarkMapIsTheOptimalFilter) {
  const BlockLayout layout{.vehicle = 3, .landmark = 2, .landmarks = 1};
  const Matrix P = random_covariance(5, 5, 3);
  Matrix D = P;
  inflate(D, layout, Inflation::map, InflationSolution::pairwise);
  EXPECT_TRUE(D == P);
}

TEST(Inflate, TheSecondStepOfTheMonobotByHand) {
  // Q = R = 0.1, P0 = I, N = 1: step 1 finds nothing to remove; S = 1.1 + 1 + 0.1, so that after its update
  // cov(r, f) = 1.1/2.2 = 0.5. Full inflation then adds |0.5| to both variances, and removes the covariance.
  const LinearModel model = monobot_model(1, 0, 0.1, 0.1, 1.0);
  Matrix P = model.P0 + model.G * model.Q * model.G.transpose();
  MinTraceState state;
  EXPECT_EQ(inflate(P, model.layout, Inflation::full, InflationSolution::min_trace, state).added_trace, 0.0);
  P -= P * model.H.transpose() * model.H * P / 2.2;
  EXPECT_NEAR(P(0, 1), 0.5, 1e-15);
  Matrix D = P;
  EXPECT_NEAR(inflate(D, model.layout, Inflation::full, InflationSolution::pairwise, state).added_trace, 1.0,
              1e-14);
  EXPECT_NEAR(D(0, 0), P(0, 0) + 0.5, 1e-14);
  EXPECT_NEAR(D(1, 1), P(1, 1) + 0.5, 1e-14);
  EXPECT_EQ(D(0, 1), 0.0);
}

TEST(Inflate, ReturnsTheCertificateOfTheExactSolution) {
  const Matrix P = random_covariance(13, 13, 8);
  MinTraceState state;
  Matrix D = P;
  const InflationStep step = inflate(D, kPlanar, Inflation::map, InflationSolution::min_trace, state);
  EXPECT_TRUE(step.converged);
  EXPECT_LT(step.relative_gap, 1e-9);
  EXPECT_NEAR(step.added_trace, (D - P).trace(), 1e-12 * P.trace());
  Matrix pairwise = P;
  EXPECT_LT(step.added_trace,
            inflate(pairwise, kPlanar, Inflation::map, InflationSolution::pairwise, state).added_trace);
}

/// Monobot with Q = R = 0.1, P0 = I after 100 steps of predict, inflate, update (theory, section 6).
struct Reference {
  Index landmarks, anchors;
  Inflation inflation;
  double prior_trace, posterior_trace, vehicle, landmark, gain;
};

class MonobotReference : public testing::TestWithParam<std::tuple<Reference, InflationSolution>> {};

TEST_P(MonobotReference, Step100) {
  const auto& [expected, solution] = GetParam();
  const LinearModel model = monobot_model(expected.landmarks, expected.anchors, 0.1, 0.1, 1.0);
  Matrix P = model.P0, K;
  double prior_trace = 0.0;
  for (int step = 0; step < 100; ++step) {
    P += model.G * model.Q * model.G.transpose();
    inflate(P, model.layout, expected.inflation, solution);
    prior_trace = P.trace();
    const Matrix S = model.H * P * model.H.transpose() + model.R;
    K = S.ldlt().solve(model.H * P).transpose();
    const Matrix I_KH = Matrix::Identity(P.rows(), P.rows()) - K * model.H;
    P = I_KH * P * I_KH.transpose() + K * model.R * K.transpose();
  }
  EXPECT_NEAR(prior_trace, expected.prior_trace, 1e-8);
  EXPECT_NEAR(P.trace(), expected.posterior_trace, 1e-8);
  EXPECT_NEAR(P(0, 0), expected.vehicle, 1e-8);
  EXPECT_NEAR(P(1, 1), expected.landmark, 1e-8);
  EXPECT_NEAR(K(1, expected.anchors), expected.gain, 1e-8);
}

INSTANTIATE_TEST_SUITE_P(
    TheorySection6, MonobotReference,
    testing::Combine(
        testing::Values(
            Reference{1, 0, Inflation::none, 1.236649890, 1.136649890, 0.599226644, 0.537423246, 0.0},
            Reference{1, 0, Inflation::full, 11.817165939, 5.957736652, 2.979291469, 2.978445182,
                      0.491572936},
            Reference{1, 1, Inflation::none, 0.139121585, 0.039096455, 0.037101323, 0.001995132, 0.009975660},
            Reference{1, 1, Inflation::full, 0.223606798, 0.089442719, 0.044721360, 0.044721360, 0.276393202},
            Reference{2, 0, Inflation::none, 1.179345194, 1.079335114, 0.383847064, 0.347744025, 0.004995005},
            Reference{2, 0, Inflation::full, 12.705589127, 4.365422020, 1.433954337, 1.465733842,
                      0.651148708},
            Reference{2, 0, Inflation::map, 1.872825161, 1.165749407, 0.383847064, 0.390951171, 0.437066470}),
        testing::Values(InflationSolution::pairwise, InflationSolution::min_trace)));

}  // namespace
}  // namespace credence::internal
