#include "montecarlo/lanes/intermittent_kernel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/simd/aligned_vector.h"
#include "core/types.h"

namespace credence::internal {
namespace {

std::vector<InstructionSet> intermittent_sets() {
  std::vector<InstructionSet> sets;
  for (const InstructionSet set : {InstructionSet::scalar, InstructionSet::avx2, InstructionSet::avx512}) {
    if (is_supported(set)) sets.push_back(set);
  }
  return sets;
}

std::size_t place(std::int64_t i) { return static_cast<std::size_t>(i); }

constexpr Index kDrawn = 8, kStepsOfRun = 7;

/// A plan with its inputs: random errors and noise, a P0 that is positive definite, two measurements in three
/// seen.
struct IntermittentInput {
  IntermittentPlan plan{};
  std::vector<double> constant;
  Matrix errors;  ///< n×lanes
  Matrix P0;      ///< of all lanes
  AlignedVector process, measurement, seen;

  IntermittentInput(int landmarks, int anchors, int first_decorrelated, bool with_constant) {
    const int n = landmarks + 1, m = landmarks + anchors;
    std::mt19937_64 bits(static_cast<std::uint64_t>(100 * landmarks + 10 * anchors + first_decorrelated));
    std::normal_distribution<double> normal;
    const auto fill = [&](AlignedVector& x, std::int64_t count) {
      x.resize(place(count));
      for (double& value : x) value = normal(bits);
    };
    errors.resize(n, kNoiseLanes);
    for (double& e : errors.reshaped()) e = normal(bits);
    P0.resize(n, n);
    for (double& p : P0.reshaped()) p = normal(bits);
    P0 = (P0 * P0.transpose() + Matrix::Identity(n, n)).eval();
    fill(process, kDrawn * kNoiseLanes);
    fill(measurement, m * kDrawn * kNoiseLanes);
    fill(seen, m * kDrawn * kNoiseLanes);
    for (double& s : seen) s = s < 0.43 ? 1.0 : 0.0;
    for (int i = 0; with_constant && i < n * (n + 1) / 2; ++i) constant.push_back(0.01 * (1 + i % 3));
    plan = {.states = n,
            .anchors = anchors,
            .first_decorrelated = first_decorrelated,
            .process_variance = 0.13,
            .measurement_variance = 0.08,
            .process_std = std::sqrt(0.1),
            .measurement_std = std::sqrt(0.11),
            .constant = with_constant ? constant.data() : nullptr};
  }
  IntermittentInput(const IntermittentInput&) = delete;
  IntermittentInput& operator=(const IntermittentInput&) = delete;
};

/// e and P of every lane, and the values of every step.
struct IntermittentOutput {
  std::vector<Vector> errors;
  std::vector<Matrix> covariance;  ///< lower triangle
  Matrix values;                   ///< lanes×(steps · kIntermittentValues)
};

/// One lane after the other, each with the equations that the kernel names, in plain numbers: measurements
/// one by one, A = P − k vᵀ, P ← A − ½ (b kᵀ + k bᵀ), b = A h − r k.
class PlainLane {
 public:
  PlainLane(const IntermittentInput& input, int lane)
      : input_(input), plan_(input.plan), lane_(lane), e(input.errors.col(lane)), P(input.P0) {}

  void step(Index k, Eigen::Ref<Vector> values) {
    const Index n = plan_.states, landmarks = n - 1;
    e[0] = std::fma(plan_.process_std, input_.process[place(k * kNoiseLanes + lane_)], e[0]);
    predict();
    values[kTracePriorValue] = trace_from(0);
    double nis = 0.0;
    for (Index row = 0; row < landmarks + plan_.anchors; ++row) {
      const std::size_t at = place((row * kDrawn + k) * kNoiseLanes + lane_);
      nis += take(row < plan_.anchors ? 0 : row - plan_.anchors + 1, input_.measurement[at], input_.seen[at]);
    }
    values[kNisValue] = nis;
    judge(values);
    values[kVehicleValue] = P(0, 0);
    values[kLandmarksValue] = n > 1 ? trace_from(1) : 0.0;
    values[kTraceValue] = P(0, 0) + values[kLandmarksValue];
  }

 private:
  const IntermittentInput& input_;
  const IntermittentPlan& plan_;
  int lane_;

  double trace_from(Index first) const {
    double sum = P(first, first);
    for (Index i = first + 1; i < P.rows(); ++i) sum += P(i, i);
    return sum;
  }
  double lower(Index i, Index j) const { return i >= j ? P(i, j) : P(j, i); }

  void predict() {
    P(0, 0) += plan_.process_variance;
    for (Index i = 0, row = 0; plan_.constant != nullptr && i < P.rows(); ++i) {
      for (Index j = 0; j <= i; ++j) P(i, j) += plan_.constant[row++];
    }
    for (Index i = plan_.first_decorrelated; i < P.rows(); ++i) {
      for (Index j = plan_.first_decorrelated; j < i; ++j) {
        P(i, i) += std::abs(P(i, j));
        P(j, j) += std::abs(P(i, j));
        P(i, j) = 0.0;
      }
    }
  }

