#include "montecarlo/lanes/linear_kernel_storage.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/montecarlo/lanes/linear_systems.h"

namespace credence::internal {
namespace {

using testing::ElementsAre;

LinearSystemInUnits stored_system() {
  LinearSystemInUnits in_units;
  LinearErrorSystem& system = in_units.system;
  system.F = Matrix{{1.0, 0.5}, {0.0, 0.875}};
  system.noise_input = Matrix{{0.0}, {1.0}};
  system.H = Matrix{{0.0, 2.0}};
  system.measurement_root = Matrix{{3.0}};
  system.initial_root = Matrix{{2.0, 0.0}, {0.0, 5.0}};
  system.steps = {{Matrix{{0.25}, {0.0}}, Matrix{{1.0}}, Matrix{{0.5, 0.0}, {0.25, 1.0}}},
                  {Matrix{{0.125}, {0.75}}, Matrix{{1.0}}, Matrix{{0.0, 0.0}, {0.0, 1.0}}}};
  in_units.nis_scale = {4.0, 0.5};
  in_units.nees_scale = {0.25, 8.0};
  return in_units;
}

std::vector<double> values_of(const double* from, std::size_t count) { return {from, from + count}; }
std::vector<int> indices_at(const std::int32_t* from, std::size_t count) { return {from, from + count}; }

TEST(LinearKernelStorage, sparse_rows_have_no_zeros) {
  const LinearPlanStorage storage(stored_system());
  const LinearPlan& plan = storage.plan();
  EXPECT_EQ(plan.states, 2);
  EXPECT_EQ(plan.process_noises, 1);
  EXPECT_EQ(plan.measurements, 1);
  EXPECT_EQ(plan.steps, 2);
  EXPECT_EQ(plan.period, 1);
  const LinearPlanPhase& phase = plan.phase[0];
  EXPECT_FALSE(phase.identity);
  EXPECT_THAT(indices_at(phase.F.row_start, 3), ElementsAre(0, 2, 3));
  EXPECT_THAT(indices_at(phase.F.column, 3), ElementsAre(0, 1, 1));
  EXPECT_THAT(values_of(phase.F.value, 3), ElementsAre(1.0, 0.5, 0.875));
  EXPECT_THAT(indices_at(phase.noise_input.row_start, 3), ElementsAre(0, 0, 1));
  EXPECT_THAT(indices_at(phase.H.column, 1), ElementsAre(1));
  EXPECT_THAT(values_of(phase.measurement_root.value, 1), ElementsAre(3.0));
  EXPECT_THAT(indices_at(plan.initial_root.column, 2), ElementsAre(0, 1));
  EXPECT_THAT(values_of(plan.initial_root.value, 2), ElementsAre(2.0, 5.0));
}

TEST(LinearKernelStorage, dense_rows_begin_and_end_where_they_are_not_zero) {
  const LinearPlanStorage storage(stored_system());
  const LinearPlanStep &first = storage.plan().step[0], &second = storage.plan().step[1];
  EXPECT_EQ(first.gain.rows, 2);
  EXPECT_EQ(first.gain.columns, 1);
  EXPECT_THAT(values_of(first.gain.value, 2), ElementsAre(0.25, 0.0));
  EXPECT_THAT(indices_at(first.gain.begin, 2), ElementsAre(0, 1)) << "nothing in the second row";
  EXPECT_THAT(indices_at(first.gain.end, 2), ElementsAre(1, 1));
  EXPECT_THAT(values_of(first.error_whitening.value, 4), ElementsAre(0.5, 0.0, 0.25, 1.0));
  EXPECT_THAT(indices_at(first.error_whitening.end, 2), ElementsAre(1, 2));
  EXPECT_THAT(indices_at(second.error_whitening.begin, 2), ElementsAre(2, 1));
  EXPECT_THAT(indices_at(second.error_whitening.end, 2), ElementsAre(2, 2));
  EXPECT_THAT(values_of(second.gain.value, 2), ElementsAre(0.125, 0.75));
}

// What is taken off is the dof in the units of the sums.
TEST(LinearKernelStorage, centres_are_the_dof_over_the_scale) {
  const LinearPlanStorage storage(stored_system());
  const LinearPlanStep* step = storage.plan().step;
  EXPECT_EQ(step[0].nis_centre, 1.0 / 4.0);
  EXPECT_EQ(step[1].nis_centre, 1.0 / 0.5);
  EXPECT_EQ(step[0].nees_centre, 2.0 / 0.25);
  EXPECT_EQ(step[1].nees_centre, 2.0 / 8.0);
  EXPECT_EQ(step[1].nees_scale, 8.0);
}

/// Σ (x − centre) and Σ (x − centre)² of a quantity, each spread over its eight accumulators.
void add_sums(double* sums, double centre, const std::vector<double>& x) {
  for (std::size_t i = 0; i < x.size(); ++i) {
    sums[i % 8] += x[i] - centre;
    sums[8 + i % 8] += (x[i] - centre) * (x[i] - centre);
  }
}

// 1, 2, … 9 have mean 5 and squared deviations of 60 in all.
TEST(LinearKernelStorage, moments_are_those_of_the_values_in_their_own_units) {
  const LinearPlanStorage storage(stored_system());
  const std::vector<double> x{1, 2, 3, 4, 5, 6, 7, 8, 9};
  for (const std::size_t k : {0U, 1U}) {
    const LinearPlanStep& step = storage.plan().step[k];
    double sums[kSumsOfStep] = {};
    add_sums(sums, step.nees_centre, x);
    add_sums(sums + 2 * kAccumulators, step.nis_centre, {3.0, 3.0, 3.0});
    const Moments nees = storage.nees_moments(k, sums, 9), nis = storage.nis_moments(k, sums, 3);
    const double scale = step.nees_scale;
    EXPECT_EQ(nees.count, 9);
    EXPECT_NEAR(nees.mean, 5.0 * scale, 1e-12 * scale);
    EXPECT_NEAR(nees.m2, 60.0 * scale * scale, 1e-12 * scale * scale);
    EXPECT_EQ(nis.count, 3);
    EXPECT_NEAR(nis.mean, 3.0 * (k == 0 ? 4.0 : 0.5), 1e-12);
    EXPECT_NEAR(nis.m2, 0.0, 1e-12);
  }
}

TEST(LinearKernelStorage, rounding_leaves_no_negative_squares_and_a_nan_stays_one) {
  const LinearPlanStorage storage(stored_system());
  double sums[kSumsOfStep] = {};
  sums[0] = 3.0;
  sums[8] = 2.99;  // less than 3²/3
  EXPECT_EQ(storage.nees_moments(0, sums, 3).m2, 0.0);
  sums[8 + 5] = std::nan("");
  EXPECT_TRUE(std::isnan(storage.nees_moments(0, sums, 3).m2));
  EXPECT_EQ(storage.nis_moments(0, sums, 3).m2, 0.0);
}

bool is_small_plan(const LinearErrorSystem& system) {
  return LinearPlanStorage(linear_system_in_units(system)).plan().small_coefficients != nullptr;
}

bool is_monobot_plan(const LinearErrorSystem& system) {
  return LinearPlanStorage(linear_system_in_units(system)).plan().monobot_roots != nullptr;
}

TEST(LinearKernelStorage, what_fits_in_registers_is_small_and_the_least_monobots_have_a_kernel) {
  for (const Index landmarks : {1, 2, 3, 4}) {
    for (const Index anchors : {0, 1, 2}) {
      const LinearErrorSystem system = monobot_system(landmarks, anchors, Inflation::none, 3);
      EXPECT_EQ(is_small_plan(system), landmarks <= 3 && landmarks + anchors <= 3) << landmarks << anchors;
      EXPECT_EQ(is_monobot_plan(system), landmarks <= 2 && anchors <= 1) << landmarks << anchors;
    }
  }
  // The landmark is known: P has no full rank, and its whitening no full size.
  LinearModel known = monobot_model(1, 0, 0.1, 0.1, 1.0);
  known.P0(1, 1) = 0.0;
  EXPECT_FALSE(is_small_plan(linear_error_system(known, known, Inflation::none, 3)));
}

TEST(LinearKernelStorage, a_small_system_that_is_no_monobot_has_no_roots) {
  const LinearErrorSystem monobot = monobot_system(1, 1, Inflation::none, 3);
  const auto changed = [&](void (*change)(LinearErrorSystem&)) {
    LinearErrorSystem system = monobot;
    change(system);
    EXPECT_TRUE(is_small_plan(system));
    return is_monobot_plan(system);
  };
  EXPECT_TRUE(changed([](LinearErrorSystem& s) { s.noise_input *= 2.0; })) << "another unit";
  EXPECT_TRUE(changed([](LinearErrorSystem& s) { s.measurement_root(1, 1) *= 2.0; }));
  EXPECT_FALSE(changed([](LinearErrorSystem& s) { s.measurement_root(1, 0) = 0.1; }));
  EXPECT_FALSE(changed([](LinearErrorSystem& s) { s.F(1, 1) = 0.5; }));
  EXPECT_FALSE(changed([](LinearErrorSystem& s) { s.H(0, 0) = 1.0; }));
  EXPECT_FALSE(changed([](LinearErrorSystem& s) { s.noise_input(1, 0) = 0.1; })) << "a landmark that moves";
  EXPECT_FALSE(changed([](LinearErrorSystem& s) { s.later = {s}; })) << "of a period";
}

TEST(LinearKernelStorage, a_small_system_has_its_matrices_by_rows_and_columns) {
  LinearSystemInUnits in_units = stored_system();
  in_units.system.steps.resize(1);
  in_units.system.noise_input = Matrix{{0.5, 1.0}, {0.25, 0.0}};
  const LinearPlanStorage storage(in_units);
  const LinearPlan& plan = storage.plan();
  ASSERT_NE(plan.small_coefficients, nullptr);
  // K, then the lower triangles of both whitenings.
  EXPECT_THAT(values_of(plan.small_coefficients, 6), ElementsAre(0.25, 0.0, 1.0, 0.5, 0.25, 1.0));
  EXPECT_THAT(values_of(plan.phase[0].dense_F, 4), ElementsAre(1.0, 0.5, 0.0, 0.875));
  EXPECT_THAT(values_of(plan.phase[0].dense_H, 3), ElementsAre(0.0, 2.0, 3.0)) << "and the root of R";
  EXPECT_THAT(values_of(plan.phase[0].noise_columns, 4), ElementsAre(0.5, 0.25, 1.0, 0.0));
}

TEST(LinearKernelStorage, every_step_of_a_period_has_a_phase) {
  LinearSystemInUnits in_units = stored_system();
  in_units.system.later = {in_units.system};
  in_units.system.later[0].F.setIdentity();
  const LinearPlanStorage storage(in_units);
  ASSERT_EQ(storage.plan().period, 2);
  EXPECT_FALSE(storage.plan().phase[0].identity);
  EXPECT_TRUE(storage.plan().phase[1].identity);
  EXPECT_THAT(values_of(storage.plan().phase[1].F.value, 2), ElementsAre(1.0, 1.0));
}

TEST(LinearKernelStorage, a_small_monobot_has_the_roots_of_its_variances) {
  LinearErrorSystem system = monobot_system(2, 1, Inflation::map, 2);
  system.measurement_root.diagonal() << 0.25, 0.5, 1.5;
  system.noise_input(0, 0) = 0.5;  // the unit
  const LinearPlanStorage storage(linear_system_in_units(system));
  ASSERT_NE(storage.plan().monobot_roots, nullptr);
  EXPECT_THAT(values_of(storage.plan().monobot_roots, 3), ElementsAre(0.5, 1.0, 3.0));
}

}  // namespace
}  // namespace credence::internal
