#include "montecarlo/worlds/estimator_offers.h"

#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <map>
#include <string>
#include <vector>

#include "core/filters/estimators/estimators.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/worlds/registry.h"

namespace credence::internal {
namespace {

Scenario contest_scenario(const std::vector<std::string>& more = {}) {
  std::vector<std::string> overrides = {"study.steps=20", "world.landmarks=6", "world.sensor_range=100"};
  overrides.insert(overrides.end(), more.begin(), more.end());
  return load_scenario_text("[world]\nmodel = \"planar_slam\"\n", "t.toml", overrides);
}

/// Steps of every estimator, and where it failed; stops an estimator after some steps.
class HeardContest final : public EstimatorListener {
 public:
  bool take(std::size_t e, Index k, const EstimatorStep& step) override {
    steps[e].push_back(step);
    EXPECT_EQ(k, std::ssize(steps[e]));
    return stop_after.find(e) == stop_after.end() || k < stop_after[e];
  }
  void failed(std::size_t e, Index k, Outcome outcome) override { failures[e] = {0, k, outcome}; }

  std::map<std::size_t, std::vector<EstimatorStep>> steps;
  std::map<std::size_t, RunFailure> failures;
  std::map<std::size_t, Index> stop_after;
};

// Whether the chart is the plane or a group's: P and the error of a step of the experiment, taken apart here.
TEST(PlanarSlamContest, TheStepsAreThoseOfTheExperiments) {
  const auto contest = kPlanarSlamOffer.contest(contest_scenario());
  EXPECT_EQ(contest->steps(), 20);
  EXPECT_EQ(contest->unknowns(), 15);
  const std::vector<std::string> names = {"ekf", "invariant"};
  const auto player = contest->player(names);
  for (const std::int64_t run : {3, 0}) {
    HeardContest heard;
    player->play(run, heard);
    for (std::size_t e = 0; e < names.size(); ++e) {
      const auto experiment = make_experiment(contest_scenario({"filter.estimator=" + names[e]}));
      ASSERT_EQ(heard.steps[e].size(), 20U);
      experiment->visit(run, [&](const TraceStep& shown) {
        if (shown.step == 0) return;
        EstimatorStep& step = heard.steps[e][static_cast<std::size_t>(shown.step) - 1];
        const auto nees = [&](const std::vector<Index>& at) {
          const Vector error = shown.error(at);
          return error.dot(Matrix(shown.P(at, at)).llt().solve(error));
        };
        const auto expect = [&](EstimatorBlock block, const std::vector<Index>& at) {
          EXPECT_EQ(step[block].dof, std::ssize(at));
          EXPECT_NEAR(step[block].value, nees(at), 1e-8 * (1.0 + nees(at))) << names[e] << ' ' << shown.step;
        };
        expect(EstimatorBlock::pose, {0, 1, 2});
        expect(EstimatorBlock::heading, {2});
        expect(EstimatorBlock::chart_position, {0, 1});
        std::vector<Index> map;
        for (Index i = 3; i < shown.error.size(); ++i) map.push_back(i);
        if (shown.step % contest->map_stride() == 0) {
          expect(EstimatorBlock::map, map);
        } else {
          EXPECT_EQ(step[EstimatorBlock::map].dof, 0) << "not judged at this step";
        }
        const Vector off = shown.estimate - shown.truth;
        EXPECT_NEAR(step.position_squared, off.head<2>().squaredNorm(), 1e-12);
        EXPECT_NEAR(step.heading_squared, off[2] * off[2], 1e-12);
        if (names[e] != "ekf") return;
        EXPECT_EQ(step[EstimatorBlock::position].value, step[EstimatorBlock::chart_position].value);
        EXPECT_EQ(step[EstimatorBlock::plane_pose].value, step[EstimatorBlock::pose].value);
        EXPECT_EQ(step.position_variance, shown.P(0, 0) + shown.P(1, 1));
        EXPECT_EQ(step.heading_variance, shown.P(2, 2));
      });
    }
  }
}

TEST(PlanarSlamContest, OneThatIsStoppedOrFailsIsNotHeardOfAgainAndTheOthersAre) {
  const std::vector<std::string> names = {"ekf", "ekf", "ideal"};
  HeardContest all, stopped;
  stopped.stop_after[1] = 4;
  const auto contest = kPlanarSlamOffer.contest(contest_scenario());
  contest->player(names)->play(2, all);
  contest->player(names)->play(2, stopped);
  EXPECT_EQ(stopped.steps[1].size(), 4U);
  EXPECT_EQ(stopped.steps[0].size(), 20U);
  EXPECT_EQ(stopped.steps[2].size(), 20U);
  EXPECT_EQ(stopped.steps[2].back().position_squared, all.steps[2].back().position_squared);
  // A start farther off than the world is wide.
  const auto lost = kPlanarSlamOffer.contest(contest_scenario({"initial.position_std=1e6"}));
  HeardContest failing;
  lost->player(names)->play(0, failing);
  ASSERT_EQ(failing.failures.size(), 3U);
  for (std::size_t e = 0; e < 3; ++e) {
    EXPECT_EQ(failing.failures[e].step, 1);
    EXPECT_EQ(failing.failures[e].outcome, Outcome::diverged);
    EXPECT_TRUE(failing.steps[e].empty());
  }
}

/// The dimension of what the rows of an estimator do not tell, by singular values against the largest.
Index unobservable_of(const EstimatorContest& contest, std::string_view name) {
  std::vector<Vector> rows;
  const EstimatorProfile profile =
      contest.profile(name, [&](const VectorRef& row) { rows.emplace_back(row); });
  EXPECT_EQ(profile.known, contest.unknowns());
  EXPECT_GT(profile.seconds_per_step, 0.0);
  Matrix O(std::ssize(rows), contest.unknowns());
  for (Index r = 0; r < O.rows(); ++r) O.row(r) = rows[static_cast<std::size_t>(r)].transpose();
  const Vector values = Eigen::JacobiSVD<Matrix>(O).singularValues();
  return contest.unknowns() - (values.array() > 1e-9 * values[0]).count();
}

// [Huang 2010]: a shift and a turn of the plane cannot be observed, 3 directions; the EKF's Jacobians at its
// estimates take the turn for observed, those of first estimates and of the invariant filter do not.
TEST(PlanarSlamContest, TheProfileTellsWhichEstimatorsTakeTheTurnForObserved) {
  const auto contest = kPlanarSlamOffer.contest(contest_scenario());
  EXPECT_EQ(unobservable_of(*contest, "ideal"), 3);
  EXPECT_EQ(unobservable_of(*contest, "fej"), 3);
  EXPECT_EQ(unobservable_of(*contest, "invariant"), 3);
  EXPECT_EQ(unobservable_of(*contest, "ekf"), 2);
  EXPECT_EQ(contest->profile("ekf", [](const VectorRef&) {}).chart, "plane");
  EXPECT_EQ(contest->profile("invariant", [](const VectorRef&) {}).chart, "right_invariant");
}

TEST(PlanarSlamContest, OffersAllEstimatorsAndTheBoundOfTheWorld) {
  const std::vector<std::string_view> names = kPlanarSlamOffer.names(nullptr);
  ASSERT_EQ(names.size(), estimator_kinds().size());
  const Scenario scenario = contest_scenario();
  const VehicleBound bound = kPlanarSlamOffer.contest(scenario)->bound();
  const PosteriorBound whole = posterior_bound(scenario).value();
  EXPECT_EQ(bound.position_squared, whole.find("position")->mean_bound());
  EXPECT_EQ(bound.heading_squared, whole.find("heading")->mean_bound());
}

}  // namespace
}  // namespace credence::internal
