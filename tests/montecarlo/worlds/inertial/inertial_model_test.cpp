#include "montecarlo/worlds/inertial/inertial_model.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "montecarlo/scenario/scenario_io.h"

namespace credence::internal {
namespace {

using ::testing::ElementsAre;
using Flight = InertialModel::Group;

constexpr double kInertialStep_s = 0.01;  // the default of world.dt

InertialModel inertial_model(const std::vector<std::string>& overrides) {
  return InertialModel(load_scenario_text("[world]\nmodel = \"inertial\"\n", "t.toml", overrides));
}

const std::vector<std::string> kQuietUnit = {"noise.gyro_density=0", "noise.accelerometer_density=0",
                                             "noise.gyro_bias_walk=0", "noise.accelerometer_bias_walk=0"};

NoiseDraw flight_draw(std::int64_t k, NoisePurpose purpose) {
  static const NoiseSource source(3, 1);
  return NoiseDraw(source, 0, k, purpose);
}

/// Heading 30°, at (1, 2, 3) m with (4, 5, 6) m/s, biases 0.01 … 0.06.
Flight tilted_flight() {
  SE23::Vectors vectors;
  vectors << Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(4, 5, 6);
  const SO3 heading = SO3::Exp(Eigen::Vector3d(0, 0, std::numbers::pi / 6.0));
  return {SE23(heading, vectors), VectorGroup<6>(0.01 * InertialModel::Input::LinSpaced(6, 1.0, 6.0))};
}

// The acceleration −v²/r (sin, cos) of the angle of the middle of each step, summed one by one.
TEST(InertialModel, FliesClockwiseByTheSumOfItsAccelerations) {
  std::vector<std::string> settings = kQuietUnit;
  settings.insert(settings.end(), {"world.path_radius=20", "world.speed=5"});
  const InertialModel model = inertial_model(settings);
  Flight x = model.start();
  Eigen::Vector3d p(0.0, 20.0, 0.0), v(5.0, 0.0, 0.0);
  for (std::int64_t k = 1; k <= 400; ++k) {
    NoiseDraw draw = flight_draw(k, NoisePurpose::process);
    x = model.step(x, k, draw);
    const double angle = 5.0 / 20.0 * kInertialStep_s * (static_cast<double>(k) - 0.5);
    const Eigen::Vector3d a = -25.0 / 20.0 * Eigen::Vector3d(std::sin(angle), std::cos(angle), 0.0);
    p += kInertialStep_s * v + 0.5 * kInertialStep_s * kInertialStep_s * a;
    v += kInertialStep_s * a;
  }
  EXPECT_LT((x.first().translation() - p).norm(), 1e-11);
  EXPECT_LT((x.first().velocity() - v).norm(), 1e-11);
  EXPECT_LT((x.first().rotation().Log() - Eigen::Vector3d(0, 0, -1.0)).norm(), 1e-11) << "4 s of 1/4 rad/s";
}

// A unit that hardly moves and does not turn reads gravity and its biases.
TEST(InertialModel, AReadingIsRateForceBiasAndNoise) {
  std::vector<std::string> quiet = kQuietUnit;
  quiet.insert(quiet.end(), {"world.attitude=fixed", "world.speed=1e-9"});
  NoiseDraw nothing = flight_draw(7, NoisePurpose::process);
  const InertialModel::Input read = inertial_model(quiet).input(tilted_flight(), 7, nothing);
  InertialModel::Input expected;
  expected << 0.01, 0.02, 0.03, 0.04, 0.05, 9.82 + 0.06;
  EXPECT_LT((read - expected).norm(), 1e-12);
  NoiseDraw noise = flight_draw(7, NoisePurpose::process), same = flight_draw(7, NoisePurpose::process);
  const InertialModel noisy = inertial_model({"world.attitude=fixed", "world.speed=1e-9",
                                              "noise.gyro_density=0.2", "noise.accelerometer_density=3"});
  const InertialModel::Input off = noisy.input(tilted_flight(), 7, noise) - expected;
  const Vector white = same.normals(6);  // of a mean over 0.01 s: density / 0.1 √s
  EXPECT_LT((off.head<3>() - 2.0 * white.head(3)).norm(), 1e-12);
  EXPECT_LT((off.tail<3>() - 30.0 * white.tail(3)).norm(), 1e-12);
}

TEST(InertialModel, SatellitesGivePlaceAndVelocityEveryInterval) {
  const InertialModel model = inertial_model({"world.aiding_interval=5", "noise.position_std=2",
                                              "noise.velocity_std=0.5", "filter.measurement_scale=3"});
  const Flight x = tilted_flight();
  NoiseDraw draw = flight_draw(5, NoisePurpose::measurement),
            same = flight_draw(5, NoisePurpose::measurement);
  const std::optional<Aiding> seen = model.measure(x, 5, draw);
  ASSERT_TRUE(seen.has_value());
  Vector std(6), z(6);
  std << 2, 2, 2, 0.5, 0.5, 0.5;
  z << 1, 2, 3, 4, 5, 6;
  const Vector error = std.cwiseProduct(Vector(same.normals(6)));
  EXPECT_LT((seen->z - z - error).norm(), 1e-14);
  EXPECT_FALSE(model.measure(x, 6, draw).has_value());
  const auto innovation = model.innovation(x, *seen);
  EXPECT_LT((innovation.nu - error).norm(), 1e-14);
  EXPECT_LT((innovation.R - Matrix(3.0 * std.cwiseAbs2().asDiagonal())).norm(), 1e-14)
      << "as the filter thinks";
  EXPECT_THAT(model.layout().sensors.front().variances, ElementsAre(12, 12, 12, 0.75, 0.75, 0.75));
}

// Heading 30°: l − p turned back by it.
TEST(InertialModel, AnInnovationIsOfTheLandmarksThatAreSeenInTheirOrder) {
  const InertialModel model = inertial_model({"world.aiding=landmarks", "noise.relative_position_std=0.2"});
  const Flight x = tilted_flight();
  Aiding seen{.z = Vector::Zero(6), .landmarks = {2, 0}};
  const auto innovation = model.innovation(x, seen);
  const double c = std::sqrt(0.75), s = 0.5;
  ASSERT_EQ(innovation.nu.size(), 6);
  for (std::size_t i = 0; i < 2; ++i) {
    const Eigen::Vector3d d = model.landmarks()[i == 0 ? 2 : 0] - Eigen::Vector3d(1, 2, 3);
    const Eigen::Vector3d relative(c * d.x() + s * d.y(), c * d.y() - s * d.x(), d.z());
    EXPECT_LT((innovation.nu.segment<3>(3 * static_cast<Index>(i)) + relative).norm(), 1e-12);
  }
  EXPECT_LT((innovation.R - 0.04 * Matrix::Identity(6, 6)).norm(), 1e-15);
  EXPECT_EQ(model.layout().sensors.front().dim, 9);
  EXPECT_EQ(model.layout().sensors.front().piece, 3);
}

TEST(InertialModel, StatesTheUnitsOfItsStart) {
  const InertialModel model =
      inertial_model({"initial.position_std=2", "initial.velocity_std=3", "initial.attitude_std_deg=180",
                      "initial.gyro_bias_std=4", "initial.accelerometer_bias_std=5"});
  const Flight::Tangent& std = model.initial_std();
  const double blocks[] = {2.0, 3.0, std::numbers::pi, 4.0, 5.0};
  for (int i = 0; i < 15; ++i) EXPECT_DOUBLE_EQ(std[i], blocks[i / 3]) << i;
  const RunLayout& layout = model.layout();
  for (std::size_t i = 0; i < 15; ++i) EXPECT_EQ(layout.angles[i], i / 3 == 2) << layout.states[i];
}

}  // namespace
}  // namespace credence::internal