  /// Of landmark l, or of an anchor for l = 0.
  double take(Index l, double noise, double seen) {
    const Index n = P.rows();
    const double r = plan_.measurement_variance;
    Vector v(n), k(n), b(n);
    for (Index j = 0; j < n; ++j) v[j] = (l > 0 ? lower(l, j) : 0.0) - P(j, 0);
    const double v_l = l > 0 ? v[l] : 0.0, g = seen / (v_l - v[0] + r);
    const double nu = std::fma(plan_.measurement_std, noise, (l > 0 ? e[l] : 0.0) - e[0]);
    for (Index i = 0; i < n; ++i) k[i] = v[i] * g;
    Matrix A(n, n);
    for (Index i = 0; i < n; ++i) {
      for (Index j = 0; j <= i; ++j) A(i, j) = std::fma(-k[i], v[j], P(i, j));
    }
    for (Index i = 0; i < n; ++i) {
      const double A_il = l == 0 ? 0.0 : i >= l ? A(i, l) : A(l, i);
      b[i] = 0.5 * std::fma(-r, k[i], A_il - A(i, 0));
      e[i] = std::fma(-k[i], nu, e[i]);
    }
    for (Index i = 0; i < n; ++i) {
      for (Index j = 0; j <= i; ++j) P(i, j) = std::fma(-b[i], k[j], std::fma(-b[j], k[i], A(i, j)));
    }
    return g * nu * nu;
  }

  /// By P = L D Lᵀ.
  void judge(Eigen::Ref<Vector> values) const {
    Matrix A = P;
    Vector y = e;
    double nees = 0.0, check = 0.0;
    for (Index j = 0; j < A.rows(); ++j) {
      const double d = A(j, j), inverse = 1.0 / d;
      nees = std::fma(y[j] * y[j], inverse, nees);
      check += d - std::abs(d);
      for (Index i = j + 1; i < A.rows(); ++i) {
        const double l = A(i, j) * inverse;
        for (Index k = j + 1; k <= i; ++k) A(i, k) = std::fma(-l, A(k, j), A(i, k));
        y[i] = std::fma(-l, y[j], y[i]);
      }
    }
    values[kNeesValue] = nees;
    values[kCheckValue] = check;
  }

