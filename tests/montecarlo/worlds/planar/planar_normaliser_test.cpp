#include "montecarlo/worlds/planar/planar_normaliser.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "core/linear_algebra/decompositions.h"
#include "montecarlo/worlds/planar/planar_simulation.h"

namespace credence::internal {
namespace {

/// A world of so many landmarks, of which a filter knows some, with an error and P of full rank.
struct KnownPartOfMap {
  PlanarWorld world;
  std::vector<int> landmarks;
  Vector estimate, error;
  Matrix P;

  KnownPartOfMap(Index of_world, std::vector<int> known) : landmarks(std::move(known)) {
    world.landmarks.assign(static_cast<std::size_t>(of_world), Point(0.0, 0.0));
    const Index n = 3 + 2 * std::ssize(landmarks);
    std::mt19937_64 bits(static_cast<unsigned>(n));
    std::normal_distribution<double> normal;
    Matrix A(n, n + 1);
    for (double& a : A.reshaped()) a = normal(bits);
    P = Matrix(A * A.transpose()).selfadjointView<Eigen::Lower>();
    estimate.resize(n);
    error.resize(n);
    for (double& x : estimate) x = 10.0 * normal(bits);
    for (double& x : error) x = normal(bits);
  }

  NormalisedStep normalised(std::int64_t step) const {
    NeesSolver factor;
    factor.keep_lead(3);
    factor.solve(error, P);
    NormalisedStep told;
    told.step = step;
    EXPECT_TRUE(PlanarNormaliser(world, {}).normalise_state(estimate, error, P, factor, landmarks, told));
    return told;
  }

