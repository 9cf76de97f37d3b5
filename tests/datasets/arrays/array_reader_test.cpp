#include "datasets/arrays/array_reader.h"

#include <gmock/gmock.h>

#include <limits>
#include <numbers>
#include <stdexcept>

#include "core/nan.h"

namespace credence::internal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kReaderInfinity = std::numeric_limits<double>::infinity();

/// One run of two rows: three states, of which the last is an angle, and a sensor of two dimensions.
class ArrayReaderRows : public ::testing::Test {
 protected:
  ArrayReaderRows() {
    arrays_.layout.states = {"x", "y", "heading"};
    arrays_.layout.angles = {false, false, true};
    arrays_.layout.sensors.push_back({.name = "gps", .dim = 2, .piece = 2});
    ArrayRun& run = arrays_.runs.emplace_back();
    run.steps = 2;
    run.error = {error_.data(), 3};
    run.P = {P_.data(), 9};
    run.innovations.push_back({{nu_.data(), 2}, {S_.data(), 0}});
  }

  Step row(std::int64_t k) {
    ArrayReader reader(arrays_);
    Step step;
    reader.read(0, k, step);
    return step;
  }

  void expect_reader_error(const std::string& problem) {
    EXPECT_THAT([&] { row(0); }, ::testing::ThrowsMessage<std::invalid_argument>(problem));
  }

  std::vector<double> error_ = {1, 2, 3, 4, 5, 6};
  std::vector<double> P_ = {9, 1, 2, 1, 8, 3, 2, 3, 7, 19, 0, 0, 0, 18, 0, 0, 0, 17};
  std::vector<double> nu_ = {0.5, 0.25, 0.75, 1.0}, S_ = {2, 1, 1, 3};
  std::vector<double> estimate_ = {10, 20, 30, 40, 50, 60};
  ArrayRuns arrays_;
};

