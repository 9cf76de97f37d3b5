#include "montecarlo/worlds/linear/linear_keys.h"

#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "montecarlo/scenario/scenario_io.h"

namespace credence::internal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Three states with one process noise and two measurements.
const std::string kThreeStates =
    "[world]\nmodel = \"linear\"\n"
    "F = [[1, 0, 0], [0, 2, 0], [0, 0, 3]]\nG = [[1], [2], [3]]\nH = [[1, 0, 0], [0, 1, 1]]\n"
    "Q = [[0.5]]\nR = [[1, 0], [0, 2]]\nP0 = [[4, 0, 0], [0, 5, 0], [0, 0, 6]]\n";

Scenario three_states(const std::vector<std::string>& overrides = {}) {
  return load_scenario_text(kThreeStates, "t.toml", overrides);
}

/// "impossible" or "wrong", the key, and what is said of it; "" for nothing.
std::string checked(const Scenario& scenario) {
  const auto thrower = [](const std::string& kind) {
    return [kind](std::string_view section, std::string_view name, const std::string& rule) {
      throw ScenarioError(kind + " " + std::string(section) + "." + std::string(name) + ": " + rule);
    };
  };
  try {
    check_linear(scenario, {.impossible = thrower("impossible"), .wrong = thrower("wrong")});
  } catch (const ScenarioError& error) {
    return error.what();
  }
  return "";
}

TEST(LinearKeys, TheFilterBelievesTheWorldWhereItSaysNothing) {
  const Scenario s = three_states({"world.period=2", "world.R=[[1, 0], [0, 2], [3, 0], [0, 4]]",
                                   "filter.F=[[7, 0, 0], [0, 7, 0], [0, 0, 7]]",
                                   "filter.H=[[1, 1, 1], [2, 2, 2], [3, 3, 3], [4, 4, 4]]"});
  const std::vector<LinearModel> truth = linear_truth(s), belief = linear_belief(s);
  ASSERT_EQ(truth.size(), 2U);
  ASSERT_EQ(belief.size(), 2U);
  for (std::size_t k = 0; k < 2; ++k) {
    const auto step = static_cast<double>(k);
    EXPECT_EQ(truth[k].F, Matrix(Vector::LinSpaced(3, 1.0, 3.0).asDiagonal()));
    EXPECT_EQ(truth[k].R, Matrix(Eigen::Vector2d(1.0 + 2.0 * step, 2.0 + 2.0 * step).asDiagonal()));
    EXPECT_EQ(belief[k].F, 7.0 * Matrix::Identity(3, 3)) << "one for all steps";
    EXPECT_EQ(belief[k].H.row(1), Matrix::Constant(1, 3, 2.0 + 2.0 * step)) << "its own for each step";
    EXPECT_EQ(belief[k].R, truth[k].R);
    EXPECT_EQ(belief[k].G, truth[k].G);
    EXPECT_EQ(belief[k].P0, truth[k].P0);
    EXPECT_EQ(belief[k].layout.vehicle, 3);
  }
}

// [filter] may have another number of process noises, if it says of which covariance.
TEST(LinearKeys, TheFilterMayHaveOtherProcessNoises) {
  const std::string G = "filter.G=[[1, 0], [0, 1], [1, 1]]";
  const LinearModel belief = linear_belief(three_states({G, "filter.Q=[[2, 1], [1, 2]]"})).front();
  EXPECT_EQ(belief.G, (Matrix(3, 2) << 1, 0, 0, 1, 1, 1).finished());
  EXPECT_EQ(belief.Q, (Matrix(2, 2) << 2, 1, 1, 2).finished());
  Scenario s = three_states();
  s.own["filter.G"] = NumberRows{{1, 0}, {0, 1}, {1, 1}};
  EXPECT_EQ(checked(s), "wrong filter.G: needs a filter.Q of 2×2, since world.Q is 1×1");
  s.own["filter.Q"] = NumberRows{{1}};
  EXPECT_THAT(checked(s), HasSubstr("wrong filter.Q: must be 2×2, as filter.G is 3×2; row 1 has 1 number"));
}

// Of v vᵀ with v = (1, 1/3, 1/7), in 17 digits; and of eigenvalues 1 ± (1 + 1e-7).
TEST(LinearKeys, ACovarianceMayBeSingularUpToRounding) {
  Scenario s = three_states();
  NumberRows outer(3, std::vector<double>(3));
  const double v[] = {1.0, 1.0 / 3.0, 1.0 / 7.0};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) outer[i][j] = v[i] * v[j];
  }
  s.own["world.P0"] = outer;
  EXPECT_EQ(checked(s), "");
  outer[2][2] -= 1e-9;
  s.own["filter.P0"] = outer;
  EXPECT_THAT(checked(s), HasSubstr("wrong filter.P0: must be positive semidefinite; its least eigenvalue"));
  s = three_states();
  s.own["world.R"] = NumberRows{{1, 1.0 + 1e-7}, {1.0 + 1e-7, 1}};
  EXPECT_EQ(checked(s), "wrong world.R: must be positive semidefinite; its least eigenvalue is -1e-07");
}

TEST(LinearKeys, NamesOfStatesHoldNoControlCharacters) {
  EXPECT_THROW(three_states({R"(world.states=["a", "b\u001b[31m", "c"])"}), ScenarioError);
  EXPECT_THROW(three_states({R"(world.states=["a", "b\u009b31m", "c"])"}), ScenarioError);
  EXPECT_EQ(linear_state_names(three_states({R"(world.states=["a", "β", "c"])"})).at(1), "β");
}

// A sweep leaves out what is impossible, and ends at what is wrong.
TEST(LinearKeys, OnlyTheDetectionProbabilityIsImpossible) {
  Scenario s = three_states();
  s.noise.detection_probability = 0.5;
  EXPECT_EQ(checked(s), "") << "R is diagonal";
  s.own["filter.R"] = NumberRows{{1, 0.25}, {0.25, 1}};
  EXPECT_EQ(checked(s),
            "impossible noise.detection_probability: must be 1 where world.R or filter.R is not diagonal");
  s.noise.detection_probability = 1.0;
  EXPECT_EQ(checked(s), "");
  s.own["filter.gain"] = NumberRows{{1, 0}, {0, 1}};
  EXPECT_EQ(checked(s), "wrong filter.gain: must be 3×2: it is the same at all steps");
}

TEST(LinearKeys, ConsideredStatesAreInTheOrderOfTheStates) {
  const Scenario plain = three_states({"filter.considered=[\"x3\", \"x1\"]"});
  EXPECT_THAT(linear_state_names(plain), ElementsAre("x1", "x2", "x3"));
  EXPECT_THAT(considered_states(plain), ElementsAre(0, 2));
  const Scenario named =
      three_states({"world.states=[\"c\", \"b\", \"a\"]", "filter.considered=[\"a\", \"b\"]",
                    "filter.gain=[[1, 2], [3, 4], [5, 6]]"});
  EXPECT_THAT(considered_states(named), ElementsAre(1, 2));
  EXPECT_EQ(linear_gain(named), (Matrix(3, 2) << 1, 2, 3, 4, 5, 6).finished());
  EXPECT_EQ(linear_gain(plain).size(), 0);
  EXPECT_THAT(considered_states(three_states()), IsEmpty());
}

}  // namespace
}  // namespace credence::internal
