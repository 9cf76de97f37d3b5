#include "montecarlo/worlds/plugged/batch_experiment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "montecarlo/engine/engine.h"
#include "montecarlo/worlds/plugged/model_plug.h"

namespace credence::internal {
namespace {

using testing::Each;
using testing::ElementsAre;
using testing::IsEmpty;

/// A pendulum with friction, now and then not measured.
FunctionModel swing() {
  FunctionModel model;
  model.f = [](const Vector& x) {
    return Vector(Eigen::Vector2d(x[0] + 0.1 * x[1], 0.95 * x[1] - 0.5 * std::sin(x[0])));
  };
  model.h = [](const Vector& x) { return Vector(x.head<1>()); };
  model.Q = Eigen::Vector2d(0.001, 0.004).asDiagonal();
  model.R = Matrix::Constant(1, 1, 0.01);
  model.mean = Eigen::Vector2d(1.0, 0.0);
  model.P0 = Eigen::Vector2d(0.1, 0.05).asDiagonal();
  return model;
}

struct SometimesSeen : FunctionWorld {
  using FunctionWorld::FunctionWorld;
  std::optional<Vector> measure(const Vector& x, std::int64_t k, NoiseDraw& noise) const {
    if (k % 5 == 3 || noise.uniform() < 0.2) return std::nullopt;
    return FunctionWorld::measure(x, k, noise);
  }
};

/// Lanes that are filters of their own: what a batch must give.
class FourLanes {
 public:
  static constexpr int kLanes = 4;

  explicit FourLanes(const FunctionModel& model) : lanes_(4, FunctionEkf(model)) {}

  void reset(const Vector& mean, const Matrix& P) {
    for (FunctionEkf& lane : lanes_) lane.reset(mean, P);
    good_.assign(4, true);
  }
  void predict() {
    for (FunctionEkf& lane : lanes_) lane.predict();
  }
  void update(std::span<const std::optional<Vector>> z) {
    for (std::size_t i = 0; i < lanes_.size(); ++i) {
      if (!z[i]) continue;
      if (throws_above < std::abs((*z[i])[0])) throw std::runtime_error("too far");
      if (throws_a_number) throw 42;
      good_[i] = lanes_[i].update(*z[i]) && std::abs((*z[i])[0]) < fails_above;
    }
  }
  const Vector& state(int lane) const { return at(lane).state(); }
  const Matrix& covariance(int lane) const { return at(lane).covariance(); }
  const Vector& innovation(int lane) const { return at(lane).innovation(); }
  const Matrix& innovation_covariance(int lane) const { return at(lane).innovation_covariance(); }
  bool good(int lane) const { return good_[static_cast<std::size_t>(lane)]; }

  double fails_above = 1e9, throws_above = 1e9;
  bool throws_a_number = false;

 private:
  const FunctionEkf& at(int lane) const { return lanes_[static_cast<std::size_t>(lane)]; }