TEST_F(ArrayReaderRows, a_row_is_a_step_and_a_stride_of_zero_repeats_it) {
  const Step first = row(0), second = row(1);
  EXPECT_EQ(first.step, 1);
  EXPECT_EQ(second.step, 2);
  EXPECT_EQ(second.line, 2);
  EXPECT_THAT(first.states, ElementsAre(0, 1, 2));
  EXPECT_EQ(first.error, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(first.P, (Matrix(3, 3) << 9, 1, 2, 1, 8, 3, 2, 3, 7).finished());
  EXPECT_NEAR(second.error[2], 6.0 - 2.0 * std::numbers::pi, 1e-15) << "an angle is wrapped";
  EXPECT_EQ(second.P.diagonal(), Eigen::Vector3d(19, 18, 17));
  EXPECT_EQ(second.innovations.at(0).nu, Eigen::Vector2d(0.75, 1.0));
  EXPECT_EQ(second.innovations[0].S, (Matrix(2, 2) << 2, 1, 1, 3).finished());
  EXPECT_EQ(first.estimate.size(), 0);
}

TEST_F(ArrayReaderRows, components_that_are_not_there_take_their_rows_of_P_and_S_along) {
  error_[1] = nu_[0] = kNaN;
  for (const std::size_t i : {1U, 3U, 4U, 5U, 7U}) P_[i] = kNaN;
  S_[0] = S_[1] = S_[2] = kNaN;
  arrays_.runs[0].estimate = {estimate_.data(), 3};
  estimate_[1] = kReaderInfinity;
  const Step step = row(0);
  EXPECT_THAT(step.states, ElementsAre(0, 2));
  EXPECT_EQ(step.error, Eigen::Vector2d(1, 3));
  EXPECT_EQ(step.estimate, Eigen::Vector2d(10, 30));
  EXPECT_EQ(step.P, (Matrix(2, 2) << 9, 2, 2, 7).finished());
  EXPECT_EQ(step.innovations.at(0).nu, Vector::Constant(1, 0.25));
  EXPECT_EQ(step.innovations[0].S, Matrix::Constant(1, 1, 3.0));
}

TEST_F(ArrayReaderRows, a_row_without_any_component_reads_no_covariance) {
  for (double& value : error_) value = kNaN;
  for (double& value : nu_) value = kNaN;
  arrays_.runs[0].P = {};
  arrays_.runs[0].innovations[0].S = {};
  const Step step = row(0);
  EXPECT_TRUE(step.states.empty());
  EXPECT_EQ(step.error.size(), 0);
  EXPECT_EQ(step.P.size(), 0);
  EXPECT_EQ(step.innovations.at(0).nu.size(), 0);
}

TEST_F(ArrayReaderRows, a_run_without_errors_has_innovations_alone) {
  arrays_.runs[0].error = arrays_.runs[0].P = {};
  const Step step = row(1);
  EXPECT_TRUE(step.states.empty());
  EXPECT_EQ(step.innovations.at(0).nu, Eigen::Vector2d(0.75, 1.0));
}

TEST_F(ArrayReaderRows, the_upper_triangle_counts_and_the_lower_one_may_differ_by_rounding) {
  P_[1] = 1.0 + 0.9e-5 * std::sqrt(72.0);
  EXPECT_EQ(row(0).P(1, 0), P_[1]);
  P_[1] = 1.0 + 1.1e-5 * std::sqrt(72.0);
  EXPECT_THAT([&] { row(0); }, ::testing::ThrowsMessage<std::invalid_argument>(
                                   HasSubstr("P[0, 0] is not symmetric: its entries [0, 1] and [1, 0] are")));
}

TEST_F(ArrayReaderRows, numbers_that_are_not_finite_are_named_with_their_place) {
  error_[2] = -kReaderInfinity;
  expect_reader_error("error[0, 0, 2] is -inf");
  error_[2] = 0.0;
  P_[4] = kNaN;
  expect_reader_error("P[0, 0, 1, 1] is nan");
  P_[4] = kReaderInfinity;
  expect_reader_error("P[0, 0, 1, 1] is inf");
  P_[4] = 8.0;
  P_[5] = kNaN;
  expect_reader_error("P[0, 0, 1, 2] is nan");
  P_[5] = 3.0;
  P_[7] = kReaderInfinity;
  expect_reader_error("P[0, 0, 2, 1] is inf");
  P_[7] = 3.0;
  nu_[1] = kReaderInfinity;
  expect_reader_error("innovation['gps'][0, 0, 1] is inf");
  nu_[1] = 0.0;
  S_[3] = kNaN;
  expect_reader_error("S['gps'][0, 0, 1, 1] is nan");
  S_[3] = 3.0;
  arrays_.runs[0].estimate = {estimate_.data(), 3};
  estimate_[0] = kNaN;
  expect_reader_error("estimate[0, 0, 0] is nan");
}

TEST_F(ArrayReaderRows, places_are_counted_as_the_arrays_are_indexed) {
  error_[0] = kReaderInfinity;
  arrays_.first_run = 5;
  expect_reader_error("error[5, 0, 0] is inf");
  arrays_.indexing = ArrayIndexing::listed;
  expect_reader_error("error[5][0, 0] is inf");
  arrays_.indexing = ArrayIndexing::single;
  expect_reader_error("error[0, 0] is inf");
}

TEST_F(ArrayReaderRows, one_step_is_used_for_row_after_row) {
  ArrayReader reader(arrays_);
  Step step;
  error_[0] = kNaN;
  nu_[0] = kNaN;
  reader.read(0, 0, step);
  step.problem = "of the row before";
  reader.read(0, 1, step);
  EXPECT_THAT(step.states, ElementsAre(0, 1, 2));
  EXPECT_EQ(step.P.rows(), 3);
  EXPECT_EQ(step.innovations.at(0).S.rows(), 2);
  EXPECT_EQ(step.problem, "");
  reader.read(0, 0, step);
  EXPECT_THAT(step.states, ElementsAre(1, 2));
  EXPECT_EQ(step.P, (Matrix(2, 2) << 8, 3, 3, 7).finished());
}

}  // namespace
}  // namespace credence::internal
