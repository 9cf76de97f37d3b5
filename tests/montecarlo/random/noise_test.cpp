#include "montecarlo/random/noise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <set>
#include <stdexcept>
#include <tuple>
#include <vector>

namespace credence::internal {
namespace {

using Purpose = NoisePurpose;

/// `count` normals of consecutive slots, then runs: any mixture of keys must be a sample of N(0, 1).
std::vector<double> sample(std::size_t count) {
  const NoiseSource source(1, 0);
  constexpr std::size_t kSlots = 50000;
  std::vector<double> x(count);
  for (std::size_t i = 0, run = 0; i < count; i += kSlots, ++run) {
    const std::size_t slots = std::min(kSlots, count - i);
    source.normals(static_cast<std::int64_t>(run), static_cast<std::int64_t>(run % 7), Purpose::process,
                   {x.data() + i, slots});
  }
  return x;
}

double standard_normal_cdf(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }

/// (2k − 1)!! = E[x^{2k}]
double even_moment(int k) {
  double product = 1.0;
  for (int i = 2 * k - 1; i > 1; i -= 2) product *= i;
  return product;
}

/// Correlation of two samples of N(0, 1) with known mean and variance, in standard errors.
double correlation_z(const std::vector<double>& x, const std::vector<double>& y) {
  double sum = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) sum += x[i] * y[i];
  return sum / std::sqrt(static_cast<double>(x.size()));
}

/// The same for lag `lag` within one sample.
double lag_z(const std::vector<double>& x, std::size_t lag) {
  double sum = 0.0;
  for (std::size_t i = lag; i < x.size(); ++i) sum += x[i] * x[i - lag];
  return sum / std::sqrt(static_cast<double>(x.size() - lag));
}

TEST(Noise, moments_to_the_eighth_are_those_of_the_normal_law) {
  const std::vector<double> x = sample(2'000'000);
  const double n = static_cast<double>(x.size());
  double sums[9] = {};
  for (const double value : x) {
    double power = 1.0;
    for (int k = 1; k <= 8; ++k) sums[k] += (power *= value);
  }
  for (int k = 1; k <= 8; ++k) {
    const double expected = k % 2 == 0 ? even_moment(k / 2) : 0.0;
    const double variance = even_moment(k) - expected * expected;
    const double bound = 5.0 * std::sqrt(variance / n);
    EXPECT_NEAR(sums[k] / n, expected, bound) << "moment " << k;
  }
}

TEST(Noise, kolmogorov_smirnov_finds_no_distance_from_the_normal_law) {
  std::vector<double> x = sample(500'000);
  std::sort(x.begin(), x.end());
  const double n = static_cast<double>(x.size());
  double distance = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double cdf = standard_normal_cdf(x[i]);
    distance = std::max({distance, cdf - static_cast<double>(i) / n, static_cast<double>(i + 1) / n - cdf});
  }
  // Kolmogorov's law: P(sqrt(n) D > 2.62) = 2 exp(−2 · 2.62²) = 2e-6
  EXPECT_LT(std::sqrt(n) * distance, 2.62);
}

TEST(Noise, tails_have_the_share_of_the_normal_law) {
  const std::vector<double> x = sample(4'000'000);
  const double n = static_cast<double>(x.size());
  for (const double bound : {1.0, 2.0, 3.0, 4.0}) {
    const double p = standard_normal_cdf(-bound);
    const double tolerance = 5.0 * std::sqrt(n * p);
    const auto above = std::count_if(x.begin(), x.end(), [&](double value) { return value > bound; });
    const auto below = std::count_if(x.begin(), x.end(), [&](double value) { return value < -bound; });
    EXPECT_NEAR(static_cast<double>(above), n * p, tolerance) << bound;
    EXPECT_NEAR(static_cast<double>(below), n * p, tolerance) << bound;
  }
}

TEST(Noise, slots_are_not_correlated_at_any_lag) {
  const std::vector<double> x = sample(500'000);
  for (const std::size_t lag : {1u, 2u, 3u, 4u, 5u, 7u, 8u, 16u, 32u, 64u, 256u, 50000u}) {
    EXPECT_LT(std::abs(lag_z(x, lag)), 5.0) << "lag " << lag;
  }
  // also not the squares: a pair of Box–Muller shares its radius with nobody else
  std::vector<double> y(x);
  for (double& value : y) value = (value * value - 1.0) / std::numbers::sqrt2;
  for (const std::size_t lag : {1u, 2u, 3u, 4u, 8u, 32u}) {
    EXPECT_LT(std::abs(lag_z(y, lag)), 5.0) << "lag " << lag << " of squares";
  }
}

TEST(Noise, steps_of_one_run_are_independent) {
  // eight consecutive steps cover all places within a block, and two blocks
  const NoiseSource source(3, 1);
  std::vector<std::vector<double>> steps;
  for (std::int64_t step = 0; step < 8; ++step) {
    steps.emplace_back(100'000);
    source.normals(4, step, Purpose::measurement, steps.back());
  }
  for (std::size_t i = 0; i < steps.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_LT(std::abs(correlation_z(steps[i], steps[j])), 5.0) << i << " and " << j;
      std::vector<double> a(steps[i]), b(steps[j]);
      for (double& value : a) value = (value * value - 1.0) / std::numbers::sqrt2;
      for (double& value : b) value = (value * value - 1.0) / std::numbers::sqrt2;
      EXPECT_LT(std::abs(correlation_z(a, b)), 5.0) << "squares of " << i << " and " << j;
    }
  }
}

TEST(Noise, every_part_of_the_key_matters) {
  using Key = std::tuple<std::uint64_t, std::uint64_t, std::int64_t, std::int64_t, Purpose, std::int64_t>;
  std::set<double> normals, uniforms;
  std::size_t keys = 0;
  const auto add = [&](const Key& key) {
    const auto [seed, group, run, step, purpose, slot] = key;
    normals.insert(NoiseSource(seed, group).normal(run, step, purpose, slot));
    uniforms.insert(NoiseSource(seed, group).uniform(run, step, purpose, slot));
    ++keys;
  };
  constexpr std::int64_t high = std::int64_t{1} << 32;
  for (const std::uint64_t seed : {0ull, 1ull, 2ull, 1ull << 63}) {
    for (const std::uint64_t group : {0ull, 1ull, 2ull, 1ull << 32}) {
      for (const std::int64_t run : {std::int64_t{0}, std::int64_t{1}, high, high + 1}) {
        for (const std::int64_t step : {0, 1, 2, 3, 4, 5}) {
          for (const Purpose purpose : {Purpose::initial, Purpose::process, Purpose::measurement}) {
            for (const std::int64_t slot : {0, 1, (1 << 24) - 1})
              add({seed, group, run, step, purpose, slot});
          }
        }
      }
    }
  }
  EXPECT_EQ(normals.size(), keys);
  EXPECT_EQ(uniforms.size(), keys);
}

TEST(Noise, a_number_depends_on_its_key_alone) {
  const NoiseSource source(7, 3);
  std::vector<double> all(41);
  source.normals(12, 5, Purpose::measurement, all);
  for (std::int64_t first = 0; first < 41; first += 5) {
    for (std::int64_t count = 0; first + count <= 41; count += 3) {
      std::vector<double> some(static_cast<std::size_t>(count));
      source.normals(12, 5, Purpose::measurement, some, first);
      EXPECT_TRUE(std::equal(some.begin(), some.end(), all.begin() + first)) << first << " + " << count;
    }
  }
  EXPECT_EQ(NoiseSource(7, 3).normal(12, 5, Purpose::measurement, 40), all[40]);
}

TEST(Noise, lanes_over_runs_are_the_same_numbers) {
  const NoiseSource source(7, 3);
  constexpr std::int64_t kSlots = 3, kSteps = 12;
  std::vector<double> all(kSlots * kSteps * NoiseSource::kLanes);
  source.normals_of_runs(1000, 5, kSteps, Purpose::process, kSlots, all);
  std::size_t i = 0;
  for (std::int64_t slot = 0; slot < kSlots; ++slot) {
    for (std::int64_t k = 0; k < kSteps; ++k) {
      for (int lane = 0; lane < NoiseSource::kLanes; ++lane, ++i) {
        ASSERT_EQ(all[i], source.normal(1000 + lane, 5 + k, Purpose::process, slot));
      }
    }
  }
  EXPECT_THROW(source.normals_of_runs(0, 4, kSteps, Purpose::process, kSlots, all), std::invalid_argument);
  EXPECT_THROW(source.normals_of_runs(0, 5, 11, Purpose::process, kSlots, all), std::invalid_argument);
  EXPECT_THROW(source.normals_of_runs(0, 5, kSteps, Purpose::process, 2, all), std::invalid_argument);
  EXPECT_THROW(source.normals_of_runs(0, 5, kSteps, Purpose::process, -1, all), std::invalid_argument);
  EXPECT_THROW(source.normals_of_runs(-1, 5, kSteps, Purpose::process, kSlots, all), std::invalid_argument);
  EXPECT_THROW(source.normals_of_runs(INT64_MAX, 5, kSteps, Purpose::process, kSlots, all),
               std::invalid_argument);
}

// What this program gave when the definition of montecarlo/random/noise.h was fixed: a change of these
// numbers changes every stored result.
TEST(Noise, four_steps_at_once_are_the_same_numbers) {
  for (const InstructionSet set : {InstructionSet::scalar, InstructionSet::avx2, InstructionSet::avx512}) {
    if (!is_supported(set)) continue;
    const NoiseSource source(5, 6, set);
    for (const std::int64_t slots : {0, 1, 2, 3, 8, 21}) {
      std::vector<double> four(static_cast<std::size_t>(4 * slots)), one(static_cast<std::size_t>(slots));
      source.normals_of_four_steps(7, 9, NoisePurpose::measurement, slots, four);
      for (std::int64_t k = 0; k < 4; ++k) {
        source.normals(7, 9 + k, NoisePurpose::measurement, one);
        for (std::int64_t i = 0; i < slots; ++i) {
          EXPECT_EQ(four[static_cast<std::size_t>(k * slots + i)], one[static_cast<std::size_t>(i)]);
        }
      }
    }
  }
  std::vector<double> out(8);
  const NoiseSource source(5, 6);
  EXPECT_THROW(source.normals_of_four_steps(0, 2, NoisePurpose::process, 2, out), std::invalid_argument);
  EXPECT_THROW(source.normals_of_four_steps(0, 1, NoisePurpose::process, 3, out), std::invalid_argument);
}

TEST(Noise, numbers_stay_what_they_are) {
  const NoiseSource source(1, 0);
  EXPECT_EQ(source.key(), 6791897765849424158u);
  const double expected[5][2] = {{0x1.b177ce931b93p-2, 0x1.cacc142fd93acp-4},
                                 {0x1.32d6e099a9b35p-5, -0x1.04f99c41d502bp-1},
                                 {0x1.87838060c0be4p+0, 0x1.116472772dbd6p-1},
                                 {0x1.c4c20708c7913p-4, 0x1.00727f87b5661p+0},
                                 {0x1.ec0b5f7d3d7afp+0, -0x1.9bb462b72b5f9p+0}};
  for (std::int64_t step = 0; step < 5; ++step) {
    EXPECT_EQ(source.normal(0, step, Purpose::process, 0), expected[step][0]);
    EXPECT_EQ(source.normal(0, step, Purpose::process, 1), expected[step][1]);
  }
  EXPECT_EQ(source.uniform(0, 1, Purpose::world, 2), 0x1.87759636214e4p-2);
}

TEST(Noise, uniforms_are_uniform) {
  const NoiseSource source(2, 0);
  constexpr int kBins = 64, kCount = 64'000;
  std::vector<int> bins(kBins);
  for (int i = 0; i < kCount; ++i) {
    const double u = source.uniform(i, 1, Purpose::decision, 0);
    ASSERT_GE(u, 0.0);
    ASSERT_LT(u, 1.0);
    ++bins[static_cast<std::size_t>(u * kBins)];
  }
  double chi2 = 0.0;
  for (const int count : bins) chi2 += std::pow(count - kCount / kBins, 2) / (kCount / kBins);
  // χ²(63): mean 63, variance 126; five standard deviations
  EXPECT_NEAR(chi2, 63.0, 5.0 * std::sqrt(126.0));
}

TEST(Noise, events_happen_with_their_probability_and_on_their_own) {
  const NoiseSource source(5, 2);
  constexpr std::int64_t kSlots = 1000, kRuns = 100;
  for (const double p : {0.001, 0.25, 0.9}) {
    double happened = 0.0, with_next = 0.0, with_step = 0.0;
    std::vector<double> x(4 * kSlots);
    for (std::int64_t run = 0; run < kRuns; ++run) {
      source.events_of_four_steps(run, 5, Purpose::detection, p, kSlots, x);
      for (std::size_t i = 0; i < x.size(); ++i) {
        ASSERT_TRUE(x[i] == 0.0 || x[i] == 1.0);
        happened += x[i];
        with_next += (x[i] - p) * (x[(i + 1) % x.size()] - p);
        with_step += (x[i] - p) * (x[(i + kSlots) % x.size()] - p);
      }
    }
    const double n = 4.0 * kSlots * kRuns, variance = p * (1.0 - p);
    EXPECT_NEAR(happened, n * p, 5.0 * std::sqrt(n * variance)) << p;
    EXPECT_NEAR(with_next, 0.0, 5.0 * std::sqrt(n) * variance) << p;
    EXPECT_NEAR(with_step, 0.0, 5.0 * std::sqrt(n) * variance) << p;
  }
}

TEST(Noise, events_in_lanes_are_the_same_events) {
  for (const InstructionSet set : {InstructionSet::scalar, InstructionSet::avx2, InstructionSet::avx512}) {
    if (!is_supported(set)) continue;
    const NoiseSource lanes(5, 2, set), scalar(5, 2, InstructionSet::scalar);
    constexpr std::int64_t kSlots = 3, kSteps = 40;
    std::vector<double> of_runs(kSlots * kSteps * NoiseSource::kLanes), of_steps(4 * kSlots);
    lanes.events_of_runs(100, 9, kSteps, Purpose::detection, 0.3, kSlots, of_runs);
    for (const std::int64_t lane : {0, 1, 7, 31}) {
      for (std::int64_t k = 0; k < kSteps; ++k) {
        if (k % 4 == 0)
          scalar.events_of_four_steps(100 + lane, 9 + k, Purpose::detection, 0.3, kSlots, of_steps);
        for (std::int64_t slot = 0; slot < kSlots; ++slot) {
          EXPECT_EQ(of_runs[static_cast<std::size_t>((slot * kSteps + k) * NoiseSource::kLanes + lane)],
                    of_steps[static_cast<std::size_t>(k % 4 * kSlots + slot)])
              << lane << ' ' << k << ' ' << slot;
        }
      }
    }
  }
}

TEST(Noise, what_is_certain_happens_and_what_is_impossible_does_not) {
  const NoiseSource source(1, 0);
  std::vector<double> x(4000);
  source.events_of_four_steps(0, 1, Purpose::detection, 1.0, 1000, x);
  EXPECT_EQ(std::count(x.begin(), x.end(), 1.0), 4000);
  source.events_of_four_steps(0, 1, Purpose::detection, 0.0, 1000, x);
  EXPECT_EQ(std::count(x.begin(), x.end(), 0.0), 4000);
  for (const double wrong : {-0.1, 1.1, std::nan("")}) {
    EXPECT_THROW(source.events_of_four_steps(0, 1, Purpose::detection, wrong, 1000, x),
                 std::invalid_argument);
  }
  EXPECT_THROW(source.events_of_four_steps(0, 2, Purpose::detection, 0.5, 1000, x), std::invalid_argument);
  EXPECT_THROW(source.events_of_runs(0, 1, 3, Purpose::detection, 0.5, 1, x), std::invalid_argument);
}

TEST(Noise, refuses_keys_that_do_not_exist) {
  const NoiseSource source(1, 1);
  std::vector<double> x(3);
  EXPECT_THROW(source.normals(-1, 0, Purpose::process, x), std::invalid_argument);
  EXPECT_THROW(source.normals(0, -1, Purpose::process, x), std::invalid_argument);
  EXPECT_THROW(source.normals(0, (std::int64_t{1} << 32) - 3, Purpose::process, x), std::invalid_argument);
  EXPECT_THROW(source.normals(0, 0, static_cast<Purpose>(64), x), std::invalid_argument);
  EXPECT_THROW(source.normals(0, 0, Purpose::process, x, -1), std::invalid_argument);
  EXPECT_THROW(source.normals(0, 0, Purpose::process, x, (1 << 24) - 2), std::invalid_argument);
  EXPECT_NO_THROW(source.normals(0, 0, Purpose::process, x, (1 << 24) - 3));
  EXPECT_NO_THROW(source.normals(INT64_MAX, (std::int64_t{1} << 32) - 4, Purpose::process, x));
  EXPECT_THROW(source.uniform(0, 0, Purpose::process, 1 << 24), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