  std::vector<FunctionEkf> lanes_;
  std::vector<bool> good_;
};

TEST(BatchExperiment, HasTheBitsOfTheFilterInItsRuns) {
  const FunctionModel model = swing();
  for (const Index delay : {0, 2}) {
    const PlugSettings settings{
        .steps = 20, .seed = 3, .measurement_shape = {.outlier_rate = 0.1}, .measurement_delay = delay};
    const PluggedExperiment alone(
        SometimesSeen(model), [&] { return FunctionEkf(model); }, settings);
    const BatchExperiment batch(
        SometimesSeen(model), [&] { return FourLanes(model); }, settings);
    // 10 runs are no whole number of batches.
    EXPECT_EQ(batch.run_chunk(5, 10), alone.run_chunk(5, 10));
    const RunTrace a = alone.trace(7), b = batch.trace(7);
    ASSERT_EQ(a.steps.size(), b.steps.size());
    for (std::size_t k = 0; k < a.steps.size(); ++k) {
      EXPECT_EQ(a.steps[k].error, b.steps[k].error);
      EXPECT_EQ(a.steps[k].P, b.steps[k].P);
      EXPECT_EQ(a.steps[k].innovation(), b.steps[k].innovation());
      EXPECT_EQ(a.steps[k].z, b.steps[k].z);
    }
    EXPECT_THAT(batch.problems(), IsEmpty());
  }
}

TEST(BatchExperiment, ALaneThatCannotGoOnEndsItsRunAlone) {
  const FunctionModel model = swing();
  const BatchExperiment batch(SometimesSeen(model),
                              [&] {
                                FourLanes lanes(model);
                                lanes.fails_above = 1.3;
                                return lanes;
                              },
                              {.steps = 20});
  const StudyStatistics s = batch.run_chunk(0, 64);
  EXPECT_GT(s.failures.size(), 0U);
  EXPECT_LT(s.failures.size(), 64U);
  for (const RunFailure& failure : s.failures) {
    EXPECT_EQ(failure.outcome, Outcome::not_positive_definite);
    const RunTrace alone = batch.trace(failure.run);
    EXPECT_EQ(alone.steps.back().step, failure.step);
  }
}

TEST(BatchExperiment, AnExceptionEndsTheRunsOfItsBatch) {
  const FunctionModel model = swing();
  const BatchExperiment batch(SometimesSeen(model),
                              [&] {
                                FourLanes lanes(model);
                                lanes.throws_above = 0.0;
                                return lanes;
                              },
                              {.steps = 20});
  const std::vector<Outcome> outcomes = batch.visit_runs(0, 6, [](std::int64_t, const TraceStep&) {});
  EXPECT_EQ(outcomes.size(), 6U);
  EXPECT_THAT(outcomes, Each(Outcome::threw));
}

/// Without innovations.
class BlindLanes : FourLanes {
 public:
  using FourLanes::covariance;
  using FourLanes::FourLanes;
  using FourLanes::good;
  using FourLanes::kLanes;
  using FourLanes::predict;
  using FourLanes::reset;
  using FourLanes::state;
  using FourLanes::update;
};

TEST(BatchExperiment, OfAFilterWithoutInnovationsNoSensorIsHeard) {
  const FunctionModel model = swing();
  const BatchExperiment blind(SometimesSeen(model), [&] { return BlindLanes(model); }, {.steps = 20});
  EXPECT_THAT(blind.layout().sensors, IsEmpty());
  EXPECT_THAT(blind.problems(), IsEmpty());
  const StudyStatistics s = blind.run_chunk(0, 8);
  EXPECT_THAT(s.dofs(Quantity::nis), Each(0.0));
  EXPECT_THAT(s.dofs(Quantity::nees), Each(16.0));
}

TEST(BatchExperiment, ProblemsSayWhatThrows) {
  const FunctionModel model = swing();
  const BatchExperiment batch(FunctionWorld(model),
                              [&] {
                                FourLanes lanes(model);
                                lanes.throws_above = 0.0;
                                return lanes;
                              },
                              {.steps = 20});
  EXPECT_THAT(batch.problems(),
              ElementsAre("all of the first 4 runs fail at the first step, run 0 with: too far"));
}

TEST(BatchExperiment, WhatIsThrownNeedNotBeAnException) {
  const FunctionModel model = swing();
  const BatchExperiment batch(SometimesSeen(model),
                              [&] {
                                FourLanes lanes(model);
                                lanes.throws_a_number = true;
                                return lanes;
                              },
                              {.steps = 20});
  EXPECT_THAT(batch.visit_runs(0, 6, [](std::int64_t, const TraceStep&) {}), Each(Outcome::threw));
}

/// Its input is not known where the state is large.
struct SometimesSteered : SometimesSeen {
  using SometimesSeen::SometimesSeen;
  double input(const Vector& x, std::int64_t, NoiseDraw&) const {
    if (std::abs(x[0]) > 1.3) throw std::runtime_error("no input");
    return 0.0;
  }
};

TEST(BatchExperiment, AnExceptionOfTheWorldEndsItsRunAlone) {
  const FunctionModel model = swing();
  struct Steered : FourLanes {
    using FourLanes::FourLanes;
    void predict(std::span<const double>) { FourLanes::predict(); }
  };
  struct SteeredEkf : FunctionEkf {
    using FunctionEkf::FunctionEkf;
    void predict(double) { FunctionEkf::predict(); }
  };
  const PlugSettings settings{.steps = 20};
  const SometimesSteered world(model);
  const PluggedExperiment alone(
      world, [&] { return SteeredEkf(model); }, settings);
  const BatchExperiment batch(
      world, [&] { return Steered(model); }, settings);
  const StudyStatistics s = batch.run_chunk(0, 64);
  EXPECT_GT(s.failures.size(), 0U);
  EXPECT_LT(s.failures.size(), 64U);
  EXPECT_EQ(s, alone.run_chunk(0, 64));
}

}  // namespace
}  // namespace credence::internal