 public:
  Vector e;
  Matrix P;
};

IntermittentOutput by_plain_lanes(const IntermittentInput& input) {
  IntermittentOutput out;
  out.values.resize(kNoiseLanes, kStepsOfRun * kIntermittentValues);
  for (int lane = 0; lane < kNoiseLanes; ++lane) {
    PlainLane plain(input, lane);
    Vector values(kIntermittentValues);
    for (Index k = 0; k < kStepsOfRun; ++k) {
      plain.step(k, values);
      out.values.row(lane).segment(k * kIntermittentValues, kIntermittentValues) = values.transpose();
    }
    out.errors.push_back(plain.e);
    out.covariance.push_back(plain.P.triangularView<Eigen::Lower>());
  }
  return out;
}

/// By the kernel of one instruction set, in `calls` of so many steps.
IntermittentOutput by_kernel(const IntermittentInput& input, InstructionSet set,
                             const std::vector<Index>& calls) {
  const IntermittentKernel& kernel = intermittent_kernel(set);
  const int n = input.plan.states, lanes = kernel.lanes;
  const std::int64_t triangle = n * (n + 1) / 2;
  AlignedVector errors(place(n * kNoiseLanes)), covariance(place(triangle * kNoiseLanes)),
      work(place((triangle + 3 * n) * lanes)), values(place(kStepsOfRun * kIntermittentValues * kNoiseLanes));
  const auto at = [&](std::int64_t rows, std::int64_t row, int lane) {
    return place((lane / lanes * rows + row) * lanes + lane % lanes);
  };
  for (int lane = 0; lane < kNoiseLanes; ++lane) {
    for (std::int64_t i = 0, row = 0; i < n; ++i) {
      errors[at(n, i, lane)] = input.errors(i, lane);
      for (std::int64_t j = 0; j <= i; ++j) covariance[at(triangle, row++, lane)] = input.P0(i, j);
    }
  }
  Index done = 0;
  for (const Index count : calls) {
    kernel.steps(input.plan, count,
                 {.errors = errors.data(),
                  .covariance = covariance.data(),
                  .process = input.process.data() + done * kNoiseLanes,
                  .measurement = input.measurement.data() + done * kNoiseLanes,
                  .seen = input.seen.data() + done * kNoiseLanes,
                  .drawn = kDrawn,
                  .work = work.data(),
                  .values = values.data() + done * kIntermittentValues * kNoiseLanes});
    done += count;
  }
  IntermittentOutput out;
  out.values = Eigen::Map<const Matrix>(values.data(), kNoiseLanes, kStepsOfRun * kIntermittentValues);
  for (int lane = 0; lane < kNoiseLanes; ++lane) {
    Vector e(n);
    Matrix P = Matrix::Zero(n, n);
    for (std::int64_t i = 0, row = 0; i < n; ++i) {
      e[i] = errors[at(n, i, lane)];
      for (std::int64_t j = 0; j <= i; ++j) P(i, j) = covariance[at(triangle, row++, lane)];
    }
    out.errors.push_back(e);
    out.covariance.push_back(P);
  }
  return out;
}

void expect_equal_outputs(const IntermittentOutput& got, const IntermittentOutput& expected) {
  EXPECT_EQ(got.values, expected.values);
  for (std::size_t lane = 0; lane < got.errors.size(); ++lane) {
    ASSERT_EQ(got.errors[lane], expected.errors[lane]) << "lane " << lane;
    ASSERT_EQ(got.covariance[lane], expected.covariance[lane]) << "lane " << lane;
  }
}

// The states that stay in registers, n = 2 and 3 with no anchor or one, and those in memory.
TEST(IntermittentKernel, is_a_plain_lane_to_the_bit_with_every_instruction_set) {
  for (const int landmarks : {0, 1, 2, 5}) {
    for (const int anchors : {0, 1, 2}) {
      if (landmarks + anchors == 0) continue;
      for (const int first : {0, 1, landmarks + 1}) {
        for (const bool constant : {false, true}) {
          SCOPED_TRACE(std::to_string(landmarks) + " landmarks, " + std::to_string(anchors) +
                       " anchors, diagonal from " + std::to_string(first));
          const IntermittentInput input(landmarks, anchors, first, constant);
          const IntermittentOutput expected = by_plain_lanes(input);
          for (const InstructionSet set : intermittent_sets()) {
            SCOPED_TRACE(instruction_set_name(set));
            expect_equal_outputs(by_kernel(input, set, {kStepsOfRun}), expected);
            expect_equal_outputs(by_kernel(input, set, {3, 1, 0, 3}), expected);
          }
        }
      }
    }
  }
}

// P that is not positive definite is counted below zero, and one that is no number is none.
TEST(IntermittentKernel, the_check_is_zero_of_a_positive_definite_p_alone) {
  IntermittentInput input(1, 0, 2, false);
  for (double& s : input.seen) s = 0.0;
  const auto check_of = [&](double correlation) {
    input.P0 << 1.0, correlation, correlation, 1.0;
    input.plan.process_variance = 0.0;
    return by_kernel(input, best_instruction_set(), {kStepsOfRun}).values(9, kCheckValue);
  };
  EXPECT_EQ(check_of(0.5), 0.0);
  EXPECT_EQ(check_of(2.0), -6.0) << "the second pivot, 1 − 2², twice";
  EXPECT_TRUE(std::isnan(check_of(std::nan(""))));
}

// 0, 1, … 31 have mean 15.5 and squared deviations of 32 (32² − 1)/12 in all.
TEST(IntermittentKernel, moments_are_those_of_the_lanes) {
  AlignedVector x(place(3 * kNoiseLanes));
  std::mt19937_64 bits(2);
  std::normal_distribution<double> normal;
  for (std::size_t lane = 0; lane < 32; ++lane) {
    x[lane] = static_cast<double>(lane);
    x[32 + lane] = 7.0;
    x[64 + lane] = normal(bits);
  }
  const auto sum_of_eight = [](const auto& term) {
    double s[8];
    for (std::size_t i = 0; i < 8; ++i) s[i] = (term(i) + term(i + 8)) + (term(i + 16) + term(i + 24));
    return ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7]));
  };
  const double centre = sum_of_eight([&](std::size_t i) { return x[64 + i]; }) / 32.0;
  for (const InstructionSet set : intermittent_sets()) {
    double mean[3], m2[3];
    intermittent_kernel(set).moments(x.data(), 3, mean, m2);
    EXPECT_EQ(mean[0], 15.5);
    EXPECT_EQ(m2[0], 2728.0);
    EXPECT_EQ(mean[1], 7.0);
    EXPECT_EQ(m2[1], 0.0);
    EXPECT_EQ(mean[2], centre) << instruction_set_name(set);
    EXPECT_EQ(m2[2], sum_of_eight([&](std::size_t i) { return (x[64 + i] - centre) * (x[64 + i] - centre); }))
        << instruction_set_name(set);
  }
}

TEST(IntermittentKernel, every_instruction_set_has_a_kernel_of_its_own_or_is_refused) {
  EXPECT_EQ(intermittent_kernel(InstructionSet::scalar).lanes, 1);
  for (const auto& [set, lanes] : {std::pair{InstructionSet::avx2, 4}, {InstructionSet::avx512, 8}}) {
    if (is_supported(set)) {
      EXPECT_EQ(intermittent_kernel(set).lanes, lanes);
    } else {
      EXPECT_THROW(intermittent_kernel(set), std::invalid_argument) << instruction_set_name(set);
    }
  }
}

}  // namespace
}  // namespace credence::internal