  double square_of(const std::vector<Index>& places) const {
    const Vector e = error(places);
    return e.dot(Eigen::FullPivLU<Matrix>(P(places, places)).solve(e));
  }
};

std::vector<int> every_second(int count) {
  std::vector<int> numbers;
  for (int i = 0; i < count; ++i) numbers.push_back((2 * i + 1) % (2 * count + 1));
  return numbers;
}

std::vector<Index> places_from(Index first, Index end) {
  std::vector<Index> places(static_cast<std::size_t>(end - first));
  std::iota(places.begin(), places.end(), first);
  return places;
}

// Maps on both sides of the size from which another factorisation is used, and with more landmarks than have
// a block of their own; the blocks are those of planar_layout.
TEST(PlanarNormaliser, every_block_is_that_of_its_own_covariance) {
  for (const int count : {0, 1, 5, 14, 15, 40, 60}) {
    const KnownPartOfMap map(2 * count + 1, every_second(count));
    const NormalisedStep told = map.normalised(1);
    const RunLayout layout = planar_layout(map.world);
    const Index n = map.error.size();
    ASSERT_EQ(told.blocks.size(), layout.blocks.size()) << count;
    EXPECT_EQ(told.whole.dof, n);
    const double whole = map.square_of(places_from(0, n));
    EXPECT_NEAR(told.whole.value, whole, 1e-8 * whole) << count;
    for (std::size_t b = 0; b < layout.blocks.size(); ++b) {
      std::vector<Index> places;
      for (const Index state : layout.blocks[b].states) {
        const auto found = std::ranges::find(told.states, state);
        if (found != told.states.end()) places.push_back(found - told.states.begin());
      }
      if (places.empty()) {
        EXPECT_EQ(told.blocks[b].dof, -1) << layout.blocks[b].name;
        continue;
      }
      EXPECT_EQ(told.blocks[b].dof, std::ssize(places)) << layout.blocks[b].name;
      const double expected = map.square_of(places);
      EXPECT_NEAR(told.blocks[b].value, expected, 1e-8 * expected) << count << ' ' << layout.blocks[b].name;
    }
    EXPECT_EQ(told.estimate, map.estimate);
    EXPECT_EQ(told.error, map.error);
    EXPECT_EQ(told.variance, map.P.diagonal());
    EXPECT_EQ(told.P, n <= kLargestTold ? map.P : Matrix(0, 0));
    EXPECT_EQ(told.lead.P, map.P.topLeftCorner(3, 3));
    EXPECT_EQ(told.lead.error, map.error.head(3));
    EXPECT_EQ(told.position.P, map.P.topLeftCorner(2, 2));
    EXPECT_EQ(told.position.error, map.error.head(2));
    const Vector pivots = map.P.llt().matrixLLT().diagonal();
    EXPECT_NEAR(told.log_determinant, 2.0 * pivots.array().log().sum(), 1e-9 * static_cast<double>(n));
  }
}

// Landmark (i + step) mod 5 in turn, of which 1 and 3 are known, 3 first in the state.
TEST(PlanarNormaliser, looks_at_another_known_landmark_each_step) {
  const KnownPartOfMap map(5, {3, 1});
  for (const auto& [step, place] : {std::pair{1, 5}, {2, 3}, {3, 3}, {4, 5}, {5, 5}, {6, 5}, {7, 3}}) {
    const MovingPart moving = map.normalised(step).moving;
    EXPECT_EQ(moving.places, (std::vector<Index>{0, 1, 2, place, place + 1})) << step;
    EXPECT_EQ(moving.error, map.error(moving.places));
    EXPECT_EQ(moving.P, map.P(moving.places, moving.places));
  }
  const MovingPart nothing = KnownPartOfMap(5, {}).normalised(1).moving;
  EXPECT_TRUE(nothing.places.empty()) << "none is known yet";
  const MovingPart place = KnownPartOfMap(0, {}).normalised(1).moving;
  EXPECT_EQ(place.places, (std::vector<Index>{0, 1})) << "there is none to know";
}

TEST(PlanarNormaliser, a_covariance_without_full_rank_is_not_normalised) {
  KnownPartOfMap map(4, {0, 2});
  const auto accepted = [&map] {
    NeesSolver factor;
    factor.keep_lead(3);
    factor.solve(map.error, map.P);
    NormalisedStep told;
    told.step = 1;
    return PlanarNormaliser(map.world, {})
        .normalise_state(map.estimate, map.error, map.P, factor, map.landmarks, told);
  };
  EXPECT_TRUE(accepted());
  const Matrix regular = map.P;
  map.P.row(2).setZero();
  map.P.col(2).setZero();
  EXPECT_FALSE(accepted()) << "the heading is known exactly";
  map.P = regular;
  map.P.row(6) = map.P.row(4);
  map.P.col(6) = map.P.col(4);
  map.P(6, 6) = map.P(4, 4) * (1.0 + 1e-15);
  EXPECT_FALSE(accepted()) << "two states are one";
}

TEST(PlanarNormaliser, an_innovation_is_that_of_the_dense_solution_or_none) {
  const PlanarWorld world;
  PlanarNormaliser normaliser(world, {0.25, 0.01}), unknown(world, {});
  NormalisedStep told;
  for (const Index m : {2, 6, 40}) {
    const KnownPartOfMap numbers(m, every_second(static_cast<int>(m)));
    const Vector nu = numbers.error.head(m);
    const Matrix S = numbers.P.topLeftCorner(m, m);
    ASSERT_TRUE(normaliser.normalise_innovation(nu, S, told));
    ASSERT_EQ(told.innovations.size(), 1U);
    const NormalisedInnovation& innovation = told.innovations.front();
    const Eigen::FullPivLU<Matrix> lu(S);
    const double expected = nu.dot(lu.solve(nu));
    EXPECT_EQ(innovation.dof, m);
    EXPECT_NEAR(innovation.value, expected, 1e-8 * expected);
    EXPECT_NEAR(innovation.whitened.squaredNorm(), expected, 1e-8 * expected);
    EXPECT_EQ(innovation.nu, nu);
    ASSERT_EQ(innovation.covariance.size(), m / 2);
    EXPECT_EQ(innovation.covariance[m / 2 - 1], S(m - 1, m - 2));
    Vector variances(m);
    for (Index i = 0; i < m; ++i) variances[i] = i % 2 == 0 ? 0.25 : 0.01;
    const double share = lu.solve(Matrix(variances.asDiagonal())).trace() / static_cast<double>(m);
    EXPECT_NEAR(innovation.noise_share, share, 1e-8 * share);
    ASSERT_TRUE(unknown.normalise_innovation(nu, S, told));
    EXPECT_TRUE(std::isnan(told.innovations.front().noise_share));
  }
  ASSERT_TRUE(normaliser.normalise_innovation(Vector(), Matrix(), told));
  EXPECT_EQ(told.innovations.front().dof, -1) << "silence after a step that was heard";
  EXPECT_FALSE(normaliser.normalise_innovation(Eigen::Vector2d(1, 1), Matrix::Zero(2, 2), told));
  EXPECT_FALSE(normaliser.normalise_innovation(Eigen::Vector2d(1, 1), Matrix::Ones(2, 2), told));
}

}  // namespace
}  // namespace credence::internal
