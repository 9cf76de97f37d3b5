#include "montecarlo/lanes/linear_kernel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "montecarlo/lanes/linear_kernel_units.h"
#include "tests/montecarlo/lanes/linear_systems.h"

namespace credence::internal {
namespace {

std::vector<InstructionSet> supported_sets() {
  std::vector<InstructionSet> sets;
  for (const InstructionSet set : {InstructionSet::scalar, InstructionSet::avx2, InstructionSet::avx512}) {
    if (is_supported(set)) sets.push_back(set);
  }
  return sets;
}

/// y + M x, term by term, and with zeros left in.
Vector plus_product(const Matrix& matrix, const Vector& x, Vector y) {
  for (Index row = 0; row < matrix.rows(); ++row) {
    for (Index j = 0; j < matrix.cols(); ++j) y[row] = std::fma(matrix(row, j), x[j], y[row]);
  }
  return y;
}

Vector product(const Matrix& matrix, const Vector& x) {
  return plus_product(matrix, x, Vector::Zero(matrix.rows()));
}

double plus_squares(const Vector& y, double sum) {
  for (const double value : y) sum = std::fma(value, value, sum);
  return sum;
}

/// The sums that LinearSimulator::simulate documents, of NEES or NIS at one step.
struct Sums {
  double first[8] = {}, second[8] = {};

  void add(Index run, double deviation) {
    first[run % 8] += deviation;
    second[run % 8] = std::fma(deviation, deviation, second[run % 8]);
  }
  static double tree(const double* s) {
    return ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7]));
  }
  Moments moments(Index runs, Index dof, double scale) const {
    const double shift = tree(first) / static_cast<double>(runs);
    return {.count = runs,
            .mean = static_cast<double>(dof) + scale * shift,
            .m2 = scale * scale * std::max(0.0, tree(second) - tree(first) * shift)};
  }
};

/// A plain loop over runs and steps, with one number of noise at a time: the specification of the kernel, and
/// of trace_linear, to the last bit.
void expect_bits_of_plain_loop(const std::string& name, const LinearErrorSystem& system, Index first_run,
                               Index runs) {
  const LinearSystemInUnits units = linear_system_in_units(system);
  const LinearErrorSystem& s = units.system;
  const NoiseSource noise(11, 3, InstructionSet::scalar);
  const auto normals = [&](Index run, Index step, NoisePurpose purpose, Index count) {
    Vector x(count);
    for (Index i = 0; i < count; ++i) x[i] = noise.normal(run, step, purpose, i);
    return x;
  };
  std::vector<Sums> nees(s.steps.size()), nis(s.steps.size());
  for (Index i = 0; i < runs; ++i) {
    const Index run = first_run + i;
    const LinearRunTrace trace = trace_linear(system, noise, run);
    Vector e = product(s.initial_root, normals(run, 0, NoisePurpose::initial, s.F.rows()));
    ASSERT_EQ(trace.initial_error, units.unit * e);
    for (std::size_t k = 0; k < s.steps.size(); ++k) {
      const LinearErrorSystem::Step& step = s.steps[k];
      const Index number = static_cast<Index>(k) + 1;
      const Vector v = normals(run, number, NoisePurpose::process, s.noise_input.cols());
      const Vector w = normals(run, number, NoisePurpose::measurement, s.H.rows());
      e = plus_product(s.noise_input, v, product(s.F, e));
      const Vector nu = plus_product(s.measurement_root, w, product(s.H, e));
      e = plus_product(-step.K, nu, e);
      const Vector error = product(step.error_whitening, e),
                   innovation = product(step.innovation_whitening, nu);
      nees[k].add(i, plus_squares(error, -static_cast<double>(error.size()) / units.nees_scale[k]));
      nis[k].add(i, plus_squares(innovation, -static_cast<double>(innovation.size()) / units.nis_scale[k]));
      ASSERT_EQ(trace.errors[k], units.unit * e);
      ASSERT_EQ(trace.innovations[k], units.unit * nu);
      ASSERT_EQ(trace.nees[k], units.nees_scale[k] * plus_squares(error, 0.0));
      ASSERT_EQ(trace.nis[k], units.nis_scale[k] * plus_squares(innovation, 0.0));
    }
  }
  for (const InstructionSet set : supported_sets()) {
    std::vector<Moments> got_nees(s.steps.size()), got_nis(s.steps.size());
    LinearSimulator(system).simulate(NoiseSource(11, 3, set), first_run, runs, got_nees, got_nis);
    for (std::size_t k = 0; k < s.steps.size(); ++k) {
      const std::string where = name + ", " + instruction_set_name(set) + ", runs " + std::to_string(runs) +
                                ", step " + std::to_string(k + 1);
      const Index error_dof = s.steps[k].error_whitening.rows(),
                  nis_dof = s.steps[k].innovation_whitening.rows();
      ASSERT_EQ(got_nees[k], nees[k].moments(runs, error_dof, units.nees_scale[k])) << where;
      ASSERT_EQ(got_nis[k], nis[k].moments(runs, nis_dof, units.nis_scale[k])) << where;
    }
  }
}

