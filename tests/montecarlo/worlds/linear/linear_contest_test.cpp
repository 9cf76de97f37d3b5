#include "montecarlo/worlds/estimator_offers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "core/linear_algebra/decompositions.h"
#include "montecarlo/scenario/scenario_io.h"
#include "montecarlo/worlds/linear/linear_estimator_experiment.h"

namespace credence::internal {
namespace {

using testing::ElementsAre;

/// A cart on a rail, pushed at random, whose place two sensors measure.
Scenario rail_scenario(const std::vector<std::string>& overrides = {}) {
  return load_scenario_text(R"([world]
model = "linear"
F = [[1, 0.1], [0, 1]]
G = [[0.005], [0.1]]
Q = [[0.4]]
H = [[1, 0], [1, 0]]
R = [[0.02, 0.005], [0.005, 0.03]]
P0 = [[0.5, 0.1], [0.1, 0.3]]
[study]
steps = 25
)",
                            "rail.toml", overrides);
}

/// Steps of every estimator, and where it failed.
class RailListener final : public EstimatorListener {
 public:
  bool take(std::size_t e, Index k, const EstimatorStep& step) override {
    heard[e].push_back(step);
    EXPECT_EQ(std::ssize(heard[e]), k) << e;
    return k < last;
  }
  void failed(std::size_t, Index, Outcome) override { ADD_FAILURE(); }

  Index last = 1000;
  std::map<std::size_t, std::vector<EstimatorStep>> heard;
};

TEST(LinearContest, OffersWhatTheScenarioSaysEnoughFor) {
  const Scenario plain = rail_scenario();
  EXPECT_THAT(kLinearOffer.names(&plain), ElementsAre("kalman", "steady-state", "smoother"));
  const Scenario considered = rail_scenario({"filter.considered=[\"x2\"]"});
  EXPECT_THAT(kLinearOffer.names(&considered), ElementsAre("kalman", "steady-state", "smoother", "schmidt"));
  const Scenario gain = rail_scenario({"filter.gain=[[0.1, 0.1], [0, 0]]"});
  EXPECT_THAT(kLinearOffer.names(&gain), ElementsAre("kalman", "steady-state", "smoother", "own-gain"));
  EXPECT_THAT(kLinearOffer.names(nullptr),
              ElementsAre("kalman", "steady-state", "smoother", "schmidt", "own-gain"));
}

// Information form, P⁺ = ((F P Fᵀ + G Q Gᵀ)⁻¹ + Hᵀ R⁻¹ H)⁻¹, whatever the filter believes.
TEST(LinearContest, TheBoundIsTheCovarianceOfTheFilterThatKnowsTheNoise) {
  const Matrix F = (Matrix(2, 2) << 1.0, 0.1, 0.0, 1.0).finished();
  const Matrix G = (Matrix(2, 1) << 0.005, 0.1).finished();
  const Matrix H = (Matrix(2, 2) << 1.0, 0.0, 1.0, 0.0).finished();
  const Matrix R = (Matrix(2, 2) << 0.02, 0.005, 0.005, 0.03).finished();
  Matrix P = (Matrix(2, 2) << 0.5, 0.1, 0.1, 0.3).finished();
  double mean = 0.0;
  for (int k = 0; k < 25; ++k) {
    const Matrix prior = F * P * F.transpose() + 0.4 * G * G.transpose();
    P = (prior.inverse() + H.transpose() * R.inverse() * H).inverse();
    mean += P.trace() / 25.0;
  }
  for (const char* belief : {"study.seed=1", "filter.process_scale=9"}) {
    const auto contest = kLinearOffer.contest(rail_scenario({belief}));
    const VehicleBound bound = contest->bound();
    EXPECT_NEAR(bound.position_squared, mean, 1e-12 * mean) << belief;
    EXPECT_TRUE(std::isnan(bound.heading_squared)) << "the states are no vehicle's";
    EXPECT_FALSE(contest->has_vehicle());
  }
}

// Two exact sensors of one thing: S of the filter that knows is singular, and what it would say after is not
// known. The filter that takes them for noisy goes on.
TEST(LinearContest, WithoutASThatIsPositiveDefiniteThereIsNoBound) {
  const auto contest =
      kLinearOffer.contest(rail_scenario({"world.R=[[0, 0], [0, 0]]", "filter.R=[[0.02, 0], [0, 0.02]]"}));
  EXPECT_TRUE(std::isnan(contest->bound().position_squared));
}

// A player tells of each estimator what its experiment shows of the same run.
TEST(LinearContest, TheStepsAreThoseOfTheExperiments) {
  const Scenario scenario = rail_scenario({"filter.measurement_scale=2"});
  const auto contest = kLinearOffer.contest(scenario);
  EXPECT_EQ(contest->steps(), 25);
  EXPECT_EQ(contest->unknowns(), 2);
  const std::vector<std::string> names = {"kalman", "smoother"};
  const auto player = contest->player(names);
  for (const std::int64_t run : {0, 7}) {
    RailListener listener;
    player->play(run, listener);
    for (std::size_t e = 0; e < names.size(); ++e) {
      ASSERT_EQ(listener.heard[e].size(), 25U) << names[e];
      linear_estimator_experiment(scenario, names[e])->visit(run, [&](const TraceStep& shown) {
        if (shown.step == 0) return;
        EstimatorStep& step = listener.heard[e][static_cast<std::size_t>(shown.step) - 1];
        const Vector error = shown.estimate - shown.truth;
        EXPECT_NEAR(step.position_squared, error.squaredNorm(), 1e-13);
        EXPECT_DOUBLE_EQ(step.position_variance, shown.P.trace());
        EXPECT_NEAR(step[EstimatorBlock::pose].value, error.dot(shown.P.llt().solve(error)), 1e-9);
        EXPECT_EQ(step[EstimatorBlock::pose].dof, 2);
        EXPECT_EQ(step[EstimatorBlock::heading].dof, 0);
      });
    }
  }
  RailListener stopped;
  stopped.last = 3;
  player->play(1, stopped);
  EXPECT_EQ(stopped.heard[0].size(), 3U);
}

// H F^k, k = 0 … n − 1, of an observable cart and of one whose place is not measured.
TEST(LinearContest, TheProfileHasTheRowsOfTheObservabilityMatrix) {
  for (const bool observable : {true, false}) {
    const auto contest = kLinearOffer.contest(rail_scenario(
        observable ? std::vector<std::string>{} : std::vector<std::string>{"world.H=[[0, 1], [0, 1]]"}));
    std::vector<Vector> rows;
    const EstimatorProfile profile =
        contest->profile("kalman", [&](const VectorRef& row) { rows.emplace_back(row); });
    EXPECT_EQ(profile.known, 2);
    ASSERT_EQ(rows.size(), 4U);
    Matrix O(4, 2);
    for (Index r = 0; r < 4; ++r) O.row(r) = rows[static_cast<std::size_t>(r)].transpose();
    EXPECT_EQ(Eigen::ColPivHouseholderQR<Matrix>(O).rank(), observable ? 2 : 1);
  }
}

}  // namespace
}  // namespace credence::internal
