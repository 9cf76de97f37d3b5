#include "core/filters/delayed_covariance.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <stdexcept>

#include "core/linear_algebra/mirror.h"
#include "core/simd/cpu_dispatch.h"
#include "tests/core/random_matrix.h"

namespace credence::internal {
namespace {

constexpr Index kVehicle = 3;

Matrix positive(Index n, std::uint64_t seed) {
  const Matrix A = random_matrix(n, n, seed);
  return A * A.transpose() + static_cast<double>(n) * Matrix::Identity(n, n);
}

Matrix columns_of(const DelayedCovariance& P, Index first, Index count) {
  Matrix to = Matrix::Constant(whole_panels(P.size()), count, 9.0);
  P.copy_columns(first, count, Eigen::Map<Matrix>(to.data(), to.rows(), to.cols()));
  return to.topRows(P.size());
}

/// A filter's life in small: corrections by so many numbers each, motions of the vehicle and new landmarks,
/// beside the same with a plain matrix.
class Life {
 public:
  explicit Life(Index n, InstructionSet set = best_instruction_set())
      : P_(kVehicle, set), factor_(set), dense_(positive(n, 1)) {
    P_.set(dense_);
  }

  void correct(Index m) {
    seed_ += 3;
    ASSERT_TRUE(factor_.compute(positive(m, seed_), 0.1 * random_matrix(P_.size(), m, seed_ - 1),
                                random_matrix(m, 1, seed_ - 2)));
    P_.downdate(factor_);
    const Matrix W = factor_.W();
    dense_ -= W * W.transpose();
  }

  void move() {
    const Matrix F = Matrix::Identity(kVehicle, kVehicle) + 0.1 * random_matrix(kVehicle, kVehicle, ++seed_);
    auto columns = P_.vehicle_columns();
    Matrix moved = columns * F.transpose();
    Matrix own = F * columns.topRows(kVehicle) * F.transpose();
    mirror_lower(own);
    moved.topRows(kVehicle) = own;
    columns = moved;
    P_.vehicle_changed();
    dense_.leftCols(kVehicle) = moved;
    dense_.topRows(kVehicle) = moved.transpose();
  }

  void see_new(Index states) {
    const Index n = P_.size();
    const Matrix cross = 0.1 * random_matrix(states, n, ++seed_), own = positive(states, ++seed_);
    P_.append(cross, own);
    dense_.conservativeResize(n + states, n + states);
    dense_.bottomLeftCorner(states, n) = cross;
    dense_.topRightCorner(n, states) = cross.transpose();
    dense_.bottomRightCorner(states, states) = own;
  }

  DelayedCovariance& P() { return P_; }
  const Matrix& dense() const { return dense_; }

