#include "core/linear_algebra/decompositions.h"

#include <gtest/gtest.h>

#include "tests/core/random_matrix.h"

namespace credence::internal {
namespace {

TEST(Decompositions, FirstColumnsOfQSpanThoseOfTheMatrix) {
  for (const auto& [rows, columns] : {std::pair<Index, Index>{7, 3}, {5, 5}, {1, 1}, {40, 17}}) {
    const Matrix A = random_matrix(rows, columns, 4);
    const Eigen::HouseholderQR<Matrix> qr(A);
    const Matrix Q = orthonormal_columns(qr.householderQ(), columns);
    ASSERT_EQ(Q.rows(), rows);
    ASSERT_EQ(Q.cols(), columns);
    EXPECT_LT((Q.transpose() * Q - Matrix::Identity(columns, columns)).cwiseAbs().maxCoeff(), 1e-14);
    const Matrix R = qr.matrixQR().topRows(columns).triangularView<Eigen::Upper>();
    EXPECT_LT((Q * R - A).cwiseAbs().maxCoeff(), 1e-13) << rows << " by " << columns;
    // The same columns, whatever their number.
    if (columns > 1) {
      EXPECT_EQ(orthonormal_columns(qr.householderQ(), columns - 1), Matrix(Q.leftCols(columns - 1)));
    }
  }
}

}  // namespace
}  // namespace credence::internal
