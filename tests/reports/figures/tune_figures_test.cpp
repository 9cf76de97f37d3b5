#include "reports/figures/tune_figures.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "montecarlo/scenario/scenario_io.h"

namespace credence::internal {
namespace {

/// −½ Σ a_i (φ_i − t_i)² of two factors e^φ, whose profiles are parabolas.
class ParabolaScore final : public ScoreModel {
 public:
  Index parameters() const override { return 2; }
  std::vector<std::string> names() const override { return {"a", "b"}; }
  std::vector<NoiseValue> values(const Vector& phi) const override {
    return {{"a", std::exp(phi[0]), std::exp(phi[0]) * Vector::Unit(2, 0)},
            {"b", std::exp(phi[1]), std::exp(phi[1]) * Vector::Unit(2, 1)}};
  }
  Index units() const override { return 1; }
  bool has_gradient() const override { return true; }
  UnitScores scores(const Vector& phi, bool gradient) const override {
    const Vector off = Vector{{0.5, -0.25}} - phi;
    UnitScores scores;
    scores.value = Vector::Constant(1, -0.5 * off.dot(information_ * off));
    if (gradient) scores.gradient = information_ * off;
    scores.nis = scores.lag_one = Vector::Ones(1);
    scores.steps = scores.dof = 1.0;
    return scores;
  }
  Matrix expected_information(const Vector& /*phi*/) const override { return information_; }

 private:
  Matrix information_{Vector{{40.0, 10.0}}.asDiagonal()};
};

ScenarioScore::Key thousandth(const std::string& parameter) { return {"filter." + parameter, 1e-3}; }

const Series& labelled(const Panel& panel, const std::string& label) {
  return *std::ranges::find_if(panel.series, [&](const Series& s) { return s.label.text == label; });
}

Figure figure_of_parabolas(const Vector& start) {
  const ParabolaScore score;
  return tune_profile_figure(score, tune(score, start), thousandth);
}

TEST(TuneFigures, AProfileFallsByTheLevelOfTheLikelihoodRatio) {
  const Figure figure = figure_of_parabolas(Vector::Zero(2));
  EXPECT_NO_THROW(validate(figure));
  ASSERT_EQ(figure.panels.size(), 2U);
  for (const auto& [panel, top, information] : {std::tuple{0U, 0.5, 40.0}, std::tuple{1U, -0.25, 10.0}}) {
    const Panel& of = figure.panels[panel];
    EXPECT_EQ(of.x_label.text, panel == 0 ? "filter.a" : "filter.b");
    const Series& profile = labelled(of, "profile");
    ASSERT_GE(profile.x.size(), 9U);
    for (std::size_t i = 0; i < profile.x.size(); ++i) {
      const double phi = std::log(profile.x[i] / 1e-3);
      EXPECT_NEAR(profile.y[i], -0.5 * information * (phi - top) * (phi - top), 1e-4);
    }
    // χ² of one dof: its quantile of 95 % is 3.841459 (tables).
    EXPECT_NEAR(labelled(of, "95 % interval").y.at(0), -0.5 * 3.841459, 1e-6);
    EXPECT_NEAR(labelled(of, "tuned").x.at(0), 1e-3 * std::exp(top), 1e-8);
    EXPECT_GE(profile.y.front(), -8.0);
    EXPECT_LT(profile.y.front(), -0.5 * 3.841459) << "beyond the interval";
  }
}

TEST(TuneFigures, ThePresentValueIsDrawnWhereItIsNear) {
  const auto has_present = [](const Panel& panel) {
    return std::ranges::any_of(panel.series, [](const Series& s) { return s.label.text == "present"; });
  };
  // 0.5/√(1/40) is 3.2 standard errors off, 0.25/√(1/10) 0.8 of them.
  const Figure near = figure_of_parabolas(Vector::Zero(2));
  EXPECT_TRUE(has_present(near.panels[0]));
  EXPECT_NEAR(labelled(near.panels[1], "present").x.at(0), 1e-3, 1e-12);
  const Figure far = figure_of_parabolas(Vector{{-0.5, 0.0}});
  EXPECT_FALSE(has_present(far.panels[0]));
  EXPECT_TRUE(has_present(far.panels[1]));
}

/// −½ |φ|² of so many factors.
class SphereScore final : public ScoreModel {
 public:
  explicit SphereScore(Index count) : count_(count) {}
  Index parameters() const override { return count_; }
  std::vector<std::string> names() const override {
    std::vector<std::string> all;
    for (Index i = 0; i < count_; ++i) all.push_back("p" + std::to_string(i));
    return all;
  }
  std::vector<NoiseValue> values(const Vector& /*phi*/) const override { return {}; }
  Index units() const override { return 1; }
  bool has_gradient() const override { return true; }
  UnitScores scores(const Vector& phi, bool gradient) const override {
    UnitScores scores;
    scores.value = Vector::Constant(1, -0.5 * phi.squaredNorm());
    if (gradient) scores.gradient = -phi;
    scores.nis = scores.lag_one = Vector::Ones(1);
    scores.steps = scores.dof = 1.0;
    return scores;
  }
  Matrix expected_information(const Vector& /*phi*/) const override {
    return Matrix::Identity(count_, count_);
  }

 private:
  Index count_;
};

TEST(TuneFigures, ProfilesOfManyParametersCanBeDrawn) {
  const SphereScore score(42);
  const Figure figure = tune_profile_figure(score, tune(score, Vector::Zero(42)), thousandth);
  EXPECT_NO_THROW(validate(figure));
  EXPECT_EQ(figure.cols, 2);
  EXPECT_EQ(figure.panels.size(), kMostPanels);
  EXPECT_THAT(figure.caption, testing::EndsWith(" Of 42 parameters the first 40 are shown."));
}

TEST(TuneFigures, TheMapOfTwoSaysWhatItHolds) {
  const Scenario scenario = load_scenario_text(
      "[world]\nmodel = \"linear\"\nF = [[1]]\nG = [[1]]\nH = [[1]]\nQ = [[0.04]]\nR = [[1]]\nP0 = [[1]]\n"
      "states = [\"x\"]\n[study]\nruns = 40\nsteps = 40\nseed = 7\n[filter]\nprocess_scale = 0.1\n",
      "wanderer");
  TuneRequest request{.threads = 1};
  EXPECT_THAT(tune_surface_figure(*tune_scenario(scenario, request)).caption,
              testing::Not(testing::HasSubstr("Held")));
  request.free.push_back({NoiseMatrix::P0, NoiseForm::factor});
  EXPECT_THAT(tune_surface_figure(*tune_scenario(scenario, request)).caption,
              testing::EndsWith(" Held at what was tuned: factor of filter.P0."));
}

}  // namespace
}  // namespace credence::internal
