#include "app/run_arrays.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/nan.h"
#include "datasets/logs/arrays/npz_writer.h"

namespace credence::internal {
namespace {

Matrix matrix2(double a, double b, double c, double d) {
  Matrix m(2, 2);
  m << a, b, c, d;
  return m;
}

Step step_of(std::vector<Index> states, const Vector& error, const Matrix& P,
             std::vector<Innovation> innovations) {
  Step step;
  step.states = std::move(states);
  step.error = error;
  step.P = P;
  step.innovations = std::move(innovations);
  return step;
}

Vector vector_of(std::vector<double> values) { return Eigen::Map<Vector>(values.data(), std::ssize(values)); }

/// Of states x, y and z, and one sensor.
RunLayout layout_of_three() {
  RunLayout layout;
  layout.states = {"x", "y", "z"};
  layout.angles = {false, false, true};
  layout.units = {"m", "", "rad"};
  layout.sensors = {{.name = "", .dim = 2, .piece = 2}};
  return layout;
}

TEST(RunArrays, StatesAndMeasurementsThatAreNotThereAreNaN) {
  const std::vector<Step> steps = {
      // z comes first and x later, as with a landmark that is seen late; a single number is measured.
      step_of({2}, vector_of({0.5}), Matrix::Constant(1, 1, 4.0),
              {{.nu = vector_of({7.0}), .S = Matrix::Constant(1, 1, 9.0)}}),
      step_of({0, 2}, vector_of({-1.0, 0.25}), matrix2(1.0, 0.1, 0.2, 2.0),
              {{.nu = vector_of({1.0, 2.0}), .S = matrix2(3.0, 0.3, 0.4, 5.0)}}),
      step_of({0, 1, 2}, vector_of({1.0, 2.0, 3.0}), Matrix::Identity(3, 3), {{}})};
  constexpr double x = kNaN;
  const std::vector<NamedArray> expected = {
      {"error", {1, 3, 3}, {x, x, 0.5, -1.0, x, 0.25, 1.0, 2.0, 3.0}},
      {"P", {1, 3, 3, 3}, {x,   x, x,   x, x, x, x,   x, 4.0,  // the first step
                           1.0, x, 0.1, x, x, x, 0.2, x, 2.0,  //
                           1.0, 0, 0,   0, 1, 0, 0,   0, 1.0}},
      {"names", {3}, {}, {"x [m]", "y", "z:angle [rad]"}},
      {"innovation", {1, 3, 2}, {7.0, x, 1.0, 2.0, x, x}},
      {"S", {1, 3, 2, 2}, {9.0, x, x, x, 3.0, 0.3, 0.4, 5.0, x, x, x, x}}};
  EXPECT_EQ(run_arrays(layout_of_three(), steps), npz_bytes(expected));
}

TEST(RunArrays, WithoutAnInnovationThereIsNoSuchArray) {
  const std::vector<Step> steps = {step_of({0}, vector_of({0.5}), Matrix::Constant(1, 1, 4.0), {{}})};
  RunLayout layout;
  layout.states = {"x"};
  layout.sensors = {{.name = "", .dim = 1, .piece = 1, .variances = {2.0}}};
  const std::vector<NamedArray> expected = {
      {"error", {1, 1, 1}, {0.5}}, {"P", {1, 1, 1, 1}, {4.0}}, {"names", {1}, {}, {"x"}}};
  EXPECT_EQ(run_arrays(layout, steps), npz_bytes(expected));
}

// What check must know beside the numbers: which belong to one observation, R, and what the filter is known
// to do.
TEST(RunArrays, TellOfObservationsNoiseAndFilter) {
  const Vector nu = vector_of({1.0, 2.0, 3.0, 4.0});
  const std::vector<Step> steps = {step_of({0}, vector_of({0.5}), Matrix::Constant(1, 1, 4.0),
                                           {{.nu = nu, .S = Matrix(Matrix::Identity(4, 4))}})};
  RunLayout layout;
  layout.states = {"x"};
  layout.sensors = {{.name = "", .dim = 6, .piece = 2, .variances = {0.25, 0.01}}};
  layout.nonlinear = layout.inflated = true;
  std::vector<double> identity(16, 0.0);
  for (std::size_t i = 0; i < 4; ++i) identity[5 * i] = 1.0;
  const std::vector<NamedArray> expected = {{"error", {1, 1, 1}, {0.5}},
                                            {"P", {1, 1, 1, 1}, {4.0}},
                                            {"names", {1}, {}, {"x"}},
                                            {"innovation", {1, 1, 4}, {1.0, 2.0, 3.0, 4.0}},
                                            {"S", {1, 1, 4, 4}, identity},
                                            {"observation", {1}, {2.0}},
                                            {"R", {2, 2}, {0.25, 0.0, 0.0, 0.01}},
                                            {"nonlinear", {1}, {1.0}},
                                            {"inflated", {1}, {1.0}}};
  EXPECT_EQ(run_arrays(layout, steps), npz_bytes(expected));
}

}  // namespace
}  // namespace credence::internal
