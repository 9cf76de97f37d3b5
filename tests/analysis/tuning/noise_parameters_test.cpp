#include "analysis/tuning/noise_parameters.h"

#include <gmock/gmock.h>

#include "tests/analysis/tuning/local_level.h"

namespace credence::internal {
namespace {

using testing::survey_model;

TEST(NoiseParameters, ReadsWhatIsFree) {
  EXPECT_THAT(parse_free_noise("Q, diag(R),full(P0)"),
              ::testing::ElementsAre(FreeNoise{NoiseMatrix::Q, NoiseForm::factor},
                                     FreeNoise{NoiseMatrix::R, NoiseForm::diagonal},
                                     FreeNoise{NoiseMatrix::P0, NoiseForm::full}));
  for (const char* bad : {"", "S", "Q,Q", "diag(Q),Q", "diag()", "Q,", "full(Q"}) {
    EXPECT_THROW(parse_free_noise(bad), std::invalid_argument) << bad;
  }
}

TEST(NoiseParameters, StartIsTheModel) {
  const LinearModel model = survey_model();
  for (const char* free : {"Q,R,P0", "full(Q),diag(R),full(P0)"}) {
    const NoiseParameters noise(model, parse_free_noise(free));
    const LinearModel at = noise.at(noise.start());
    EXPECT_LT((at.Q - model.Q).norm() + (at.R - model.R).norm() + (at.P0 - model.P0).norm(), 1e-14) << free;
  }
}

TEST(NoiseParameters, DerivativesAreThoseOfDifferences) {
  const NoiseParameters noise(survey_model(), parse_free_noise("full(Q),diag(R),P0"));
  EXPECT_THAT(noise.names(),
              ::testing::ElementsAre("L_Q[1,1]", "L_Q[2,1]", "L_Q[2,2]", "R[1,1]", "R[2,2]", "P0"));
  Vector phi = noise.start();
  phi.array() += 0.3;
  const std::vector<NoiseDerivative> derivatives = noise.derivatives(phi);
  const std::vector<NoiseValue> values = noise.values(phi);
  EXPECT_EQ(values[1].name, "Q[2,1]");
  EXPECT_FALSE(values[1].positive);
  constexpr double h = 1e-6;
  for (Index i = 0; i < noise.size(); ++i) {
    Vector more = phi, less = phi;
    more[i] += h;
    less[i] -= h;
    const Matrix Q = (noise.at(more).Q - noise.at(less).Q) / (2.0 * h);
    const Matrix& claimed = derivatives[static_cast<std::size_t>(i)].Q;
    EXPECT_LT((Q - (claimed.size() > 0 ? claimed : Matrix::Zero(2, 2))).norm(), 1e-8) << i;
    for (std::size_t v = 0; v < values.size(); ++v) {
      const double slope = (noise.values(more)[v].value - noise.values(less)[v].value) / (2.0 * h);
      EXPECT_NEAR(values[v].gradient[i], slope, 1e-8) << v << " by " << i;
    }
  }
}

TEST(NoiseParameters, ScalesMultiplyWholeCovariances) {
  const NoiseParameters noise(survey_model(), parse_free_noise("full(Q),diag(R),P0"));
  Vector phi = noise.start();
  phi.array() += 0.3;
  const Vector t{{std::log(3.0), std::log(0.5), std::log(7.0)}};
  const LinearModel before = noise.at(phi), after = noise.at(noise.scaled(phi, t));
  EXPECT_LT((after.Q - 3.0 * before.Q).norm(), 1e-13 * after.Q.norm());
  EXPECT_LT((after.R - 0.5 * before.R).norm(), 1e-13 * after.R.norm());
  EXPECT_LT((after.P0 - 7.0 * before.P0).norm(), 1e-13 * after.P0.norm());
  const Matrix directions = noise.scale_directions(phi);
  ASSERT_EQ(directions.cols(), 3);
  constexpr double h = 1e-6;
  for (Index j = 0; j < 3; ++j) {
    const Vector step = h * Vector::Unit(3, j);
    const Vector slope = (noise.scaled(phi, step) - noise.scaled(phi, -step)) / (2.0 * h);
    EXPECT_LT((directions.col(j) - slope).norm(), 1e-9) << j;
  }
}

TEST(NoiseParameters, RefusesWhatHasNoFactor) {
  LinearModel model = survey_model();
  EXPECT_THROW(NoiseParameters(model, parse_free_noise("diag(Q)")), std::invalid_argument);
  model.Q = Vector{{1.0, 0.0}}.asDiagonal();
  EXPECT_NO_THROW(NoiseParameters(model, parse_free_noise("Q")));
  EXPECT_THROW(NoiseParameters(model, parse_free_noise("diag(Q)")), std::invalid_argument);
  EXPECT_THROW(NoiseParameters(model, parse_free_noise("full(Q)")), std::invalid_argument);
  model.Q.setZero();
  EXPECT_THROW(NoiseParameters(model, parse_free_noise("Q")), std::invalid_argument);
}

}  // namespace
}  // namespace credence::internal
