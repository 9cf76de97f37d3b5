#include "montecarlo/lanes/planar_lanes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string>

#include "core/linear_algebra/logarithm.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/scenario/world_schema.h"
#include "montecarlo/worlds/planar/planar_experiment.h"
#include "montecarlo/worlds/planar/planar_lanes_experiment.h"
#include "tests/montecarlo/engine/allocation_count.h"

namespace credence::internal {
namespace {

Scenario planar(Index landmarks, Index steps = 60) {
  Scenario s = default_scenario("planar");
  s.world.landmarks = landmarks;
  s.study.steps = steps;
  return s;
}

PlanarLanesExperiment lanes_of(const Scenario& s, InstructionSet set = best_instruction_set()) {
  const AssumedPlanarNoise assumed = AssumedPlanarNoise::of(s);
  return {make_planar_world(s),
          PlanarNoise::of(s),
          NoiseSource(s.study.seed, noise_group(s), set),
          assumed.Q,
          assumed.measurement_variance,
          s.filter.inflation == FilterInflation::map};
}

PlanarExperiment<EkfSlam<PlanarModel>> matrices_of(const Scenario& s) {
  PlanarWorld world = make_planar_world(s);
  auto make_filter = [filter = make_planar_filter(s, world)] { return filter; };
  return {std::move(world), PlanarNoise::of(s), NoiseSource(s.study.seed, noise_group(s)),
          std::move(make_filter)};
}

/// Where the states of `order` are in a state whose landmarks are `given`.
std::vector<Index> places(const std::vector<int>& order, const std::vector<int>& given) {
  std::vector<Index> result = {0, 1, 2};
  for (const int l : order) {
    const Index i = std::ranges::find(given, l) - given.begin();
    result.push_back(3 + 2 * i);
    result.push_back(4 + 2 * i);
  }
  return result;
}

void expect_same(const TraceStep& lanes, const TraceStep& matrices, double tolerance) {
  ASSERT_EQ(lanes.landmarks.size(), matrices.landmarks.size());
  const std::vector<Index> at = places(lanes.landmarks, matrices.landmarks);
  const double scale = matrices.P.cwiseAbs().maxCoeff();
  EXPECT_LT((lanes.estimate - matrices.estimate(at)).cwiseAbs().maxCoeff(), tolerance);
  EXPECT_EQ(lanes.truth, matrices.truth(at));
  EXPECT_LT((lanes.P - matrices.P(at, at)).cwiseAbs().maxCoeff(), tolerance * scale);
  EXPECT_EQ(lanes.nees_dof, matrices.nees_dof);
  EXPECT_EQ(lanes.nis_dof, matrices.nis_dof);
  EXPECT_NEAR(lanes.nees, matrices.nees, 1e3 * tolerance * (1.0 + matrices.nees));
  EXPECT_NEAR(lanes.nis, matrices.nis, 1e3 * tolerance * (1.0 + matrices.nis));
  ASSERT_EQ(lanes.innovation().size(), matrices.innovation().size());
  if (lanes.innovation().size() == 0) return;
  EXPECT_LT((lanes.innovation() - matrices.innovation()).cwiseAbs().maxCoeff(), tolerance);
  EXPECT_LT((lanes.S() - matrices.S()).cwiseAbs().maxCoeff(), tolerance * matrices.S().cwiseAbs().maxCoeff());
  // A landmark new in this step has no row in the gain of a matrix filter; they come last there.
  const Index n = matrices.K.rows();
  for (Index i = 0; i < lanes.K.rows(); ++i) {
    const Index j = at[static_cast<std::size_t>(i)];
    const Vector row = j < n ? Vector(matrices.K.row(j)) : Vector::Zero(lanes.K.cols());
    EXPECT_LT((lanes.K.row(i).transpose() - row).cwiseAbs().maxCoeff(), tolerance) << i;
  }
}

struct World {
  std::string name;
  Scenario scenario;
};

std::vector<World> worlds() {
  Scenario range = planar(7, 300);
  range.world.sensor_range = 9.0;
  Scenario view = planar(6, 120);
  view.world.field_of_view_deg = 120.0;
  view.world.vehicle = VehicleKind::bicycle;
  Scenario anchored = planar(5, 120);
  anchored.world.observability = Observability::full;
  anchored.world.anchors = 2;
  anchored.world.vehicle = VehicleKind::car;
  anchored.world.sensor_range = 15.0;
  Scenario mistuned = planar(2, 60);
  mistuned.filter.process_scale = 2.0;
  mistuned.filter.measurement_scale = 0.5;
  Scenario missed = planar(5, 120);
  missed.noise.detection_probability = 0.4;
  Scenario inflated = planar(7, 120);
  inflated.world.sensor_range = 9.0;
  inflated.filter.inflation = FilterInflation::map;
  return {{"missed", missed},    {"all_in_view", planar(10)}, {"short_range", range},
          {"half_a_view", view}, {"anchored", anchored},      {"mistuned", mistuned},
          {"one", planar(1)},    {"inflated", inflated}};
}

TEST(PlanarLanes, are_the_matrix_filter_to_rounding) {
  for (const World& world : worlds()) {
    SCOPED_TRACE(world.name);
    const RunTrace lanes = lanes_of(world.scenario).trace(3), matrices = matrices_of(world.scenario).trace(3);
    ASSERT_EQ(lanes.outcome, Outcome::ok);
    ASSERT_EQ(lanes.steps.size(), matrices.steps.size());
    for (std::size_t k = 0; k < lanes.steps.size() && !testing::Test::HasFailure(); ++k) {
      SCOPED_TRACE(k);
      expect_same(lanes.steps[k], matrices.steps[k], 1e-10);
    }
  }
}

TEST(PlanarLanes, statistics_are_those_of_the_matrix_filter) {
  for (const World& world : worlds()) {
    SCOPED_TRACE(world.name);
    // Eleven runs: a batch and a part of one.
    const StudyStatistics lanes = lanes_of(world.scenario).run_chunk(5, 11);
    const StudyStatistics matrices = matrices_of(world.scenario).run_chunk(5, 11);
    for (std::size_t k = 0; k < lanes.steps.size(); ++k) {
      const StepStatistics &a = lanes.steps[k], &b = matrices.steps[k];
      EXPECT_EQ(a.nees_dof, b.nees_dof);
      EXPECT_EQ(a.nis_dof, b.nis_dof);
      for (std::size_t q = 0; q < a.quantities.size(); ++q) {
        ASSERT_EQ(a.quantities[q].count, b.quantities[q].count) << k << ' ' << q;
        ASSERT_NEAR(a.quantities[q].mean, b.quantities[q].mean, 1e-7 * (1e-3 + b.quantities[q].mean))
            << k << ' ' << q;
      }
    }
  }
}

TEST(PlanarLanes, instruction_sets_give_the_same_bits) {
  if (best_instruction_set() == InstructionSet::scalar) GTEST_SKIP() << "one instruction set cannot differ";
  for (const World& world : worlds()) {
    SCOPED_TRACE(world.name);
    Scenario scenario = world.scenario;
    scenario.study.steps = 30;
    const StudyStatistics scalar = lanes_of(scenario, InstructionSet::scalar).run_chunk(0, 10);
    for (const InstructionSet set : {InstructionSet::avx2, InstructionSet::avx512}) {
      if (is_supported(set)) {
        EXPECT_TRUE(lanes_of(scenario, set).run_chunk(0, 10) == scalar);
      }
    }
  }
}

TEST(PlanarLanes, a_run_does_not_depend_on_its_neighbours) {
  // What is in view differs from run to run here, so that lanes idle for others.
  const Scenario scenario = worlds()[1].scenario;
  const PlanarLanesExperiment experiment = lanes_of(scenario);
  const StudyStatistics together = experiment.run_chunk(9, 5);
  std::vector<Moments> nees(together.steps.size());
  for (std::int64_t run = 9; run < 14; ++run) {
    const RunTrace alone = experiment.trace(run);
    for (std::size_t k = 1; k < alone.steps.size(); ++k) nees[k - 1].add(alone.steps[k].nees);
  }
  for (std::size_t k = 0; k < nees.size(); ++k) ASSERT_EQ(together.steps[k][Quantity::nees], nees[k]) << k;
}

/// Notes the steps that come normalised.
class Noting final : public ChunkObserver {
 public:
  void begin_runs(std::int64_t) override {}
  void add(const Step&, std::size_t) override { ++plain; }
  void add(const NormalisedStep& step, std::size_t i) override { steps[i].push_back(step); }
  void end_run(Outcome outcome, std::int64_t step, std::size_t i) override { ends[i] = {0, step, outcome}; }

