#include "core/record/piece_covariances.h"

#include <gtest/gtest.h>

namespace credence::internal {
namespace {

TEST(PieceCovariances, AreThoseWithinEachPieceAlone) {
  Matrix S(6, 6);
  for (Index i = 0; i < 6; ++i) {
    for (Index j = 0; j < 6; ++j) S(i, j) = i >= j ? static_cast<double>(10 * i + j) : -1.0;
  }
  Vector covariances;
  take_piece_covariances(S, 3, covariances);
  EXPECT_EQ(covariances, (Vector(6) << 10.0, 20.0, 21.0, 43.0, 53.0, 54.0).finished());
  take_piece_covariances(S, 2, covariances);
  EXPECT_EQ(covariances, (Vector(3) << 10.0, 32.0, 54.0).finished());
  take_piece_covariances(S, 1, covariances);
  EXPECT_EQ(covariances.size(), 0);
  take_piece_covariances(S, 4, covariances);
  EXPECT_EQ(covariances.size(), 6) << "what is no whole piece is left out";
}

}  // namespace
}  // namespace credence::internal
