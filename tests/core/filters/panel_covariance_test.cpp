#include "core/filters/panel_covariance.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

namespace credence {
namespace {

std::vector<InstructionSet> supported_sets() {
  std::vector<InstructionSet> sets;
  for (const InstructionSet set : {InstructionSet::scalar, InstructionSet::avx2, InstructionSet::avx512}) {
    if (is_supported(set)) sets.push_back(set);
  }
  return sets;
}

Matrix random_matrix(Index rows, Index columns, std::mt19937_64& generator) {
  std::normal_distribution<double> normal;
  return Matrix::NullaryExpr(rows, columns, [&] { return normal(generator); });
}

Matrix random_covariance(Index n, std::mt19937_64& generator) {
  const Matrix A = random_matrix(n, n, generator);
  const Matrix P = 0.1 * A * A.transpose() / static_cast<double>(n) + 0.1 * Matrix::Identity(n, n);
  return 0.5 * (P + P.transpose());
}

double largest(const Matrix& M) { return M.size() == 0 ? 0.0 : M.cwiseAbs().maxCoeff(); }

/// Dimensions of a filter, and who they are the generic or the special kernels of.
struct Shape {
  Index vehicle, landmark, measurements;
};

constexpr Shape kShapes[] = {{3, 2, 2}, {1, 1, 1}, {6, 3, 3}, {2, 3, 1}};

/// A PanelCovariance and the same P as a dense matrix, driven through the same steps.
class Pair {
 public:
  Pair(const Shape& shape, Index landmarks, int flush_steps, InstructionSet set = best_instruction_set())
      : shape_(shape), panels_(shape.vehicle, shape.landmark, flush_steps, set) {
    dense_ = random_covariance(shape.vehicle + shape.landmark * landmarks, generator_);
    panels_.reset(dense_);
  }

  void predict() {
    const Index r = shape_.vehicle;
    const Matrix F = Matrix::Identity(r, r) + 0.1 * random_matrix(r, r, generator_);
    const Matrix Q = 0.01 * random_covariance(r, generator_);
    panels_.predict(F, Q);
    dense_.topRows(r) = (F * dense_.topRows(r)).eval();
    dense_.leftCols(r) = (dense_.leftCols(r) * F.transpose()).eval();
    dense_.topLeftCorner(r, r) += Q;
  }

  /// Observes `count` landmarks, every third time an anchor first, with R = 0.1 I.
  void correct(Index count) {
    const Index r = shape_.vehicle, d = shape_.landmark, q = shape_.measurements;
    const Index landmarks = panels_.map_size() / d;
    batch_.clear(r, d, q);
    const Index rows = q * count;
    Matrix H = Matrix::Zero(rows, dense_.rows());
    for (Index o = 0; o < count; ++o) {
      const bool anchor = landmarks == 0 || (o == 0 && steps_ % 3 == 0);
      const Index column = anchor ? -1 : d * ((7 * steps_ + 5 * o) % landmarks);
      const Matrix H_r = random_matrix(q, r, generator_), H_l = random_matrix(q, d, generator_);
      batch_.add(column, H_r, H_l);
      H.block(q * o, 0, q, r) = H_r;
      if (!anchor) H.block(q * o, r + column, q, d) = H_l;
    }
    Matrix S(rows, rows);
    panels_.project(batch_, S);
    const Matrix PHt = dense_ * H.transpose();
    ASSERT_LE(largest(S - H * PHt), 1e-12 * largest(H * PHt));
    S.diagonal().array() += 0.1;
    const Eigen::LLT<Matrix> llt(S);
    const Vector nu = random_matrix(rows, 1, generator_).col(0);
    const Vector whitened = llt.matrixL().solve(nu);
    ASSERT_TRUE(panels_.whiten(llt.matrixLLT(), whitened));
    panels_.commit();

    const Matrix K = llt.solve(PHt.transpose()).transpose();
    Vector change = Vector::Zero(dense_.rows());
    panels_.add_state_change(change);
    ASSERT_LT(largest(change - K * nu), 1e-11);
    const Matrix W = panels_.whitened_columns();
    ASSERT_LE(largest(W * W.transpose() - K * PHt.transpose()), 1e-12 * largest(dense_));
    dense_ -= K * PHt.transpose();
    ++steps_;
  }

  void append() {
    const Index r = shape_.vehicle, d = shape_.landmark, n = dense_.rows();
    const Matrix J_r = random_matrix(d, r, generator_);
    const Matrix own = J_r * dense_.topLeftCorner(r, r) * J_r.transpose() + random_covariance(d, generator_);
    panels_.append(J_r, 0.5 * (own + own.transpose()));
    Matrix larger(n + d, n + d);
    larger << dense_, dense_.leftCols(r) * J_r.transpose(), J_r * dense_.topRows(r), own;
    dense_ = larger;
  }