  std::array<std::vector<NormalisedStep>, PlanarLanes::kLanes> steps;
  std::array<RunFailure, PlanarLanes::kLanes> ends;
  int plain = 0;
};

/// The NEES of some states from their own block of P.
NeesValue from_block(const TraceStep& step, const std::vector<Index>& at) {
  NeesSolver solver;
  return solver.solve(step.error(at), step.P(at, at));
}

std::vector<Index> range(Index first, Index end) {
  std::vector<Index> all;
  for (Index i = first; i < end; ++i) all.push_back(i);
  return all;
}

/// What `normalised` must be of this step, each block from its own covariance.
void expect_normalised(const NormalisedStep& normalised, const TraceStep& step, const RangeBearing& variance,
                       bool checked) {
  constexpr double kTolerance = 1e-8;
  const Index n = step.error.size();
  const auto near = [](double a, double b) { EXPECT_NEAR(a, b, kTolerance * (1.0 + std::abs(b))); };
  const auto expect_block = [&](const NormalisedSquare& block, const std::vector<Index>& at) {
    const NeesValue expected = from_block(step, at);
    EXPECT_EQ(block.dof, expected.dof);
    near(block.value, expected.value);
  };
  EXPECT_EQ(normalised.states, step.states);
  EXPECT_LT((normalised.error - step.error).cwiseAbs().maxCoeff(), kTolerance);
  EXPECT_LT((normalised.variance - step.P.diagonal()).cwiseAbs().maxCoeff(), kTolerance);
  expect_block(normalised.whole, range(0, n));
  EXPECT_TRUE(normalised.P.rows() == n || !checked || n > kLargestTold);
  if (normalised.P.rows() == n) {
    const Matrix off = normalised.P - step.P;
    EXPECT_LT(Matrix(off.triangularView<Eigen::Lower>()).cwiseAbs().maxCoeff(), kTolerance);
  }
  const Eigen::LLT<Matrix> llt(step.P);
  near(normalised.log_determinant, log_determinant_of_factor(llt.matrixLLT()));
  expect_block(normalised.blocks[0], range(0, 3));
  expect_block(normalised.blocks[1], range(0, 2));
  expect_block(normalised.blocks[2], range(2, 3));
  for (std::size_t i = 0; i < step.landmarks.size(); ++i) {
    const auto at = static_cast<Index>(3 + 2 * i);
    expect_block(normalised.blocks[static_cast<std::size_t>(3 + step.landmarks[i])], range(at, at + 2));
  }
  EXPECT_EQ(std::ranges::count(normalised.blocks, -1, &NormalisedSquare::dof),
            std::ssize(normalised.blocks) - 3 - std::ssize(step.landmarks) - (n > 3 ? 1 : 0));
  if (n > 3) expect_block(normalised.blocks.back(), range(3, n));
  EXPECT_EQ(normalised.lead.P, step.P.topLeftCorner(3, 3));
  EXPECT_EQ(normalised.position.P, step.P.topLeftCorner(2, 2));

  const NormalisedInnovation& innovation = normalised.innovations.front();
  const Index m = step.innovation().size();
  EXPECT_EQ(innovation.dof, m > 0 ? m : -1);
  if (m == 0) return;
  NeesSolver solver;
  near(innovation.value, solver.solve(step.innovation(), step.S()).value);
  EXPECT_LT((innovation.whitened - solver.whitened()).cwiseAbs().maxCoeff(), kTolerance);
  EXPECT_EQ(innovation.nu, step.innovation());
  ASSERT_EQ(innovation.covariance.size(), m / 2);
  for (Index i = 0; i < m; i += 2) near(innovation.covariance[i / 2], step.S()(i + 1, i));
  near(innovation.noise_share, solver.noise_share({variance[0], variance[1]}));
}

TEST(PlanarLanes, shows_steps_normalised_as_by_the_covariance_of_each_block) {
  for (const World& world : worlds()) {
    SCOPED_TRACE(world.name);
    Scenario scenario = world.scenario;
    scenario.study.steps = 40;
    const RangeBearing variance = AssumedPlanarNoise::of(scenario).measurement_variance;
    PlanarLanesExperiment lanes = lanes_of(scenario);
    auto matrices = matrices_of(scenario);
    for (Experiment* experiment : std::initializer_list<Experiment*>{&lanes, &matrices}) {
      experiment->assume_measurement_variances({variance[0], variance[1]});
      Noting noted;
      const StudyStatistics statistics = experiment->show_chunk(3, 1, noted).value();
      EXPECT_EQ(statistics, experiment->run_chunk(3, 1));
      const RunTrace trace = experiment->trace(3);
      EXPECT_EQ(noted.plain, 0);
      EXPECT_EQ(noted.ends[0], (RunFailure{0, 40, Outcome::ok}));
      ASSERT_EQ(noted.steps[0].size(), trace.steps.size() - 1);
      for (std::size_t k = 1; k < trace.steps.size() && !testing::Test::HasFailure(); ++k) {
        SCOPED_TRACE(k);
        const Index n = 3 + 2 * scenario.world.landmarks;
        expect_normalised(noted.steps[0][k - 1], trace.steps[k], variance,
                          is_checked(n, static_cast<std::int64_t>(k), 40));
      }
    }
  }
}

TEST(PlanarLanes, shows_a_step_plain_whose_covariance_is_singular) {
  Scenario scenario = planar(2, 10);
  scenario.initial.heading_std_deg = 0.0;
  scenario.noise.steering_std_deg = scenario.noise.turn_rate_std = 0.0;
  Noting noted;
  lanes_of(scenario).show_chunk(0, 1, noted);
  EXPECT_GT(noted.plain, 0);
}

TEST(PlanarLanes, instruction_sets_show_the_same_bits) {
  if (best_instruction_set() == InstructionSet::scalar) GTEST_SKIP() << "one instruction set cannot differ";
  for (const World& world : worlds()) {
    SCOPED_TRACE(world.name);
    Scenario scenario = world.scenario;
    scenario.study.steps = 20;
    Noting scalar;
    lanes_of(scenario, InstructionSet::scalar).show_chunk(0, 8, scalar);
    for (const InstructionSet set : {InstructionSet::avx2, InstructionSet::avx512}) {
      if (!is_supported(set)) continue;
      Noting noted;
      lanes_of(scenario, set).show_chunk(0, 8, noted);
      for (std::size_t i = 0; i < noted.steps.size(); ++i) {
        ASSERT_EQ(noted.steps[i].size(), scalar.steps[i].size());
        for (std::size_t k = 0; k < noted.steps[i].size(); ++k) {
          const NormalisedStep &a = noted.steps[i][k], &b = scalar.steps[i][k];
          ASSERT_EQ(a.whole.value, b.whole.value);
          ASSERT_EQ(Matrix(a.P.triangularView<Eigen::Lower>()), Matrix(b.P.triangularView<Eigen::Lower>()));
          ASSERT_EQ(a.log_determinant, b.log_determinant);
          for (std::size_t j = 0; j < a.blocks.size(); ++j) ASSERT_EQ(a.blocks[j].value, b.blocks[j].value);
          if (a.innovations[0].dof <= 0) continue;
          ASSERT_EQ(a.innovations[0].noise_share, b.innovations[0].noise_share);
        }
      }
    }
  }
}

TEST(PlanarLanes, an_innovation_covariance_that_is_not_positive_definite_changes_nothing) {
  const Scenario scenario = planar(2, 5);
  const PlanarWorld world = make_planar_world(scenario);
  // A negative variance is no noise, but what a lost covariance looks like.
  PlanarLanes lanes(world, Eigen::Matrix2d::Identity(), RangeBearing(-1.0, 0.01));
  const std::vector<Observation<PlanarModel>> z = {{0, {5.0, 0.1}}, {1, {6.0, 0.2}}};
  std::array<PlanarLanes::Observations, PlanarLanes::kLanes> seen;
  seen[2] = z;
  for (int lane = 0; lane < PlanarLanes::kLanes; ++lane) {
    lanes.reset(lane, world.start, 0.01 * Eigen::Matrix3d::Identity());
  }
  lanes.update(seen);
  const Vector x = lanes.state(2);
  const Matrix P = lanes.covariance(2);
  lanes.update(seen);
  lanes.judge({});
  EXPECT_EQ(lanes.step(2).outcome, Outcome::not_positive_definite);
  EXPECT_EQ(lanes.state(2), x);
  EXPECT_EQ(lanes.covariance(2), P);
  EXPECT_EQ(lanes.step(1).outcome, Outcome::ok);
  EXPECT_EQ(lanes.step(1).update.dof, 0);
}

TEST(PlanarLanes, a_batch_allocates_nothing) {
  const PlanarLanesExperiment experiment = lanes_of(worlds()[1].scenario);
  const auto allocations = [&](std::int64_t runs) {
    const std::int64_t before = allocations_of_this_thread();
    EXPECT_EQ(experiment.run_chunk(0, runs).runs, runs);
    return allocations_of_this_thread() - before;
  };
  EXPECT_EQ(allocations(24), allocations(8));
}

}  // namespace
}  // namespace credence::internal
