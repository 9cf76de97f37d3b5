#include "datasets/logs/assumed_noise.h"

#include <gtest/gtest.h>

#include <array>

namespace credence::internal {
namespace {

TEST(AssumedNoise, OfOneObservationRepeatsForTheOthers) {
  const Matrix of_one{{2.0, 0.5}, {0.5, 3.0}};
  const std::array<Index, 3> kept{0, 1, 3};  // the second observation without its first component
  Matrix R;
  take_assumed_noise(of_one, 2, kept, R);
  EXPECT_EQ(R, (Matrix{{2.0, 0.5, 0.0}, {0.5, 3.0, 0.0}, {0.0, 0.0, 3.0}}));
  const Matrix of_all = Vector{{1.0, 2.0, 3.0, 4.0}}.asDiagonal();
  take_assumed_noise(of_all, 2, kept, R);
  EXPECT_EQ(R, Matrix(Vector{{1.0, 2.0, 4.0}}.asDiagonal()));
  take_assumed_noise(Matrix(), 2, kept, R);
  EXPECT_EQ(R.size(), 0);
}

TEST(AssumedNoise, IsToldOfOneObservationWhereItRepeatsAndElseOfAll) {
  const auto told = [](Index piece, std::vector<double> variances, Index measurements) {
    return Vector(assumed_noise({.dim = 6, .piece = piece, .variances = std::move(variances)}, measurements)
                      .diagonal());
  };
  EXPECT_EQ(told(2, {1.0, 4.0}, 6), (Vector{{1.0, 4.0}}));
  EXPECT_EQ(told(2, {1.0, 4.0}, 3), (Vector{{1.0, 4.0, 1.0}}));
  EXPECT_EQ(told(6, {1.0}, 3), (Vector{{1.0, 1.0, 1.0}}));
  EXPECT_EQ(told(6, {1.0, 4.0, 9.0}, 6), (Vector{{1.0, 4.0, 9.0, 1.0, 4.0, 9.0}}));
  EXPECT_EQ(told(2, {}, 6).size(), 0);
}

}  // namespace
}  // namespace credence::internal