  void expect_equal() const {
    const Index n = dense_.rows();
    ASSERT_EQ(panels_.size(), n);
    const Matrix P = panels_.block(0, 0, n, n);
    EXPECT_LT((P - dense_).cwiseAbs().maxCoeff(), 1e-12 * dense_.cwiseAbs().maxCoeff());
    EXPECT_EQ(P, P.transpose());
    EXPECT_EQ(P, panels_.dense());
    EXPECT_NEAR(panels_.trace(), dense_.trace(), 1e-12 * dense_.trace());
  }

  const PanelCovariance& panels() const { return panels_; }
  Index landmarks() const { return panels_.map_size() / shape_.landmark; }

 private:
  Shape shape_;
  PanelCovariance panels_;
  Matrix dense_;
  ObservationBatch batch_;
  std::mt19937_64 generator_{20041};
  Index steps_ = 0;
};

/// A map that grows from nothing, with batches of zero to five.
void drive(Pair& pair, bool check) {
  for (int k = 0; k < 24; ++k) {
    if (k % 4 != 3) pair.predict();
    if (k % 5 == 0) pair.predict();
    ASSERT_NO_FATAL_FAILURE(pair.correct(std::min<Index>(k % 6, std::max<Index>(1, pair.landmarks()))));
    if (k % 3 == 0) pair.append();
    if (k % 7 == 0) pair.append();
    if (check) pair.expect_equal();
  }
}

TEST(PanelCovariance, is_the_dense_matrix_at_any_time) {
  for (const Shape& shape : kShapes) {
    for (const int flush_steps : {1, 4, 7}) {
      Pair pair(shape, 0, flush_steps);
      drive(pair, true);
    }
  }
}

TEST(PanelCovariance, no_bit_depends_on_the_flush_or_the_instruction_set) {
  for (const Shape& shape : kShapes) {
    Pair explicit_pair(shape, 9, 1, InstructionSet::scalar);
    drive(explicit_pair, false);
    const Matrix expected = explicit_pair.panels().dense();
    for (const InstructionSet set : supported_sets()) {
      for (const int flush_steps : {1, 4, 16, 100}) {
        Pair pair(shape, 9, flush_steps, set);
        drive(pair, false);
        EXPECT_EQ(pair.panels().dense(), expected) << instruction_set_name(set) << " " << flush_steps;
        EXPECT_EQ(pair.panels().trace(), explicit_pair.panels().trace());
        EXPECT_EQ(pair.panels().whitened_columns(), explicit_pair.panels().whitened_columns());
      }
    }
  }
}

TEST(PanelCovariance, columns_wait_until_they_are_flushed) {
  Pair pair({3, 2, 2}, 20, 4);
  std::vector<Index> pending;
  for (int k = 0; k < 6; ++k) {
    pair.correct(2);
    pending.push_back(pair.panels().pending_columns());
  }
  EXPECT_EQ(pending, (std::vector<Index>{4, 8, 12, 0, 4, 8}));
  // more than may wait: what waits is flushed before, the batch itself after
  pair.correct(19);
  EXPECT_EQ(pair.panels().pending_columns(), 38);
  pair.correct(1);
  EXPECT_EQ(pair.panels().pending_columns(), 2);
  pair.expect_equal();
}

TEST(PanelCovariance, a_prediction_alone_can_be_read) {
  Pair pair({3, 2, 2}, 5, 4);
  for (int k = 0; k < 3; ++k) {
    pair.predict();
    pair.expect_equal();
  }
  pair.append();
  pair.expect_equal();
}

TEST(PanelCovariance, refuses_a_correction_that_leaves_no_variance) {
  for (const InstructionSet set : supported_sets()) {
    PanelCovariance P(1, 1, 4, set);
    P.reset(Matrix::Identity(3, 3));
    ObservationBatch batch;
    batch.clear(1, 1, 1);
    batch.add(1, Matrix::Zero(1, 1), Matrix::Identity(1, 1));
    Matrix S(1, 1);
    P.project(batch, S);
    EXPECT_EQ(S(0, 0), 1.0);
    // with an S that is too small, 1 − 1/0.9 < 0
    EXPECT_FALSE(P.whiten(Matrix::Constant(1, 1, std::sqrt(0.9)), Vector::Zero(1)));
    EXPECT_EQ(P.dense(), Matrix::Identity(3, 3));
    EXPECT_FALSE(P.whiten(Matrix::Constant(1, 1, std::numeric_limits<double>::quiet_NaN()), Vector::Zero(1)));
    EXPECT_EQ(P.dense(), Matrix::Identity(3, 3));
  }
}

TEST(PanelCovariance, sizes_that_do_not_match_are_refused) {
  EXPECT_THROW(PanelCovariance(0, 2, 1), std::invalid_argument);
  EXPECT_THROW(PanelCovariance(3, 0, 1), std::invalid_argument);
  EXPECT_THROW(PanelCovariance(3, 2, 0), std::invalid_argument);
  PanelCovariance P(3, 2, 1);
  EXPECT_THROW(P.reset(Matrix::Identity(4, 4)), std::invalid_argument);
  EXPECT_THROW(P.reset(Matrix::Identity(2, 2)), std::invalid_argument);
  EXPECT_THROW(P.reset(Matrix::Zero(5, 7)), std::invalid_argument);
  P.reset(Matrix::Identity(7, 7));
  EXPECT_THROW(P.replace(Matrix::Identity(5, 5)), std::invalid_argument);
  EXPECT_THROW(P.predict(Matrix::Identity(2, 2), Matrix::Zero(3, 3)), std::invalid_argument);
  EXPECT_THROW(P.predict(Matrix::Identity(3, 3), Matrix::Zero(2, 2)), std::invalid_argument);
  EXPECT_THROW(P.block(0, 6, 1, 2), std::invalid_argument);
  EXPECT_THROW(P.block(-1, 0, 1, 1), std::invalid_argument);
  EXPECT_THROW(P.append(Matrix::Zero(2, 2), Matrix::Zero(2, 2)), std::invalid_argument);
  ObservationBatch batch;
  batch.clear(3, 2, 2);
  batch.add(4, Matrix::Zero(2, 3), Matrix::Zero(2, 2));
  Matrix S(2, 2);
  EXPECT_THROW(P.project(batch, S), std::invalid_argument);
  batch.clear(3, 2, 2);
  batch.add(2, Matrix::Zero(2, 3), Matrix::Zero(2, 2));
  Matrix wrong(1, 1);
  EXPECT_THROW(P.project(batch, wrong), std::invalid_argument);
  P.project(batch, S);
  EXPECT_THROW(P.whiten(Matrix::Identity(3, 3), Vector::Zero(3)), std::invalid_argument);
}

TEST(PanelKernel, the_triangle_is_the_same_at_every_width_also_where_it_is_cut) {
  // So many columns that the kernel goes over W in pieces.
  constexpr std::int64_t kColumns = 203, kPanels = 90, kStride = kPanelRows * 205;
  std::mt19937_64 generator(3);
  std::vector<double> W(kPanels * kStride), P(static_cast<std::size_t>(panel_offset(kPanels)));
  for (std::vector<double>* v : {&W, &P}) {
    for (double& x : *v) x = std::ldexp(static_cast<double>(generator() >> 11), -53) - 0.5;
  }
  const auto element = [&](std::int64_t row, std::int64_t column) {
    double x = P[static_cast<std::size_t>(packed_index(row, column))];
    for (std::int64_t k = 0; k < kColumns; ++k) {
      const auto at = [&](std::int64_t i) {
        return W[static_cast<std::size_t>(i / 8 * kStride + 8 * k + i % 8)];
      };
      x = std::fma(-at(row), at(column), x);
    }
    return x;
  };
  for (const InstructionSet set : supported_sets()) {
    std::vector<double> got = P;
    panel_kernel(set).downdate(got.data(), kPanels, W.data(), kStride, kColumns);
    for (const std::int64_t row : {0, 7, 8, 100, 327, 328, 500, 719}) {
      for (std::int64_t column = 0; column <= row; column += 1 + row / 40) {
        ASSERT_EQ(got[static_cast<std::size_t>(packed_index(row, column))], element(row, column))
            << instruction_set_name(set) << " " << row << " " << column;
      }
    }
  }
}

TEST(PanelKernel, refuses_an_instruction_set_that_is_not_there) {
  for (const InstructionSet set : {InstructionSet::scalar, InstructionSet::avx2, InstructionSet::avx512}) {
    if (is_supported(set)) {
      EXPECT_NO_THROW(panel_kernel(set));
    } else {
      EXPECT_THROW(panel_kernel(set), std::invalid_argument);
    }
  }
  EXPECT_THROW(panel_kernel(static_cast<InstructionSet>(99)), std::invalid_argument);  // on any machine
}

}  // namespace
}  // namespace credence