TEST(LinearKernel, lanes_are_a_plain_loop_to_the_last_bit) {
  for (const Index runs : {1, 5, 8, 31, 32, 33, 70}) {
    expect_bits_of_plain_loop("one landmark", monobot_system(1, 0, Inflation::none, 38), 3, runs);
  }
  for (const Inflation inflation : {Inflation::none, Inflation::full, Inflation::map}) {
    expect_bits_of_plain_loop("one anchored", monobot_system(1, 1, inflation, 9), 0, 40);
    expect_bits_of_plain_loop("two", monobot_system(2, 0, inflation, 9), 100, 40);
    expect_bits_of_plain_loop("two anchored", monobot_system(2, 1, inflation, 9), 7, 40);
    expect_bits_of_plain_loop("three", monobot_system(3, 0, inflation, 9), 7, 37);
  }
  expect_bits_of_plain_loop("two anchors", monobot_system(2, 2, Inflation::none, 5), 7, 40);
  expect_bits_of_plain_loop("nineteen", monobot_system(19, 1, Inflation::map, 6), 7, 37);
}

TEST(LinearKernel, any_system_will_do) {
  for (const Index n : {2, 3, 5, 8, 13}) {
    for (const Index m : {1, 2, 4, 7}) {
      expect_bits_of_plain_loop("n " + std::to_string(n) + " m " + std::to_string(m),
                                unstructured_system(n, m, 7), 1, 43);
    }
  }
}

TEST(LinearKernel, more_runs_than_one_batch) {
  expect_bits_of_plain_loop("one landmark", monobot_system(1, 0, Inflation::none, 3), 0, 1100);
  expect_bits_of_plain_loop("forty", monobot_system(40, 0, Inflation::none, 2), 0, 70);
}

TEST(LinearKernel, monobots_with_a_missing_direction_use_the_general_kernel) {
  // the landmark is known exactly: its variance is zero, P has rank one
  LinearModel model = monobot_model(1, 0, 0.1, 0.1, 1.0);
  model.P0(1, 1) = 0.0;
  const LinearErrorSystem system = linear_error_system(model, model, Inflation::none, 6);
  ASSERT_EQ(system.steps[0].error_whitening.rows(), 1);
  expect_bits_of_plain_loop("known landmark", system, 0, 33);
}

// Expected values at step 100: theory, section 6.
TEST(LinearKernel, means_are_the_exact_ones_of_the_theory) {
  struct Case {
    const char* name;
    Index landmarks, anchors;
    Inflation inflation;
    double nees, nis;
  };
  const Case cases[] = {{"1 partial none", 1, 0, Inflation::none, 2, 1},
                        {"1 partial full", 1, 0, Inflation::full, 1.976957769, 0.025033555},
                        {"1 anchored none", 1, 1, Inflation::none, 2, 2},
                        {"1 anchored full", 1, 1, Inflation::full, 1.636610019, 1.726779962},
                        {"2 partial none", 2, 0, Inflation::none, 3, 2},
                        {"2 partial full", 2, 0, Inflation::full, 2.947689567, 0.076303405},
                        {"2 partial map", 2, 0, Inflation::map, 2.888204333, 1.223591335}};
  for (const Case& c : cases) {
    const LinearErrorSystem system = monobot_system(c.landmarks, c.anchors, c.inflation, 100);
    std::vector<Moments> nees(100), nis(100);
    LinearSimulator(system).simulate(NoiseSource(1, 0), 0, 10000, nees, nis);
    const auto error = [](const Moments& m) {
      return std::sqrt(m.variance() / static_cast<double>(m.count));
    };
    EXPECT_NEAR(nees[99].mean, c.nees, 5.0 * error(nees[99])) << c.name;
    EXPECT_NEAR(nis[99].mean, c.nis, 5.0 * error(nis[99])) << c.name;
  }
}

TEST(LinearKernel, variance_of_an_optimal_filter_is_that_of_chi_square) {
  const LinearErrorSystem system = monobot_system(2, 0, Inflation::none, 20);
  std::vector<Moments> nees(20), nis(20);
  LinearSimulator(system).simulate(NoiseSource(2, 0), 0, 20000, nees, nis);
  for (std::size_t k = 0; k < 20; ++k) {
    // var of the sample variance of χ²(d): (μ4 − σ⁴)/n = (8 d² + 48 d)/n
    EXPECT_NEAR(nees[k].variance(), 6.0, 5.0 * std::sqrt((8 * 9 + 48 * 3) / 20000.0)) << k;
    EXPECT_NEAR(nis[k].variance(), 4.0, 5.0 * std::sqrt((8 * 4 + 48 * 2) / 20000.0)) << k;
  }
}

