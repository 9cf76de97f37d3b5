#include "core/simd/block_map_kernel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "core/simd/aligned_vector.h"

namespace credence::internal {
namespace {

/// A random map of which a few landmarks are zero, two directions and a frame.
struct Problem {
  std::int64_t landmarks, stride;
  int vehicle, landmark;
  AlignedVector rf, blocks, reciprocals, shift;
  BlockMapDirections directions;
  BlockMapFrame frame;

  Problem(std::int64_t N, int nr, int d) : landmarks(N), stride((N + 7) / 8 * 8), vehicle(nr), landmark(d) {
    std::mt19937_64 bits(17);
    std::normal_distribution<double> normal;
    rf.assign(static_cast<std::size_t>(nr * d * stride), 0.0);
    blocks.assign(static_cast<std::size_t>(d * (d + 1) / 2 * stride), 0.0);
    reciprocals.assign(static_cast<std::size_t>(2 * stride), 0.0);
    shift.assign(static_cast<std::size_t>(d * stride), 0.0);
    for (std::int64_t j = 0; j < N; ++j) {
      for (int a = 0; a < nr * d; ++a) rf[at(a, j)] = j % 11 == 3 ? 0.0 : normal(bits);
      for (int b = 0; b < d * (d + 1) / 2; ++b) blocks[at(b, j)] = 1.0 + normal(bits);
    }
    directions.count = 2;
    for (auto& g : directions.g) {
      for (double& x : g) x = normal(bits);
    }
    for (auto& g : frame.g) {
      for (double& x : g) x = normal(bits);
    }
  }
  std::size_t at(int array, std::int64_t j) const { return static_cast<std::size_t>(array * stride + j); }
  BlockMapArrays arrays() { return {rf.data(), blocks.data(), stride, stride / 8}; }
  double along(int i, int c, std::int64_t j) const {
    double sum = 0.0;
    for (int a = 0; a < vehicle; ++a) sum += directions.g[i][a] * rf[at(a * landmark + c, j)];
    return sum;
  }
  /// Component c of landmark j along direction i of the frame.
  double in_frame(int i, int c, std::int64_t j) const {
    double sum = 0.0;
    for (int a = 0; a < vehicle; ++a) sum += frame.g[i][a] * rf[at(a * landmark + c, j)];
    return sum;
  }
  double frame_norm(std::int64_t j) const {
    double square = 0.0;
    for (int i = 0; i < vehicle; ++i) {
      for (int c = 0; c < landmark; ++c) square += in_frame(i, c, j) * in_frame(i, c, j);
    }
    return std::sqrt(square);
  }
  double norm(int i, std::int64_t j) const {
    return std::hypot(along(i, 0, j), landmark == 2 ? along(i, 1, j) : 0.0);
  }
};

struct Shape {
  int vehicle, landmark;
};
constexpr Shape kShapes[] = {{3, 2}, {1, 1}, {3, 1}, {1, 2}};
constexpr std::int64_t kSizes[] = {0, 1, 8, 13, 200};

TEST(BlockMapKernel, NormsAreThoseOfTheDirections) {
  for (const Shape& shape : kShapes) {
    for (const std::int64_t N : kSizes) {
      Problem p(N, shape.vehicle, shape.landmark);
      BlockMapNorms out[2];
      block_map_kernel(shape.vehicle, shape.landmark)
          .norms(p.arrays(), p.directions, p.reciprocals.data(), out);
      for (int i = 0; i < 2; ++i) {
        double sum = 0.0, largest = 0.0;
        for (std::int64_t j = 0; j < N; ++j) {
          const double norm = p.norm(i, j);
          sum += norm;
          largest = std::max(largest, norm);
          if (norm == 0.0) continue;
          EXPECT_NEAR(p.reciprocals[p.at(i, j)] * norm, 1.0, 1e-14);
        }
        EXPECT_NEAR(out[i].largest, largest, 1e-15 * largest);
        EXPECT_NEAR(out[i].others, sum - largest, 1e-13 * sum);
      }
    }
  }
}

TEST(BlockMapKernel, ATinyRestIsNotLostBesideAHugeLandmark) {
  Problem p(24, 1, 1);
  for (double& x : p.rf) x = 1e-17;
  p.rf[9] = 1.0;
  p.directions.g[0][0] = 1.0;
  BlockMapNorms out[2];
  block_map_kernel(1, 1).norms(p.arrays(), p.directions, p.reciprocals.data(), out);
  EXPECT_NEAR(out[0].largest, 1.0, 1e-15);
  EXPECT_NEAR(out[0].others, 23e-17, 1e-29);
}

TEST(BlockMapKernel, InflatesByTheSharesAndReturnsTheTrace) {
  for (const Shape& shape : kShapes) {
    Problem p(29, shape.vehicle, shape.landmark);
    const Problem before = p;
    const BlockMapKernel& kernel = block_map_kernel(shape.vehicle, shape.landmark);
    BlockMapNorms out[2];
    kernel.norms(p.arrays(), p.directions, p.reciprocals.data(), out);
    const double excess[2] = {0.7, 0.2};
    const double trace = kernel.inflate(p.arrays(), p.directions, excess, p.reciprocals.data());
    double expected_trace = 0.0;
    for (std::int64_t j = 0; j < 29; ++j) {
      for (int a = 0; a < shape.landmark; ++a) {
        for (int b = 0; b <= a; ++b) {
          double expected = before.blocks[p.at(a + b, j)];
          for (int i = 0; i < 2; ++i) {
            if (p.norm(i, j) > 0.0)
              expected += excess[i] / p.norm(i, j) * p.along(i, a, j) * p.along(i, b, j);
          }
          EXPECT_NEAR(p.blocks[p.at(a + b, j)], expected, 1e-14);
          if (a == b) expected_trace += expected;
        }
      }
    }
    EXPECT_NEAR(trace, expected_trace, 1e-12);
  }
}

TEST(BlockMapKernel, MomentsAreThoseOfTheFrame) {
  for (const Shape& shape : kShapes) {
    for (const std::int64_t N : kSizes) {
      Problem p(N, shape.vehicle, shape.landmark);
      BlockMapMoments out;
      block_map_kernel(shape.vehicle, shape.landmark)
          .moments(p.arrays(), p.frame, p.reciprocals.data(), &out);
      double norms = 0.0;
      for (std::int64_t j = 0; j < N; ++j) {
        norms += p.frame_norm(j);
        if (p.frame_norm(j) > 0.0) {
          EXPECT_NEAR(p.reciprocals[p.at(0, j)] * p.frame_norm(j), 1.0, 1e-14);
        }
      }
      EXPECT_NEAR(out.norms, norms, 1e-13 * norms);
      for (int i = 0, entry = 0; i < shape.vehicle; ++i) {
        for (int k = 0; k <= i; ++k, ++entry) {
          double expected = 0.0;
          for (std::int64_t j = 0; j < N; ++j) {
            if (p.frame_norm(j) == 0.0) continue;
            for (int c = 0; c < shape.landmark; ++c) {
              expected += p.in_frame(i, c, j) * p.in_frame(k, c, j) / p.frame_norm(j);
            }
          }
          EXPECT_NEAR(out.squares[entry], expected, 1e-13 * norms);
        }
      }
    }
  }
}

TEST(BlockMapKernel, SpreadsOverTheBlocksAndReturnsTheTrace) {
  for (const Shape& shape : kShapes) {
    Problem p(29, shape.vehicle, shape.landmark);
    const Problem before = p;
    const BlockMapKernel& kernel = block_map_kernel(shape.vehicle, shape.landmark);
    BlockMapMoments out;
    kernel.moments(p.arrays(), p.frame, p.reciprocals.data(), &out);
    const double trace = kernel.spread(p.arrays(), p.frame, p.reciprocals.data());
    double expected_trace = 0.0;
    for (std::int64_t j = 0; j < 29; ++j) {
      for (int a = 0; a < shape.landmark; ++a) {
        for (int b = 0; b <= a; ++b) {
          double expected = before.blocks[p.at(a + b, j)];
          for (int i = 0; i < shape.vehicle && p.frame_norm(j) > 0.0; ++i) {
            expected += p.in_frame(i, a, j) * p.in_frame(i, b, j) / p.frame_norm(j);
          }
          EXPECT_NEAR(p.blocks[p.at(a + b, j)], expected, 1e-14 * (1.0 + std::abs(expected)));
          if (a == b) expected_trace += expected;
        }
      }
    }
    EXPECT_NEAR(trace, expected_trace, 1e-12);
  }
}

TEST(BlockMapKernel, TransformsTheMap) {
  Problem p(29, 3, 2);
  const Problem before = p;
  const double T[9] = {0.5, 1.0, -2.0, 0.0, 3.0, 0.25, 1.0, -1.0, 0.125}, w[3] = {1.0, -0.5, 2.0};
  block_map_kernel(3, 2).transform(p.arrays(), T, w, p.shift.data());
  for (std::int64_t j = 0; j < 29; ++j) {
    for (int c = 0; c < 2; ++c) {
      double shift = 0.0;
      for (int a = 0; a < 3; ++a) {
        double expected = 0.0;
        for (int b = 0; b < 3; ++b) expected += T[3 * a + b] * before.rf[p.at(b * 2 + c, j)];
        EXPECT_NEAR(p.rf[p.at(a * 2 + c, j)], expected, 1e-14);
        shift += w[a] * before.rf[p.at(a * 2 + c, j)];
      }
      EXPECT_NEAR(p.shift[p.at(c, j)], shift, 1e-14);
    }
  }
}

bool same_bits(const AlignedVector& a, const AlignedVector& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0);
}

class BlockMapKernelBits : public testing::TestWithParam<InstructionSet> {};

TEST_P(BlockMapKernelBits, AreTheSameForEveryInstructionSet) {
  if (!is_supported(GetParam())) GTEST_SKIP() << instruction_set_name(GetParam()) << " is not supported here";
  for (const Shape& shape : kShapes) {
    const BlockMapKernel* kernel = block_map_kernel(GetParam(), shape.vehicle, shape.landmark);
    if (kernel == nullptr) GTEST_SKIP() << "not in this binary";
    const BlockMapKernel* plain = block_map_kernel(InstructionSet::scalar, shape.vehicle, shape.landmark);
    for (const std::int64_t N : kSizes) {
      Problem a(N, shape.vehicle, shape.landmark), b = a;
      for (const int count : {1, 2}) {
        a.directions.count = b.directions.count = count;
        BlockMapNorms out_a[2], out_b[2];
        kernel->norms(a.arrays(), a.directions, a.reciprocals.data(), out_a);
        plain->norms(b.arrays(), b.directions, b.reciprocals.data(), out_b);
        EXPECT_EQ(0, std::memcmp(out_a, out_b, sizeof out_a));
        const double excess[2] = {0.3, 1.7};
        EXPECT_EQ(kernel->inflate(a.arrays(), a.directions, excess, a.reciprocals.data()),
                  plain->inflate(b.arrays(), b.directions, excess, b.reciprocals.data()));
        BlockMapMoments moments_a, moments_b;
        kernel->moments(a.arrays(), a.frame, a.reciprocals.data(), &moments_a);
        plain->moments(b.arrays(), b.frame, b.reciprocals.data(), &moments_b);
        EXPECT_EQ(0, std::memcmp(&moments_a, &moments_b, sizeof moments_a));
        EXPECT_EQ(kernel->spread(a.arrays(), a.frame, a.reciprocals.data()),
                  plain->spread(b.arrays(), b.frame, b.reciprocals.data()));
        const double T[9] = {0.5, 1.0, -2.0, 0.1, 3.0, 0.25, 1.0, -1.0, 0.125}, w[3] = {1.0, -0.5, 2.0};
        kernel->transform(a.arrays(), T, w, a.shift.data());
        plain->transform(b.arrays(), T, w, b.shift.data());
        EXPECT_TRUE(same_bits(a.rf, b.rf) && same_bits(a.blocks, b.blocks) && same_bits(a.shift, b.shift) &&
                    same_bits(a.reciprocals, b.reciprocals));
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Sets, BlockMapKernelBits,
                         testing::Values(InstructionSet::avx2, InstructionSet::avx512),
                         [](const auto& instance) { return instruction_set_name(instance.param); });

TEST(BlockMapKernel, OtherSizesAreRefused) {
  EXPECT_THROW(block_map_kernel(2, 2), std::invalid_argument);
  EXPECT_EQ(block_map_kernel(InstructionSet::scalar, 3, 3), nullptr);
}

}  // namespace
}  // namespace credence::internal
