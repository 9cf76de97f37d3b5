#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <tuple>

#include "montecarlo/lanes/linear_kernel.h"
#include "tests/montecarlo/lanes/linear_systems.h"

namespace credence::internal {
namespace {

// The equations of the header with vectors for the world and the estimate, in ordinary arithmetic.
TEST(LinearKernelTrace, is_the_error_of_a_filter_in_a_world) {
  const LinearErrorSystem system = unstructured_system(5, 3, 12);
  const NoiseSource noise(5, 5);
  const LinearRunTrace trace = trace_linear(system, noise, 21);
  const auto normals = [&](Index step, NoisePurpose purpose, Index count) {
    Vector x(count);
    for (Index i = 0; i < count; ++i) x[i] = noise.normal(21, step, purpose, i);
    return x;
  };
  Vector x = Vector::LinSpaced(5, -1.0, 2.0);
  Vector estimate = x - system.initial_root * normals(0, NoisePurpose::initial, 5);
  EXPECT_LT((trace.initial_error - (x - estimate)).norm(), 1e-14);
  for (std::size_t k = 0; k < system.steps.size(); ++k) {
    const Index step = static_cast<Index>(k) + 1;
    const Vector process = system.noise_input * normals(step, NoisePurpose::process, 2);
    const Vector measurement = system.measurement_root * normals(step, NoisePurpose::measurement, 3);
    x = system.F * x + process;
    const Vector z = system.H * x + measurement;
    estimate = system.F * estimate;
    const Vector nu = z - system.H * estimate;
    estimate += system.steps[k].K * nu;
    EXPECT_LT((trace.process_noise[k] - process).norm(), 1e-14);
    EXPECT_LT((trace.measurement_noise[k] - measurement).norm(), 1e-14);
    EXPECT_LT((trace.innovations[k] - nu).norm(), 1e-12);
    EXPECT_LT((trace.errors[k] - (x - estimate)).norm(), 1e-12);
    EXPECT_NEAR(trace.nis[k], (system.steps[k].innovation_whitening * nu).squaredNorm(), 1e-12);
    EXPECT_NEAR(trace.nees[k], (system.steps[k].error_whitening * (x - estimate)).squaredNorm(), 1e-12);
  }
}

// Noise of a few times 1e-155 beside one of 0.3, or beside one of 1e155: their squares are in no double's
// range.
TEST(LinearKernelTrace, noises_may_be_as_far_apart_as_doubles_are) {
  for (const auto& [Q, R, P0] : {std::tuple(1e-310, 0.1, 1.0), std::tuple(1e-200, 1e200, 1.0),
                                 std::tuple(1e-310, 0.1, 1e-310), std::tuple(0.1, 1e-310, 0.1)}) {
    const LinearModel model = monobot_model(1, 0, Q, R, P0);
    const LinearErrorSystem system = linear_error_system(model, model, Inflation::none, 3);
    const LinearRunTrace trace = trace_linear(system, NoiseSource(1, 1), 0);
    for (std::size_t k = 0; k < 3; ++k) {
      const double nees = (system.steps[k].error_whitening * trace.errors[k]).squaredNorm();
      const double nis = (system.steps[k].innovation_whitening * trace.innovations[k]).squaredNorm();
      ASSERT_TRUE(std::isfinite(nees) && std::isfinite(nis)) << Q << " " << R << " " << P0;
      EXPECT_NEAR(trace.nees[k], nees, 1e-9 * nees) << Q << " " << R << " " << P0 << " step " << k;
      EXPECT_NEAR(trace.nis[k], nis, 1e-9 * nis) << Q << " " << R << " " << P0 << " step " << k;
    }
  }
}

// e of the steps 2, 4, … moves by the second matrices; each by hand from what came before.
TEST(LinearKernelTrace, a_period_has_the_matrices_of_each_step_in_turn) {
  LinearErrorSystem system = unstructured_system(3, 2, 6);
  const LinearErrorSystem other = unstructured_system(3, 2, 6);
  system.later = {other, other};
  system.later[0].F *= -2.0;
  system.later[1].H *= 3.0;
  system.later[1].measurement_root.setIdentity();
  const LinearRunTrace trace = trace_linear(system, NoiseSource(3, 3), 4);
  Vector e = trace.initial_error;
  for (std::size_t k = 0; k < 6; ++k) {
    const LinearErrorDynamics& now = k % 3 == 0 ? system : system.later[k % 3 - 1];
    const Vector prior = now.F * e + trace.process_noise[k];
    const Vector nu = now.H * prior + trace.measurement_noise[k];
    e = prior - system.steps[k].K * nu;
    EXPECT_LT((trace.innovations[k] - nu).norm(), 1e-13) << k;
    EXPECT_LT((trace.errors[k] - e).norm(), 1e-13) << k;
  }
}

TEST(LinearKernelTrace, does_not_depend_on_the_instruction_set_nor_on_later_steps) {
  LinearErrorSystem system = monobot_system(2, 1, Inflation::map, 9);
  const LinearRunTrace scalar = trace_linear(system, NoiseSource(4, 1, InstructionSet::scalar), 5);
  const LinearRunTrace best = trace_linear(system, NoiseSource(4, 1), 5);
  system.steps.resize(4);
  const LinearRunTrace shorter = trace_linear(system, NoiseSource(4, 1), 5);
  ASSERT_EQ(shorter.errors.size(), 4U);
  for (std::size_t k = 0; k < 9; ++k) {
    EXPECT_EQ(best.errors[k], scalar.errors[k]) << k;
    EXPECT_EQ(best.nees[k], scalar.nees[k]) << k;
    EXPECT_EQ(best.nis[k], scalar.nis[k]) << k;
    if (k < 4) EXPECT_EQ(shorter.errors[k], best.errors[k]) << k;
  }
  EXPECT_NE(trace_linear(system, NoiseSource(4, 1), 6).errors[0], shorter.errors[0]) << "another run";
}

TEST(LinearKernelTrace, of_no_step_is_the_initial_error) {
  LinearErrorSystem system = monobot_system(1, 0, Inflation::none, 1);
  system.steps.clear();
  const LinearRunTrace trace = trace_linear(system, NoiseSource(1, 0), 0);
  EXPECT_EQ(trace.initial_error.size(), 2);
  EXPECT_TRUE(trace.errors.empty() && trace.nees.empty() && trace.process_noise.empty());
}

TEST(LinearKernelTrace, refuses_a_negative_run_and_what_is_no_system) {
  LinearErrorSystem system = monobot_system(1, 0, Inflation::none, 2);
  EXPECT_THROW(trace_linear(system, NoiseSource(1, 0), -1), std::invalid_argument);
  system.steps[1].K.conservativeResize(2, 2);
  EXPECT_THROW(trace_linear(system, NoiseSource(1, 0), 0), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