TEST(LinearKernel, units_do_not_change_what_is_measured) {
  // the mean of the traces, which are in the units of the system
  const LinearErrorSystem system = unstructured_system(4, 2, 5);
  const NoiseSource noise(1, 2);
  std::vector<Moments> nees(5), nis(5), trace_nees(5), trace_nis(5);
  LinearSimulator(system).simulate(noise, 0, 100, nees, nis);
  for (Index run = 0; run < 100; ++run) {
    const LinearRunTrace trace = trace_linear(system, noise, run);
    for (std::size_t k = 0; k < 5; ++k) {
      trace_nees[k].add(trace.nees[k]);
      trace_nis[k].add(trace.nis[k]);
    }
  }
  for (std::size_t k = 0; k < 5; ++k) {
    EXPECT_NEAR(nees[k].mean, trace_nees[k].mean, 1e-12 * trace_nees[k].mean);
    EXPECT_NEAR(nees[k].m2, trace_nees[k].m2, 1e-12 * trace_nees[k].m2);
    EXPECT_NEAR(nis[k].mean, trace_nis[k].mean, 1e-12 * trace_nis[k].mean);
    EXPECT_NEAR(nis[k].m2, trace_nis[k].m2, 1e-12 * trace_nis[k].m2);
  }
}

TEST(LinearKernel, chunks_are_merged_into_what_is_there) {
  const LinearSimulator simulator(monobot_system(1, 0, Inflation::none, 4));
  const NoiseSource noise(1, 2);
  std::vector<Moments> nees(4), nis(4), first_nees(4), first_nis(4), second_nees(4), second_nis(4);
  simulator.simulate(noise, 0, 50, nees, nis);
  simulator.simulate(noise, 50, 30, nees, nis);
  simulator.simulate(noise, 0, 50, first_nees, first_nis);
  simulator.simulate(noise, 50, 30, second_nees, second_nis);
  for (std::size_t k = 0; k < 4; ++k) {
    first_nees[k].merge(second_nees[k]);
    first_nis[k].merge(second_nis[k]);
  }
  EXPECT_EQ(nees, first_nees);
  EXPECT_EQ(nis, first_nis);
  simulator.simulate(noise, 80, 0, nees, nis);
  EXPECT_EQ(nees, first_nees);
}

TEST(LinearKernel, an_error_that_overflows_stays_visible) {
  LinearErrorSystem system = monobot_system(1, 0, Inflation::none, 3);
  system.F *= 1e200;
  std::vector<Moments> nees(3), nis(3);
  LinearSimulator(system).simulate(NoiseSource(1, 0), 0, 10, nees, nis);
  EXPECT_FALSE(std::isfinite(nees[2].mean));
  EXPECT_EQ(nees[2].count, 10);
}

TEST(LinearKernel, refuses_what_does_not_fit) {
  const LinearErrorSystem good = monobot_system(2, 0, Inflation::none, 3);
  const NoiseSource noise(1, 0);
  std::vector<Moments> three(3), two(2);
  const auto refused = [&](auto change) {
    LinearErrorSystem system = good;
    change(system);
    EXPECT_THROW(LinearSimulator(system).simulate(noise, 0, 1, three, three), std::invalid_argument);
    EXPECT_THROW(trace_linear(system, noise, 0), std::invalid_argument);
  };
  refused([](LinearErrorSystem& s) { s.F.conservativeResize(3, 2); });
  refused([](LinearErrorSystem& s) { s.noise_input.conservativeResize(2, 1); });
  refused([](LinearErrorSystem& s) { s.H.conservativeResize(2, 4); });
  refused([](LinearErrorSystem& s) { s.measurement_root.conservativeResize(3, 3); });
  refused([](LinearErrorSystem& s) { s.initial_root.conservativeResize(3, 4); });
  refused([](LinearErrorSystem& s) { s.steps[1].K.conservativeResize(3, 3); });
  refused([](LinearErrorSystem& s) { s.steps[2].innovation_whitening.conservativeResize(2, 1); });
  refused([](LinearErrorSystem& s) { s.steps[0].error_whitening.conservativeResize(3, 2); });
  refused([](LinearErrorSystem& s) { s.steps[1].K(0, 0) = std::numeric_limits<double>::quiet_NaN(); });
  refused([](LinearErrorSystem& s) { s.H(0, 0) = std::numeric_limits<double>::infinity(); });
  EXPECT_THROW(LinearSimulator(good).simulate(noise, -1, 1, three, three), std::invalid_argument);
  EXPECT_THROW(LinearSimulator(good).simulate(noise, 0, -1, three, three), std::invalid_argument);
  EXPECT_THROW(LinearSimulator(good).simulate(noise, 0, 1, two, three), std::invalid_argument);
  EXPECT_THROW(LinearSimulator(good).simulate(noise, 0, 1, three, two), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
