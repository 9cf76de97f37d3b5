#include "montecarlo/lanes/linear_kernel_units.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

namespace credence::internal {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

LinearErrorSystem small_system() {
  LinearErrorSystem system;
  system.F = Matrix{{1.0, 0.5}, {0.0, 0.9}};
  system.noise_input = Matrix{{0.0}, {-4.0}};
  system.H = Matrix{{1.0, 2.0}};
  system.measurement_root = Matrix{{3.0}};
  system.initial_root = Matrix{{2.0, 0.0}, {1.0, 5.0}};
  system.steps = {{Matrix{{0.25}, {0.5}}, Matrix{{0.125}}, Matrix{{0.5, 0.0}, {0.25, 0.0625}}}};
  return system;
}

/// ‖W ν‖², ‖V e‖² of the first step for given standard normals, as the definition says.
std::pair<double, double> first_step(const LinearErrorSystem& s, const Vector& n, double v, double w) {
  const Vector prior = s.F * (s.initial_root * n) + s.noise_input * v;
  const Vector nu = s.H * prior + s.measurement_root * w;
  const Vector error = prior - s.steps[0].K * nu;
  return {(s.steps[0].innovation_whitening * nu).squaredNorm(),
          (s.steps[0].error_whitening * error).squaredNorm()};
}

TEST(LinearKernelUnits, NeesAndNisAreTheSameInAllUnits) {
  const LinearErrorSystem system = small_system();
  const LinearSystemInUnits in_units = linear_system_in_units(system);
  EXPECT_EQ(in_units.unit, -4.0) << "the first that is not zero";
  EXPECT_EQ(in_units.system.noise_input(1, 0), 1.0) << "which is what is saved";
  EXPECT_EQ(in_units.system.steps[0].error_whitening(1, 1), 1.0);
  EXPECT_EQ(in_units.system.steps[0].innovation_whitening(0, 0), 1.0);
  for (const double x : {0.3, -1.7}) {
    const Vector n{{x, 1.0 - x}};
    const auto [nis, nees] = first_step(system, n, 0.5 + x, -0.25);
    const auto [nis_in, nees_in] = first_step(in_units.system, n, 0.5 + x, -0.25);
    EXPECT_NEAR(in_units.nis_scale[0] * nis_in, nis, 1e-14 * nis);
    EXPECT_NEAR(in_units.nees_scale[0] * nees_in, nees, 1e-14 * nees);
  }
}

TEST(LinearKernelUnits, EveryMatrixOfAPeriodIsInTheSameUnits) {
  LinearErrorSystem system = small_system();
  LinearErrorDynamics second = system;
  second.noise_input = Matrix{{8.0}, {0.0}};
  second.measurement_root = Matrix{{6.0}};
  system.later = {second};
  const LinearSystemInUnits in_units = linear_system_in_units(system);
  EXPECT_EQ(in_units.system.later[0].noise_input, second.noise_input / -4.0);
  EXPECT_EQ(in_units.system.later[0].measurement_root, second.measurement_root / -4.0);
  EXPECT_EQ(in_units.system.initial_root, system.initial_root / -4.0);
  EXPECT_EQ(in_units.system.later[0].F, system.F) << "has no unit to change";
}

TEST(LinearKernelUnits, WithoutProcessNoiseUnitsStay) {
  LinearErrorSystem system = small_system();
  system.noise_input.setZero();
  EXPECT_EQ(linear_system_in_units(system).unit, 1.0);
}

TEST(LinearKernelUnits, WhatWouldLeaveTheRangeStaysAsItIs) {
  LinearErrorSystem system = small_system();
  system.noise_input = Matrix{{1.0}, {0.0}};
  for (const double extreme : {1e200, 1e-200, 0.0}) {
    system.steps[0].innovation_whitening = Matrix{{extreme}};
    const LinearSystemInUnits in_units = linear_system_in_units(system);
    EXPECT_EQ(in_units.nis_scale[0], 1.0) << extreme;
    EXPECT_EQ(in_units.system.steps[0].innovation_whitening(0, 0), extreme);
  }
  system.steps[0].innovation_whitening = Matrix(0, 1);  // no direction has a variance
  EXPECT_EQ(linear_system_in_units(system).nis_scale[0], 1.0);
}

TEST(LinearKernelUnits, ShapesThatDoNotMatchAreRefusedByName) {
  const auto refused = [](void (*spoil)(LinearErrorSystem&), const char* text) {
    LinearErrorSystem system = small_system();
    spoil(system);
    EXPECT_THAT([&] { linear_system_in_units(system); },
                ThrowsMessage<std::invalid_argument>(HasSubstr(text)));
  };
  refused(
      [](LinearErrorSystem& s) {
        s.F.resize(2, 3);
        s.F.setZero();
      },
      "F is 2x3, not 2x2");
  refused([](LinearErrorSystem& s) { s.H = Matrix::Ones(1, 3); }, "H is 1x3, not 1x2");
  refused([](LinearErrorSystem& s) { s.noise_input = Matrix::Ones(3, 1); }, "noise_input is 3x1, not 2x1");
  refused([](LinearErrorSystem& s) { s.measurement_root = Matrix::Ones(2, 2); },
          "measurement_root is 2x2, not 1x1");
  refused([](LinearErrorSystem& s) { s.initial_root = Matrix::Ones(2, 1); }, "initial_root is 2x1, not 2x2");
  refused([](LinearErrorSystem& s) { s.steps[0].K = Matrix::Ones(1, 2); }, "K is 1x2, not 2x1");
  refused([](LinearErrorSystem& s) { s.steps[0].error_whitening = Matrix::Ones(2, 3); },
          "error_whitening is 2x3");
  refused([](LinearErrorSystem& s) { s.F(0, 1) = std::nan(""); }, "F has an entry that is not finite");
  refused(
      [](LinearErrorSystem& s) {
        s.steps[0].innovation_whitening(0, 0) = std::numeric_limits<double>::infinity();
      },
      "innovation_whitening has an entry that is not finite");
  refused(
      [](LinearErrorSystem& s) {
        s.later = {s};
        s.later[0].H = Matrix::Ones(2, 2);
      },
      "H is 2x2, not 1x2");
}

}  // namespace
}  // namespace credence::internal
