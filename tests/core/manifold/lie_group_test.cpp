#include "core/manifold/lie_group.h"

#include <gtest/gtest.h>

#include <array>
#include <numbers>
#include <random>
#include <vector>

#include "core/manifold/chart.h"
#include "core/manifold/product_group.h"
#include "core/manifold/se2.h"
#include "core/manifold/sek3.h"
#include "core/manifold/so2.h"
#include "core/manifold/so3.h"
#include "core/manifold/trigonometric_series.h"
#include "core/manifold/vector_group.h"

namespace credence::internal {
namespace {

constexpr double kHalfTurn = std::numbers::pi;
constexpr double kTight = 1e-12;  // of what is of order one
constexpr std::array kCharts = {Chart::right, Chart::left, Chart::componentwise, Chart::componentwise_left};

using Long = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;

Long block_diagonal(const Long& A, const Long& B) {
  Long M = Long::Zero(A.rows() + B.rows(), A.cols() + B.cols());
  M.topLeftCorner(A.rows(), A.cols()) = A;
  M.bottomRightCorner(B.rows(), B.cols()) = B;
  return M;
}

// The groups as matrices, by their textbook definitions: ξ^ of the algebra, and an element.
template <class G>
struct AsMatrix;

template <int n>
struct AsMatrix<VectorGroup<n>> {
  static Long hat(const typename VectorGroup<n>::Tangent& xi) {
    Long M = Long::Zero(n + 1, n + 1);
    M.topRightCorner(n, 1) = xi.template cast<long double>();
    return M;
  }
  static Long of(const VectorGroup<n>& x) { return Long::Identity(n + 1, n + 1) + hat(x.vector()); }
};

template <>
struct AsMatrix<SO2> {
  static Long hat(const SO2::Tangent& xi) {
    Long M(2, 2);
    M << 0.0, -xi[0], xi[0], 0.0;
    return M;
  }
  static Long of(const SO2& x) { return x.matrix().cast<long double>(); }
};

template <>
struct AsMatrix<SO3> {
  static Long hat(const SO3::Tangent& v) {
    Long M(3, 3);
    M << 0.0, -v[2], v[1], v[2], 0.0, -v[0], -v[1], v[0], 0.0;
    return M;
  }
  static Long of(const SO3& x) { return x.matrix().cast<long double>(); }
};

template <>
struct AsMatrix<SE2> {
  static Long hat(const SE2::Tangent& xi) {
    Long M = block_diagonal(AsMatrix<SO2>::hat(xi.tail<1>()), Long::Zero(1, 1));
    M.topRightCorner(2, 1) = xi.head<2>().cast<long double>();
    return M;
  }
  static Long of(const SE2& x) {
    Long M = block_diagonal(AsMatrix<SO2>::of(x.rotation()), Long::Identity(1, 1));
    M.topRightCorner(2, 1) = x.translation().cast<long double>();
    return M;
  }
};

template <int k>
struct AsMatrix<SEk3<k>> {
  static Long hat(const typename SEk3<k>::Tangent& xi) {
    Long M = block_diagonal(AsMatrix<SO3>::hat(xi.template tail<3>()), Long::Zero(k, k));
    for (int i = 0; i < k; ++i) M.block(0, 3 + i, 3, 1) = xi.segment(3 * i, 3).template cast<long double>();
    return M;
  }
  static Long of(const SEk3<k>& x) {
    Long M = block_diagonal(AsMatrix<SO3>::of(x.rotation()), Long::Identity(k, k));
    M.topRightCorner(3, k) = x.vectors().template cast<long double>();
    return M;
  }
};

template <class A, class B>
struct AsMatrix<ProductGroup<A, B>> {
  static Long hat(const typename ProductGroup<A, B>::Tangent& xi) {
    return block_diagonal(AsMatrix<A>::hat(xi.template head<A::kDim>()),
                          AsMatrix<B>::hat(xi.template tail<B::kDim>()));
  }
  static Long of(const ProductGroup<A, B>& x) {
    return block_diagonal(AsMatrix<A>::of(x.first()), AsMatrix<B>::of(x.second()));
  }
};

/// Σ Mⁿ / (n + first)!, first = 0: exp M.
Long power_series(const Long& M, int first) {
  Long term = Long::Identity(M.rows(), M.cols()), sum = term;
  for (int n = 1; n < 100; ++n) {
    term = term * M / static_cast<long double>(n + first);
    sum += term;
  }
  return sum;
}

template <class G>
Long small_adjoint(const typename G::Tangent& xi) {
  // The columns of ad are the commutators [ξ^, e_i^], solved for their coordinates.
  using Tangent = typename G::Tangent;
  const Long X = AsMatrix<G>::hat(xi);
  const Index entries = X.size();
  Long basis(entries, G::kDim), commutators(entries, G::kDim);
  for (int i = 0; i < G::kDim; ++i) {
    const Long E = AsMatrix<G>::hat(Tangent::Unit(i));
    const Long C = X * E - E * X;
    basis.col(i) = E.reshaped();
    commutators.col(i) = C.reshaped();
  }
  return (basis.transpose() * basis).ldlt().solve(basis.transpose() * commutators);
}

template <class G>
typename G::Tangent random_tangent(std::mt19937_64& generator) {
  std::normal_distribution<double> normal;
  typename G::Tangent xi;
  for (double& v : xi) v = normal(generator);
  return xi;
}

/// The angle of an element: of its rotations the largest.
double angle_of(const SO2& x) { return std::abs(x.angle_rad()); }
double angle_of(const SO3& x) { return x.Log().norm(); }
double angle_of(const SE2& x) { return angle_of(x.rotation()); }
template <int k>
double angle_of(const SEk3<k>& x) {
  return angle_of(x.rotation());
}
template <int n>
double angle_of(const VectorGroup<n>&) {
  return 0.0;
}
template <class A, class B>
double angle_of(const ProductGroup<A, B>& x) {
  return std::max(angle_of(x.first()), angle_of(x.second()));
}

/// Tangents of any direction whose angle is what is asked for, where the group has one.
template <class G>
std::vector<typename G::Tangent> tangents(const std::vector<double>& angles) {
  std::mt19937_64 generator(7);
  std::vector<typename G::Tangent> result;
  for (const double angle : angles) {
    for (int i = 0; i < 3; ++i) {
      typename G::Tangent xi = random_tangent<G>(generator);
      const double now = angle_of(G::Exp(0.01 * xi)) / 0.01;
      if (now > 0.0) xi *= angle / now;
      result.push_back(xi);
    }
  }
  return result;
}

const std::vector<double> kAllAngles = {0.0,
                                        1e-160,
                                        1e-12,
                                        1e-8,
                                        1e-5,
                                        1e-4,
                                        1e-3,
                                        0.03,
                                        0.4,
                                        0.999999,
                                        1.0,
                                        1.7,
                                        2.6,
                                        3.1,
                                        kHalfTurn - 1e-3,
                                        kHalfTurn - 1e-6,
                                        kHalfTurn - 1e-9};

template <class G>
class LieGroupOf : public testing::Test {};
// Between them all groups, as factors of a product too; each costs seconds to compile.
using Groups = testing::Types<SO3, SE3, ProductGroup<SE2, SO2>, ProductGroup<SE23, VectorGroup<2>>>;
TYPED_TEST_SUITE(LieGroupOf, Groups);

TYPED_TEST(LieGroupOf, ExpIsThePowerSeriesOfTheMatrixExponential) {
  for (const auto& xi : tangents<TypeParam>(kAllAngles)) {
    const Long series = power_series(AsMatrix<TypeParam>::hat(xi), 0);
    const double scale = 1.0 + static_cast<double>(series.norm());
    EXPECT_LT((AsMatrix<TypeParam>::of(TypeParam::Exp(xi)) - series).norm(), kTight * scale)
        << xi.transpose();
  }
}

TYPED_TEST(LieGroupOf, LogGoesBack) {
  for (const auto& xi : tangents<TypeParam>(kAllAngles)) {
    EXPECT_LT((TypeParam::Exp(xi).Log() - xi).norm(), kTight * (1.0 + xi.norm())) << xi.transpose();
  }
}

TYPED_TEST(LieGroupOf, LogOfAHalfTurnIsAHalfTurn) {
  for (const auto& xi : tangents<TypeParam>({kHalfTurn, kHalfTurn + 1e-9, kHalfTurn + 1e-3})) {
    const TypeParam x = TypeParam::Exp(xi);
    EXPECT_LE(angle_of(x), kHalfTurn * (1.0 + 1e-15));
    EXPECT_LT((AsMatrix<TypeParam>::of(TypeParam::Exp(x.Log())) - AsMatrix<TypeParam>::of(x)).norm(),
              kTight * (1.0 + xi.norm()));
  }
}

TYPED_TEST(LieGroupOf, IsAGroup) {
  std::mt19937_64 generator(1);
  const Long I = AsMatrix<TypeParam>::of(TypeParam());
  EXPECT_EQ((I - Long::Identity(I.rows(), I.cols())).norm(), 0.0);
  for (int i = 0; i < 20; ++i) {
    const TypeParam a = TypeParam::Exp(random_tangent<TypeParam>(generator));
    const TypeParam b = TypeParam::Exp(2.0 * random_tangent<TypeParam>(generator));
    const TypeParam c = TypeParam::Exp(random_tangent<TypeParam>(generator));
    const auto M = [](const TypeParam& x) { return AsMatrix<TypeParam>::of(x); };
    EXPECT_LT((M(a * b) - M(a) * M(b)).norm(), kTight);
    EXPECT_LT((M((a * b) * c) - M(a * (b * c))).norm(), 10.0 * kTight);
    EXPECT_LT((M(a * a.inverse()) - I).norm(), kTight);
    EXPECT_LT((M((a * b).inverse()) - M(b.inverse() * a.inverse())).norm(), 10.0 * kTight);
  }
}

TYPED_TEST(LieGroupOf, AdjointMovesATangentAcross) {
  std::mt19937_64 generator(2);
  for (int i = 0; i < 20; ++i) {
    const TypeParam x = TypeParam::Exp(2.0 * random_tangent<TypeParam>(generator));
    const auto xi = random_tangent<TypeParam>(generator);
    const Long X = AsMatrix<TypeParam>::of(x);
    const Long across = X * AsMatrix<TypeParam>::hat(xi) * AsMatrix<TypeParam>::of(x.inverse());
    EXPECT_LT((AsMatrix<TypeParam>::hat(x.adjoint() * xi) - across).norm(), 10.0 * kTight);
  }
}

TYPED_TEST(LieGroupOf, LeftJacobianIsThePowerSeriesOfAd) {
  for (const auto& xi : tangents<TypeParam>(kAllAngles)) {
    const Long series = power_series(small_adjoint<TypeParam>(xi), 1);
    const auto J = TypeParam::left_jacobian(xi);
    const double scale = 1.0 + static_cast<double>(series.norm());
    EXPECT_LT((J.template cast<long double>() - series).norm(), kTight * scale) << xi.transpose();
    const auto inverse = TypeParam::left_jacobian_inverse(xi);
    EXPECT_LT((inverse * J - TypeParam::Jacobian::Identity()).norm(),
              kTight * (1.0 + J.norm() * inverse.norm()))
        << xi.transpose();
  }
}

/// A derivative by the central difference of the eighth order, whose error at this step is below 1e-13.
template <class Function>
auto slope(const Function& f) {
  constexpr double kStep = 0.02;
  const auto difference = [&](int i) { return (f(i * kStep) - f(-i * kStep)).eval(); };
  return ((4.0 / 5.0 * difference(1) - 1.0 / 5.0 * difference(2) + 4.0 / 105.0 * difference(3) -
           1.0 / 280.0 * difference(4)) /
          kStep)
      .eval();
}

TYPED_TEST(LieGroupOf, RightJacobianIsTheDerivativeOfExp) {
  using Tangent = typename TypeParam::Tangent;
  for (const auto& xi : tangents<TypeParam>({0.0, 1e-6, 0.3, 1.0, 2.9, kHalfTurn})) {
    const TypeParam back = TypeParam::Exp(xi).inverse();
    typename TypeParam::Jacobian J;
    for (int i = 0; i < TypeParam::kDim; ++i) {
      J.col(i) = slope([&](double h) { return (back * TypeParam::Exp(xi + h * Tangent::Unit(i))).Log(); });
    }
    EXPECT_LT((right_jacobian<TypeParam>(xi) - J).norm(), kTight * (1.0 + xi.norm())) << xi.transpose();
  }
}

TYPED_TEST(LieGroupOf, PlusAndMinusAreInverse) {
  std::mt19937_64 generator(3);
  for (const Chart chart : kCharts) {
    for (const auto& xi : tangents<TypeParam>({0.0, 1e-9, 0.5, 3.0, kHalfTurn - 1e-9})) {
      const TypeParam x = TypeParam::Exp(2.0 * random_tangent<TypeParam>(generator));
      const auto back = minus(plus(x, xi, chart), x, chart);
      EXPECT_LT((back - xi).norm(), 10.0 * kTight * (1.0 + xi.norm())) << chart_name(chart);
      EXPECT_LT((minus(x, plus(x, xi, chart), chart) + xi).norm(), 10.0 * kTight * (1.0 + xi.norm()))
          << chart_name(chart) << ": y ⊟ x = −(x ⊟ y)";
    }
  }
}

TYPED_TEST(LieGroupOf, MinusAndPlusJacobiansAreDerivatives) {
  using Tangent = typename TypeParam::Tangent;
  std::mt19937_64 generator(4);
  for (const Chart chart : kCharts) {
    for (const auto& xi : tangents<TypeParam>({0.0, 1e-7, 0.5, 2.9})) {
      const TypeParam x = TypeParam::Exp(random_tangent<TypeParam>(generator));
      const TypeParam y = plus(x, xi, chart);
      typename TypeParam::Jacobian D;
      for (int i = 0; i < TypeParam::kDim; ++i) {
        D.col(i) = slope([&](double h) { return minus(y * TypeParam::Exp(h * Tangent::Unit(i)), x, chart); });
      }
      const double scale = 10.0 * (1.0 + D.squaredNorm());
      EXPECT_LT((minus_jacobian(y, x, chart) - D).norm(), kTight * scale) << chart_name(chart);
      EXPECT_LT(
          (minus_jacobian(y, x, chart) * plus_jacobian(y, x, chart) - TypeParam::Jacobian::Identity()).norm(),
          kTight * scale)
          << chart_name(chart);
    }
  }
}

TYPED_TEST(LieGroupOf, ChartJacobianIsTheDerivativeOfTheChange) {
  using Tangent = typename TypeParam::Tangent;
  std::mt19937_64 generator(5);
  for (const Chart from : kCharts) {
    for (const Chart to : kCharts) {
      const TypeParam x = TypeParam::Exp(random_tangent<TypeParam>(generator));
      const auto xi = tangents<TypeParam>({1.3}).front();
      typename TypeParam::Jacobian T;
      for (int i = 0; i < TypeParam::kDim; ++i) {
        T.col(i) = slope([&](double h) { return minus(plus(x, xi + h * Tangent::Unit(i), from), x, to); });
      }
      const double scale = 10.0 * (1.0 + T.squaredNorm());
      EXPECT_LT((chart_jacobian(plus(x, xi, from), x, from, to) - T).norm(), kTight * scale)
          << chart_name(from) << " to " << chart_name(to);
    }
  }
}

// Exp(Ad ξ) x = x Exp(ξ): between right and left the change is linear, so that eᵀ P⁻¹ e is the same however
// large the error is; and there and back P is what it was in any pair of charts.
TYPED_TEST(LieGroupOf, CovarianceIsTransportedExactly) {
  using Jacobian = typename TypeParam::Jacobian;
  std::mt19937_64 generator(6);
  Jacobian A;
  for (int i = 0; i < TypeParam::kDim; ++i) A.col(i) = random_tangent<TypeParam>(generator);
  const Jacobian P = A * A.transpose() + Jacobian::Identity();
  const TypeParam x = TypeParam::Exp(random_tangent<TypeParam>(generator));
  const TypeParam y = plus(x, tangents<TypeParam>({2.5}).front(), Chart::right);
  const auto squared = [&](Chart chart) {
    const auto e = minus(y, x, chart);
    return e.dot(transported(P, x, Chart::right, chart).llt().solve(e));
  };
  EXPECT_NEAR(squared(Chart::left), squared(Chart::right), 1e-9 * squared(Chart::right));
  for (const Chart from : kCharts) {
    for (const Chart to : kCharts) {
      const Jacobian back = transported(transported(P, x, from, to), x, to, from);
      EXPECT_LT((back - P).norm(), 1e-11 * P.norm()) << chart_name(from) << " to " << chart_name(to);
    }
  }
}

TEST(SE2, AComponentwiseErrorIsTheDifferenceOfPoses) {
  const SE2 x(SO2(3.0), {1.0, 2.0}), y(SO2(-3.0), {0.5, 4.0});
  const SE2::Tangent e = minus(y, x, Chart::componentwise);
  EXPECT_NEAR(e[0], -0.5, 1e-15);
  EXPECT_NEAR(e[1], 2.0, 1e-15);
  EXPECT_NEAR(e[2], 2.0 * kHalfTurn - 6.0, 1e-15);
}

TEST(SO3, ComponentwiseErrorsAreInTheAxesOfBodyOrWorld) {
  const SO3 quarter = SO3::Exp({0.0, 0.0, 0.5 * kHalfTurn});
  const SE3 x(quarter, Eigen::Vector3d(1.0, 2.0, 3.0));
  const SE3 y = x * SE3(SO3::Exp({0.1, 0.0, 0.0}), Eigen::Vector3d(1.0, 0.0, 0.0));
  SE3::Tangent body, world;
  body << 0.0, 1.0, 0.0, 0.1, 0.0, 0.0;
  world << 0.0, 1.0, 0.0, 0.0, 0.1, 0.0;
  EXPECT_LT((minus(y, x, Chart::componentwise) - body).norm(), 1e-15);
  EXPECT_LT((minus(y, x, Chart::componentwise_left) - world).norm(), 1e-15);
}

TEST(TrigonometricSeries, AgreesWithItsQuotientsOnBothSidesOfTheSeam) {
  for (const double theta : {0.1, 0.9999999, 1.0, 1.0000001, 3.0, 6.0}) {
    const TrigonometricSeries s = trigonometric_series(theta);
    const long double t = theta, sine = std::sin(t), cosine = std::cos(t);
    const auto near = [&](double got, long double quotient, double tolerance) {
      EXPECT_NEAR(got, static_cast<double>(quotient), tolerance) << theta;
    };
    near(s.s1, sine / t, 1e-15);
    near(s.s2, (1.0L - cosine) / (t * t), 1e-15);
    near(s.s3, (t - sine) / (t * t * t), 1e-15);
    near(s.s4, (0.5L * t * t - 1.0L + cosine) / (t * t * t * t), 1e-14);
    near(s.s5, (sine - t + t * t * t / 6.0L) / (t * t * t * t * t), 1e-13);
  }
  const TrigonometricSeries zero = trigonometric_series(0.0);
  EXPECT_EQ(zero.s1, 1.0);
  EXPECT_EQ(zero.s2, 0.5);
  EXPECT_EQ(zero.s3, 1.0 / 6.0);
  EXPECT_EQ(zero.s4, 1.0 / 24.0);
  EXPECT_EQ(zero.s5, 1.0 / 120.0);
}

}  // namespace
}  // namespace credence::internal
