#include "montecarlo/worlds/localisation/localisation_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "montecarlo/scenario/scenario_io.h"

namespace credence::internal {
namespace {

LocalisationModel localisation(const std::vector<std::string>& overrides) {
  return LocalisationModel(load_scenario_text("[world]\nmodel = \"localisation\"\n", "t.toml", overrides));
}

TEST(LocalisationModel, DrivesItsCircleExactly) {
  // After the angle α of a turn to the left about (0, r) the vehicle is at r (sin α, 1 − cos α), at heading
  // α: on the circle at every step, however long the steps are, as v and ω act together... of Exp(ω dt), v dt
  // a polygon, whose corners are on a circle of radius v dt / (2 sin(ω dt / 2)).
  const LocalisationModel model = localisation({"world.path_radius=5", "world.speed=2", "world.dt=0.5"});
  const NoiseSource source(1, 0);
  NoiseDraw draw(source, 0, 1, NoisePurpose::process);
  SE2 x = model.start();
  const double turn = 2.0 / 5.0 * 0.5, radius = 0.5 * 2.0 * 0.5 / std::sin(0.5 * turn);
  const Eigen::Vector2d centre = radius * Eigen::Vector2d(std::sin(0.5 * turn), std::cos(0.5 * turn));
  for (int k = 1; k <= 40; ++k) {
    x = model.step(x, k, draw);
    EXPECT_NEAR((x.translation() - centre).norm(), radius, 1e-12) << k;
    EXPECT_NEAR(std::remainder(x.rotation().angle_rad() - k * turn, 2.0 * std::numbers::pi), 0.0, 1e-12) << k;
  }
}

TEST(LocalisationModel, LandmarksStandAllRoundThePath) {
  const LocalisationModel model =
      localisation({"world.aiding=landmarks", "world.known_landmarks=4", "world.path_radius=10"});
  ASSERT_EQ(model.landmarks().size(), 4U);
  const Eigen::Vector2d expected[] = {{15.0, 10.0}, {0.0, 25.0}, {-15.0, 10.0}, {0.0, -5.0}};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_LT((model.landmarks()[i] - expected[i]).norm(), 1e-12) << i;
}

TEST(LocalisationModel, InnovationOfALandmarkByHand) {
  // Landmark 1 of four stands at (15, 10). From (12, 6), looking up, it is 4 ahead and 3 to the right.
  const LocalisationModel model =
      localisation({"world.aiding=landmarks", "world.known_landmarks=4", "world.path_radius=10",
                    "noise.relative_position_std=0.2", "filter.measurement_scale=3"});
  const SE2 x(SO2(std::numbers::pi / 2.0), {12.0, 6.0});
  const Aiding seen{.z = Vector{{4.5, -3.25}}, .landmarks = {0}};
  const auto innovation = model.innovation(x, seen);
  EXPECT_LT((innovation.nu - Vector{{0.5, -0.25}}).norm(), 1e-14);
  EXPECT_LT((innovation.R - 3.0 * 0.04 * Matrix::Identity(2, 2)).norm(), 1e-15);
  // Moved ahead by d it is nearer by d; turned to the left it goes to the right.
  Matrix H(2, 3);
  H << -1, 0, -3, 0, -1, -4;
  EXPECT_LT((Matrix(innovation.H) - H).norm(), 1e-14);
}

TEST(LocalisationModel, InnovationOfAFixByHand) {
  const LocalisationModel model = localisation({"noise.position_std=0.5"});
  const auto innovation =
      model.innovation(SE2(SO2(std::numbers::pi / 2.0), {1.0, 2.0}), {.z = Vector{{1.5, 1.0}}});
  EXPECT_LT((innovation.nu - Vector{{0.5, -1.0}}).norm(), 1e-15);
  EXPECT_LT((innovation.R - 0.25 * Matrix::Identity(2, 2)).norm(), 1e-15);
  Matrix H(2, 3);
  H << 0, -1, 0, 1, 0, 0;  // ahead is along the second axis
  EXPECT_LT((Matrix(innovation.H) - H).norm(), 1e-15);
}

/// Q is that of the readings' noise, by the mean over many of it: five standard errors of a covariance.
TEST(LocalisationModel, ProcessNoiseIsThatOfTheReadings) {
  const LocalisationModel model =
      localisation({"world.speed=3", "world.path_radius=2", "world.dt=0.4", "noise.speed_std=0.02",
                    "noise.turn_rate_std=0.01", "filter.process_scale=2"});
  const NoiseSource source(5, 6);
  const SE2 x(SO2(0.7), {3.0, -1.0});
  SE2 exact = x;
  {
    NoiseDraw none(source, 0, 0, NoisePurpose::process);
    exact = model.step(x, 1, none);
  }
  constexpr int kDraws = 20'000;
  Matrix sum = Matrix::Zero(3, 3);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (int i = 0; i < kDraws; ++i) {
    NoiseDraw draw(source, i, 1, NoisePurpose::process);
    const auto moved = model.motion(x, model.input(x, 1, draw)).moved;
    const Eigen::Vector3d error = minus(moved, exact, Chart::right);
    sum += error * error.transpose() / kDraws;
    mean += error / kDraws;
  }
  NoiseDraw draw(source, 0, 1, NoisePurpose::process);
  const Matrix Q = Matrix(model.motion(x, model.input(x, 1, draw)).Q) / 2.0;  // twice what there is
  for (Index i = 0; i < 3; ++i) {
    EXPECT_NEAR(mean[i], 0.0, 5.0 * std::sqrt(Q(i, i) / kDraws));
    for (Index j = 0; j < 3; ++j) {
      const double standard_error = std::sqrt((Q(i, i) * Q(j, j) + Q(i, j) * Q(i, j)) / kDraws);
      EXPECT_NEAR(sum(i, j), Q(i, j), 5.0 * standard_error) << i << j;
    }
  }
}

}  // namespace
}  // namespace credence::internal