 private:
  DelayedCovariance P_;
  PanelCholesky factor_;
  Matrix dense_;
  std::uint64_t seed_ = 10;
};

constexpr Index kBatches[] = {1, 2, 1, 2, 7, 3, 8, 1, 2, 5, 20, 2, 2};

/// What is written to whole() by many steps, read after each where `often`.
Matrix after_many(Index n, bool often, InstructionSet set = best_instruction_set()) {
  Life life(n, set);
  for (const Index m : kBatches) {
    life.move();
    life.correct(m);
    if (m % 2 == 1) life.see_new(2);
    if (often) life.P().whole();
  }
  return life.P().whole();
}

TEST(DelayedCovariance, is_the_covariance_of_a_plain_matrix_at_every_step) {
  for (const Index n : {3, 4, 5, 11, 16, 41}) {
    Life life(n);
    for (const Index m : kBatches) {
      life.move();
      life.correct(m);
      if (m % 2 == 1) life.see_new(m == 1 ? 2 : 9);
      DelayedCovariance& P = life.P();
      const Matrix& dense = life.dense();
      const double scale = 1e-12 * dense.cwiseAbs().maxCoeff();
      ASSERT_EQ(P.size(), dense.rows());
      EXPECT_LT((P.vehicle_columns() - dense.leftCols(kVehicle)).cwiseAbs().maxCoeff(), scale);
      EXPECT_LT((P.variances() - dense.diagonal()).cwiseAbs().maxCoeff(), scale);
      EXPECT_NEAR(P.trace(), dense.trace(), scale * static_cast<double>(n));
      if (P.size() == kVehicle) continue;
      EXPECT_LT((columns_of(P, kVehicle, P.size() - kVehicle) - dense.rightCols(P.size() - kVehicle))
                    .cwiseAbs()
                    .maxCoeff(),
                scale)
          << n << " after " << m;
    }
    EXPECT_LT((life.P().whole() - life.dense()).cwiseAbs().maxCoeff(),
              1e-12 * life.dense().cwiseAbs().maxCoeff());
  }
}

TEST(DelayedCovariance, has_the_same_bits_whoever_reads_it_when) {
  for (const Index n : {3, 9, 16, 40}) {
    EXPECT_EQ(after_many(n, false), after_many(n, true)) << n;
    EXPECT_EQ(after_many(n, false), after_many(n, false).transpose()) << n;
  }
}

TEST(DelayedCovariance, has_the_same_bits_by_every_instruction_set) {
  if (!is_supported(InstructionSet::avx2)) GTEST_SKIP() << "no AVX2: there is nothing to compare with";
  const Matrix expected = after_many(21, false, InstructionSet::scalar);
  for (const InstructionSet set : {InstructionSet::avx2, InstructionSet::avx512}) {
    if (is_supported(set)) EXPECT_EQ(after_many(21, false, set), expected) << instruction_set_name(set);
  }
}

// What waits is in what is read of it before the pass.
TEST(DelayedCovariance, tells_of_single_columns_what_the_whole_says) {
  Life life(20);
  life.move();
  for (int step = 0; step < 3; ++step) life.correct(2);
  DelayedCovariance& P = life.P();
  const Matrix columns = columns_of(P, 3, 17), vehicle = P.vehicle_columns();
  const Vector variances = P.variances();
  const double trace = P.trace();
  const Matrix whole = P.whole();
  EXPECT_EQ(columns, whole.rightCols(17));
  EXPECT_EQ(vehicle, whole.leftCols(3));
  EXPECT_EQ(variances, whole.diagonal());
  EXPECT_EQ(trace, whole.trace());
}

TEST(DelayedCovariance, goes_on_from_what_was_changed_as_a_whole) {
  Life life(12), same(12);
  life.correct(2);
  EXPECT_EQ(life.P().change([](Matrix& P) {
    P.diagonal().array() += 0.5;
    P(1, 0) = P(0, 1) = 0.25;
    return 7;
  }),
            7);
  same.correct(2);
  Matrix changed = same.P().whole();
  changed.diagonal().array() += 0.5;
  changed(1, 0) = changed(0, 1) = 0.25;
  same.P().set(changed);
  for (Life* one : {&life, &same}) {
    EXPECT_EQ(one->P().variances()[4], changed(4, 4));
    EXPECT_EQ(one->P().vehicle_columns()(1, 0), 0.25);
    one->move();
    one->correct(3);
  }
  EXPECT_EQ(life.P().whole(), same.P().whole());
}

// Nothing of a run is left in the next, whose map is smaller and then as large.
TEST(DelayedCovariance, forgets_what_was_before_it_is_set) {
  Life used(30);
  used.correct(2);
  used.correct(1);
  Life fresh(5);
  used.P().set(fresh.dense());
  DelayedCovariance& P = used.P();
  PanelCholesky factor;
  for (int step = 0; step < 2; ++step) {
    ASSERT_TRUE(factor.compute(positive(2, 5), random_matrix(P.size(), 2, 6), random_matrix(2, 1, 7)));
    for (DelayedCovariance* one : {&P, &fresh.P()}) {
      one->downdate(factor);
      one->append(random_matrix(11, one->size(), 8), positive(11, 9));
    }
  }
  EXPECT_EQ(P.whole(), fresh.P().whole());
}

TEST(DelayedCovariance, refuses_a_factor_of_other_states) {
  Life life(12);
  PanelCholesky factor;
  ASSERT_TRUE(factor.compute(positive(2, 5), random_matrix(11, 2, 6), random_matrix(2, 1, 7)));
  EXPECT_THROW(life.P().downdate(factor), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
