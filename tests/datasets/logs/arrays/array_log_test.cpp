#include "datasets/logs/arrays/array_log.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <random>

#include "core/manifold/angle.h"
#include "core/nan.h"
#include "datasets/data_error.h"
#include "tests/datasets/logs/recorded_sink.h"

namespace credence::internal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::RecordedSink;

/// Arrays in memory; whoever reads beyond them fails the test.
class ArraysInMemory final : public ArrayFile {
 public:
  ArraysInMemory& add(const std::string& name, std::vector<std::uint64_t> dims,
                      std::vector<double> values = {}) {
    arrays_.push_back({name, "float64", std::move(dims)});
    values_.push_back(std::move(values));
    return *this;
  }
  const std::filesystem::path& path() const override { return path_; }
  const std::vector<ArrayShape>& arrays() const override { return arrays_; }
  void read(std::size_t i, std::uint64_t first, std::uint64_t count, std::vector<double>& out) override {
    const std::vector<double>& from = values_.at(i);
    ASSERT_LE(first + count, from.size()) << arrays_[i].name;
    out.assign(from.begin() + static_cast<std::ptrdiff_t>(first),
               from.begin() + static_cast<std::ptrdiff_t>(first + count));
  }

 private:
  std::filesystem::path path_ = "runs.npz";
  std::vector<ArrayShape> arrays_;
  std::vector<std::vector<double>> values_;
};

RecordedSink read_in_memory(ArraysInMemory file) {
  RecordedSink sink;
  read_arrays(file, sink);
  return sink;
}

void expect_array_error(const ArraysInMemory& file, const std::string& problem) {
  EXPECT_THAT([&] { read_in_memory(file); }, ::testing::ThrowsMessage<DataError>(HasSubstr(problem)));
}

const double kArrayNaN = std::numeric_limits<double>::quiet_NaN();

TEST(ArrayLog, times_are_of_each_run_or_of_all) {
  const auto read = [](std::vector<std::uint64_t> dims, std::vector<double> time) {
    ArraysInMemory file;
    file.add("innovation", {2, 3}, {1, 2, 3, 4, 5, 6}).add("S", {2, 3}, {1, 1, 1, 1, 1, 1});
    file.add("time", std::move(dims), std::move(time));
    return read_in_memory(std::move(file));
  };
  const RecordedSink of_all = read({3}, {0.5, 1.0, 1.5}), column = read({3, 1}, {0.5, 1.0, 1.5});
  for (const RecordedSink* const sink : {&of_all, &column}) {
    EXPECT_THAT(sink->runs.at(0).time_s, ElementsAre(0.5, 1.0, 1.5));
    EXPECT_THAT(sink->runs.at(1).time_s, ElementsAre(0.5, 1.0, 1.5));
  }
  EXPECT_THAT(read({2, 3}, {0, 1, 2, 10, 11, 12}).runs.at(1).time_s, ElementsAre(10, 11, 12));
  const RecordedSink other = read({4}, {0, 1, 2, 3});
  EXPECT_TRUE(other.runs.at(0).time_s.empty());
  EXPECT_THAT(other.said(), HasSubstr("time (4) is not used"));
  const RecordedSink back = read({2, 3}, {0, 1, 2, 10, 12, 11});
  EXPECT_TRUE(back.runs.at(1).time_s.empty());
  EXPECT_THAT(back.said(), HasSubstr("time is not used: it does not increase from step to step of run 1."));
}

TEST(ArrayLog, arrays_that_nobody_reads_are_named) {
  ArraysInMemory file;
  file.add("error", {1, 1, 1}, {1})
      .add("P", {1, 1, 1, 1}, {1})
      .add("innovaton", {1, 1, 1})
      .add("R_gps", {1, 1});
  EXPECT_EQ(read_in_memory(file).said(), "Not read: innovaton, R_gps.\n");
  file.add("names", {});  // as a reader says of names that are no text
  EXPECT_EQ(read_in_memory(file).said(), "Not read: innovaton, R_gps, names.\n");
  // Of a sensor whose innovations are not there.
  file.add("S", {1, 1, 1, 1}, {1}).add("R", {1, 1}, {1}).add("observation", {}, {1});
  EXPECT_EQ(read_in_memory(file).said(), "Not read: innovaton, R_gps, names, S, R, observation.\n");
}

TEST(ArrayLog, dimensions_the_other_way_round_are_told_how_to_turn) {
  ArraysInMemory file;
  expect_array_error(file.add("error", {4, 100, 20}).add("P", {4, 4, 100, 20}),
                     "in MATLAB by permute(error, [3 2 1]) and permute(P, [4 3 1 2])");
  ArraysInMemory one;
  expect_array_error(one.add("error", {4, 100}).add("P", {4, 4, 100}),
                     "permute(error, [2 1]) and permute(P, [3 1 2])");
  ArraysInMemory covariances;
  expect_array_error(covariances.add("error", {100, 4}).add("P", {4, 4, 100}),
                     "error (100, 4) and P (4, 4, 100): accepted are");
  expect_array_error(covariances, "P seems to be (n, n, steps): turn it, in MATLAB by permute(P, [3 1 2])");
}

TEST(ArrayLog, arrays_of_the_same_two_dimensions_are_told_how_they_are_read) {
  const auto said = [](std::uint64_t runs, std::uint64_t steps) {
    const std::vector<double> ones(runs * steps, 1.0);
    return read_in_memory(ArraysInMemory().add("error", {runs, steps}, ones).add("P", {runs, steps}, ones))
        .said();
  };
  EXPECT_EQ(
      said(3, 2),
      "error and P (3, 2) are read as 3 runs of 2 steps of one number; of 3 steps of 2 states P is (3, 2, "
      "2), with the variances on the diagonal.\n");
  EXPECT_EQ(said(3, 1),
            "error and P (3, 1) are read as 3 runs of 1 step of one number; one run of 3 steps is (1, 3).\n");
  EXPECT_EQ(said(1, 3), "") << "can be meant in one way alone";
  ArraysInMemory timed;
  timed.add("innovation", {3, 2}, {1, 2, 3, 4, 5, 6}).add("S", {3, 2}, {1, 1, 1, 1, 1, 1});
  expect_array_error(timed.add("time", {3}, {0, 1, 2}),
                     "time (3) seems to be of steps, and innovation and S");
}

TEST(ArrayLog, arrays_that_fit_either_way_round_are_told_how_they_are_read) {
  const auto said = [](std::vector<std::uint64_t> dims) {
    std::uint64_t size = 1;
    for (const std::uint64_t dim : dims) size *= dim;
    ArraysInMemory file;
    file.add("error", dims, std::vector<double>(size, 1.0));
    const std::uint64_t n = dims.back();
    std::vector<double> P;
    for (std::uint64_t i = 0; i < size * n; ++i) P.push_back(i % n == i / n % n ? 1.0 : 0.0);
    dims.push_back(n);
    return read_in_memory(file.add("P", dims, P)).said();
  };
  EXPECT_EQ(
      said({3, 3}),
      "error (3, 3) and P (3, 3, 3) fit two readings: taken are 3 steps of 3 components, (steps, n) and "
      "(steps, n, n). Where steps stand last, turn them, in MATLAB by permute(error, [2 1]) and permute(P, "
      "[3 1 2]), in NumPy by error.T and P.T.\n");
  EXPECT_THAT(said({2, 2, 2}),
              HasSubstr("taken are 2 runs of 2 steps of 2 components, (runs, steps, n) and"));
  EXPECT_EQ(said({4, 3}), "");
  EXPECT_EQ(said({2, 3, 3}), "") << "as (n, steps, runs) P would be (2, 2, 3, 3)";
}

TEST(ArrayLog, rows_of_every_run_hold_their_errors_covariances_and_innovations) {
  std::vector<double> error, P, nu, S;
  for (int k = 0; k < 6; ++k) {  // 2 runs of 3 steps
    error.insert(error.end(), {1.0 * k, -1.0 * k});
    P.insert(P.end(), {1.0 + k, 0.5, 0.5, 2.0 + k});
    nu.push_back(0.25 * k);
    S.push_back(10.0 + k);
  }
  const RecordedSink sink = read_in_memory(ArraysInMemory()
                                               .add("S_gps", {2, 3}, S)
                                               .add("P", {2, 3, 2, 2}, P)
                                               .add("weather", {7}, {})
                                               .add("innovation_gps", {2, 3}, nu)
                                               .add("error", {2, 3, 2}, error));
  ASSERT_EQ(sink.runs.size(), 2U);
  EXPECT_THAT(sink.runs[0].layout.states, ElementsAre("x1", "x2"));
  EXPECT_TRUE(sink.runs[0].layout.has_truth);
  EXPECT_EQ(sink.runs[0].layout.sensors, (std::vector<Sensor>{{.name = "gps", .dim = 1, .piece = 1}}));
  for (int k = 0; k < 6; ++k) {
    const Step& step = sink.runs[static_cast<std::size_t>(k / 3)].steps.at(static_cast<std::size_t>(k % 3));
    EXPECT_EQ(step.step, k % 3 + 1);
    EXPECT_EQ(step.line, k + 1);
    EXPECT_EQ(step.error, Eigen::Vector2d(k, -k));
    EXPECT_EQ(step.P, (Matrix(2, 2) << 1 + k, 0.5, 0.5, 2 + k).finished());
    EXPECT_EQ(step.innovations.at(0).nu, Vector::Constant(1, 0.25 * k));
    EXPECT_EQ(step.innovations[0].S, Matrix::Constant(1, 1, 10.0 + k));
    EXPECT_EQ(step.problem, "");
  }
}

TEST(ArrayLog, one_run_may_do_without_the_dimension_of_runs) {
  const RecordedSink sink =
      read_in_memory(ArraysInMemory().add("error", {3, 1}, {1, 2, 3}).add("P", {3, 1, 1}, {4, 5, 6}));
  ASSERT_EQ(sink.runs.size(), 1U);
  EXPECT_EQ(sink.runs[0].steps.at(2).P(0, 0), 6.0);
}

TEST(ArrayLog, what_is_not_a_number_is_not_there) {
  const RecordedSink sink = read_in_memory(
      ArraysInMemory()
          .add("error", {1, 2, 3}, {1, kArrayNaN, 3, kArrayNaN, kArrayNaN, kArrayNaN})
          .add("P", {1, 2, 3, 3},
               {1, kArrayNaN, 7, kArrayNaN, kArrayNaN, kArrayNaN, 7, kArrayNaN, 9, 0, 0, 0, 0, 0, 0, 0, 0, 0})
          .add("innovation", {1, 2, 2}, {kArrayNaN, 5, kArrayNaN, kArrayNaN})
          .add("S", {1, 2, 2, 2}, {kArrayNaN, kArrayNaN, kArrayNaN, 6, 0, 0, 0, 0}));
  const std::vector<Step>& steps = sink.runs.at(0).steps;
  EXPECT_THAT(steps.at(0).states, ElementsAre(0, 2));
  EXPECT_EQ(steps[0].error, Eigen::Vector2d(1, 3));
  EXPECT_EQ(steps[0].P, (Matrix(2, 2) << 1, 7, 7, 9).finished());
  EXPECT_EQ(steps[0].innovations.at(0).nu, Vector::Constant(1, 5.0));
  EXPECT_EQ(steps[0].innovations[0].S, Matrix::Constant(1, 1, 6.0));
  EXPECT_EQ(steps[0].problem, "");
  EXPECT_TRUE(steps.at(1).states.empty());
  EXPECT_EQ(steps[1].innovations.at(0).nu.size(), 0);
}

TEST(ArrayLog, an_asymmetric_covariance_is_a_problem_of_its_row_alone) {
  const RecordedSink sink =
      read_in_memory(ArraysInMemory()
                         .add("error", {3, 2}, std::vector<double>(6, 1.0))
                         .add("P", {3, 2, 2}, {4, 1, 1, 4, 4, 1, 1.001, 4, 4, 1, 1.00001, 4}));
  const std::vector<Step>& steps = sink.runs.at(0).steps;
  EXPECT_EQ(steps.at(0).problem, "");
  EXPECT_EQ(steps.at(1).problem, "a covariance is not symmetric");
  EXPECT_EQ(steps.at(2).problem, "") << "as float rounds";
}

TEST(ArrayLog, a_covariance_that_is_no_number_is_called_so) {
  const RecordedSink sink =
      read_in_memory(ArraysInMemory().add("error", {1, 2}, {1, 1}).add("P", {1, 2, 2}, {kNaN, 0, 0, 1}));
  EXPECT_EQ(sink.runs.at(0).steps.at(0).problem, "a covariance is not finite");
}

// More numbers than are read at once, 2^17.
TEST(ArrayLog, long_runs_are_read_in_pieces) {
  constexpr std::uint64_t kRunsOfPieces = 2, kStepsOfPieces = 40'000;
  std::vector<double> error, P;
  for (std::uint64_t k = 0; k < kRunsOfPieces * kStepsOfPieces; ++k) {
    const auto value = static_cast<double>(k);
    error.insert(error.end(), {value, -value});
    P.insert(P.end(), {value + 1.0, 0.0, 0.0, value + 2.0});
  }
  const RecordedSink sink = read_in_memory(ArraysInMemory()
                                               .add("error", {kRunsOfPieces, kStepsOfPieces, 2}, error)
                                               .add("P", {kRunsOfPieces, kStepsOfPieces, 2, 2}, P));
  std::size_t wrong = 0, k = 0;
  for (const RecordedSink::Run& run : sink.runs) {
    for (const Step& step : run.steps) {
      const auto value = static_cast<double>(k++);
      wrong += step.error != Eigen::Vector2d(value, -value) || step.P(1, 1) != value + 2.0 ? 1U : 0U;
    }
  }
  EXPECT_EQ(k, kRunsOfPieces * kStepsOfPieces);
  EXPECT_EQ(wrong, 0U);
}

TEST(ArrayLog, nis_alone_has_the_dimension_of_its_name) {
  const RecordedSink sink = read_in_memory(ArraysInMemory()
                                               .add("nis_2", {2, 2}, {8, kArrayNaN, -1, 0})
                                               .add("nis_left_gps_3", {2, 2}, {3, 3, 3, 12}));
  EXPECT_FALSE(sink.runs.at(0).layout.has_truth);
  EXPECT_EQ(sink.runs[0].layout.sensors,
            (std::vector<Sensor>{{.name = "", .dim = 2, .piece = 2, .nis_alone = true},
                                 {.name = "left_gps", .dim = 3, .piece = 3, .nis_alone = true}}));
  EXPECT_NEAR(sink.runs[0].steps.at(0).innovations.at(0).nu[0], 8.0, 1e-12);
  EXPECT_EQ(sink.runs[0].steps.at(1).innovations.at(0).nu.size(), 0) << "silent";
  EXPECT_EQ(sink.runs[1].steps.at(0).problem, "a NIS is negative");
  EXPECT_EQ(sink.runs[1].steps.at(1).problem, "");
  EXPECT_EQ(sink.runs[1].steps[1].innovations.at(0).nu, Vector::Zero(1)) << "0 is a NIS";
  EXPECT_NEAR(sink.runs[1].steps[1].innovations.at(1).nu[0], 12.0, 1e-12);
}

TEST(ArrayLog, an_innovation_may_hold_several_observations) {
  const auto sensor = [](const std::vector<std::uint64_t>& dims, std::vector<double> value) {
    return read_in_memory(ArraysInMemory()
                              .add("innovation_map", {1, 1, 6}, std::vector<double>(6, 1.0))
                              .add("S_map", {1, 1, 6, 6}, std::vector<double>(36, 1.0))
                              .add("observation_map", dims, std::move(value)))
        .runs.at(0)
        .layout.sensors.at(0);
  };
  EXPECT_EQ(sensor({}, {2}).piece, 2);
  EXPECT_EQ(sensor({1, 1}, {6}).piece, 6);
  for (const double value : {0.0, 4.0, 7.0, 1.5, -2.0, kArrayNaN})
    EXPECT_THROW(sensor({}, {value}), DataError) << value;
  EXPECT_THROW(sensor({2}, {2, 2}), DataError);
  EXPECT_THROW(sensor({0}, {}), DataError);
}

TEST(ArrayLog, arrays_that_do_not_belong_together_are_named_with_their_shapes) {
  const auto arrays = [] { return ArraysInMemory(); };
  expect_array_error(arrays(),
                     "runs.npz: holds nothing to judge: error with P, or innovation with S, or nis_DIM; "
                     "its arrays are none");
  expect_array_error(arrays().add("x", {2, 3}), "its arrays are x (2, 3)");
  expect_array_error(arrays().add("error", {2, 3}), "array P is missing beside error");
  expect_array_error(arrays().add("P", {2, 3, 2, 2}), "array error is missing beside P");
  expect_array_error(arrays().add("innovation_a", {3, 2}).add("S", {3, 2, 2}),
                     "array S_a is missing beside innovation_a");
  using Dims = std::vector<std::uint64_t>;
  for (const auto& [error, P] : std::vector<std::pair<Dims, Dims>>{{{2, 3, 2}, {2, 3, 2, 3}},
                                                                   {{2, 3, 2}, {2, 3, 3, 3}},
                                                                   {{2, 3, 2}, {2, 4, 2, 2}},
                                                                   {{2, 3, 2}, {3, 3, 2, 2}},
                                                                   {{2, 3, 2}, {2, 3, 2}},
                                                                   {{2, 3, 2}, {3, 2, 2}},
                                                                   {{6}, {6}},
                                                                   {{}, {}},
                                                                   {{1, 2, 3, 2}, {1, 2, 3, 2, 2}}}) {
    expect_array_error(arrays().add("error", error).add("P", P), "accepted are (runs, steps, n)");
  }
  expect_array_error(arrays().add("error", {2, 0, 2}).add("P", {2, 0, 2, 2}), "1 to 10000000 steps");
  expect_array_error(arrays().add("error", {2, 3, 0}).add("P", {2, 3, 0, 0}), "1 to 10000 components");
  expect_array_error(arrays().add("error", {1, 10'000'001, 1}).add("P", {1, 10'000'001, 1, 1}),
                     "1 to 10000000 steps");
  expect_array_error(arrays().add("error", {1, 1, 10'001}).add("P", {1, 1, 10'001, 10'001}),
                     "1 to 10000 components");
  const auto state = arrays().add("error", {2, 3}).add("P", {2, 3});
  expect_array_error(ArraysInMemory(state).add("innovation", {2, 4}).add("S", {2, 4}),
                     "innovation (2, 4) and error (2, 3): other runs or steps");
  expect_array_error(ArraysInMemory(state).add("nis_1", {1, 3}),
                     "nis_1 (1, 3) and error (2, 3): other runs or steps");
  for (const Dims& dims : {Dims{}, Dims{1, 2, 3}, Dims{2, 0}, Dims{0}, Dims{1, 10'000'001}}) {
    expect_array_error(arrays().add("nis_2", dims), "accepted are (runs, steps) or (steps)");
  }
  expect_array_error(arrays().add("nis_0", {3}), "of innovations of 1 to 10000 components");
  expect_array_error(arrays().add("nis_gps_10001", {3}), "of innovations of 1 to 10000 components");
}

TEST(ArrayLog, an_estimate_and_its_truth_are_an_error_of_wrapped_angles) {
  ArraysInMemory file;
  file.add("estimate", {2, 2}, {1.0, 3.0, 2.0, kArrayNaN})
      .add("truth", {2, 2}, {0.5, -3.0, 1.0, 0.0})
      .add("P", {2, 2, 2}, {1, 0, 0, 4, 1, 0, 0, 4})
      .add("names", {2, 7}, {120, 0, 0, 0, 0, 0, 0, 121, 58, 97, 110, 103, 108, 101});
  const RecordedSink sink = read_in_memory(file);
  EXPECT_THAT(sink.said(), ::testing::Not(HasSubstr("Not read")));
  const std::vector<Step>& steps = sink.runs.at(0).steps;
  ASSERT_EQ(steps.size(), 2U);
  EXPECT_EQ(steps[0].error, Eigen::Vector2d(0.5, wrap_angle(6.0)));
  EXPECT_EQ(steps[0].estimate, Eigen::Vector2d(1.0, 3.0));
  EXPECT_THAT(steps[1].states, ElementsAre(0));
  EXPECT_EQ(steps[1].error, Vector::Constant(1, 1.0));
  EXPECT_EQ(steps[1].P, Matrix::Constant(1, 1, 1.0));

  expect_array_error(ArraysInMemory().add("estimate", {2, 2}).add("truth", {3, 2}).add("P", {2, 2, 2}),
                     "estimate (2, 2) and truth (3, 2): other dimensions");
  expect_array_error(ArraysInMemory().add("estimate", {2, 2}).add("P", {2, 2, 2}),
                     "array error is missing beside P (estimate less truth, or these two)");
}

TEST(ArrayLog, names_tell_units) {
  const auto units_of = [](const std::vector<double>& letters) {
    ArraysInMemory file;
    file.add("error", {1, 2}, {0.5, 1.0}).add("P", {1, 2, 2}, {1, 0, 0, 4}).add("names", {2, 5}, letters);
    const RecordedSink sink = read_in_memory(file);
    return std::pair(sink.runs.at(0).layout.states, sink.runs.at(0).layout.units);
  };
  const auto [states, units] = units_of({'a', '[', 'V', ']', 0, 'b', 0, 0, 0, 0});
  EXPECT_THAT(states, ElementsAre("a", "b"));
  EXPECT_THAT(units, ElementsAre("V", ""));
  EXPECT_TRUE(units_of({'a', 0, 0, 0, 0, 'b', 0, 0, 0, 0}).second.empty());
}

TEST(ArrayLog, an_error_of_an_angle_is_wrapped_too) {
  ArraysInMemory file;
  file.add("error", {2, 2}, {0.5, 6.0, 7.0, 0.25})
      .add("P", {2, 2, 2}, {1, 0, 0, 4, 1, 0, 0, 4})
      .add("names", {2, 7}, {120, 0, 0, 0, 0, 0, 0, 121, 58, 97, 110, 103, 108, 101});
  const RecordedSink sink = read_in_memory(file);
  const std::vector<Step>& steps = sink.runs.at(0).steps;
  ASSERT_EQ(steps.size(), 2U);
  EXPECT_EQ(steps[0].error, Eigen::Vector2d(0.5, wrap_angle(6.0)));
  EXPECT_EQ(steps[1].error, Eigen::Vector2d(7.0, 0.25));
}

// (steps, runs) for (runs, steps): a drawn series goes down each column.
TEST(ArrayLog, swapped_axes_are_told) {
  constexpr std::size_t kRuns = 30, kSteps = 60;
  std::mt19937_64 generator(4);
  std::normal_distribution<double> normal;
  std::vector<double> error(kRuns * kSteps);
  for (std::size_t i = 0; i < error.size(); ++i)
    error[i] = i < kRuns ? normal(generator) : 0.9 * error[i - kRuns] + std::sqrt(0.19) * normal(generator);
  const std::vector<double> P(error.size(), 1.0);
  ArraysInMemory swapped;
  swapped.add("error", {kSteps, kRuns, 1}, error).add("P", {kSteps, kRuns, 1, 1}, P);
  EXPECT_THAT(read_in_memory(swapped).said(), HasSubstr("axes of the arrays look swapped"));
  std::vector<double> turned(error.size());
  for (std::size_t i = 0; i < error.size(); ++i) turned[i % kRuns * kSteps + i / kRuns] = error[i];
  ArraysInMemory right;
  right.add("error", {kRuns, kSteps, 1}, turned).add("P", {kRuns, kSteps, 1, 1}, P);
  EXPECT_THAT(read_in_memory(right).said(), ::testing::Not(HasSubstr("swapped")));
}

TEST(ArrayLog, an_estimate_beside_the_error_leaves_the_error_as_it_is) {
  ArraysInMemory file;
  file.add("error", {2, 1}, {0.25, 0.5}).add("P", {2, 1, 1}, {1, 1});
  file.add("estimate", {2, 1}, {7.0, 8.0}).add("truth", {2, 1}, {6.0, 6.0});
  const RecordedSink sink = read_in_memory(file);
  EXPECT_EQ(sink.said(), "Not read: truth.\n");
  EXPECT_EQ(sink.runs.at(0).steps.at(1).error[0], 0.5);
  EXPECT_EQ(sink.runs.at(0).steps.at(1).estimate[0], 8.0);
}

TEST(ArrayLog, names_are_told_from_others) {
  for (const char* name : {"error", "estimate", "truth", "P", "innovation", "S", "innovation_a", "S_a_b",
                           "nis_3", "nis_gps_3", "observation", "observation_a"}) {
    EXPECT_TRUE(is_log_array(name)) << name;
  }
  for (const char* name : {"", "errors", "p", "innovations", "Sx", "nis", "nis_", "nis_gps", "nis_2x",
                           "nis_-1", "nis_gps_99999999999999999999", "true"}) {
    EXPECT_FALSE(is_log_array(name)) << name;
  }
}

// Of every place of a box: the first index runs fastest in the one order, the last in the other.
TEST(ArrayLog, places_of_the_two_orders_are_those_of_the_same_indices) {
  const std::vector<std::uint64_t> dims = {3, 1, 4, 5};
  std::uint64_t k = 0;
  for (std::uint64_t a = 0; a < 3; ++a) {
    for (std::uint64_t c = 0; c < 4; ++c) {
      for (std::uint64_t d = 0; d < 5; ++d) EXPECT_EQ(column_major_place(dims, k++), a + 3 * c + 12 * d);
    }
  }
  EXPECT_EQ(column_major_place({}, 0), 0U);
  EXPECT_EQ(column_major_place({7}, 6), 6U);
}

TEST(ArrayLog, a_list_counts_rows_without_the_dimensions_of_one) {
  const LogContents contents = list_arrays(ArraysInMemory()
                                               .add("error", {2, 3, 4})
                                               .add("P", {2, 3, 4, 4})
                                               .add("innovation_a", {2, 3, 1})
                                               .add("S_a", {2, 3, 1, 1})
                                               .add("nis_b_2", {2, 3})
                                               .add("other", {})
                                               .add("zero", {0, 5}));
  const char* const uses[] = {"error", "covariance", "innovations", "covariance", "NIS alone", "", ""};
  ASSERT_EQ(contents.topics.size(), 7U);
  for (std::size_t i = 0; i < 7; ++i) {
    EXPECT_EQ(contents.topics[i].use, uses[i]);
    EXPECT_EQ(contents.topics[i].count, i < 5 ? 6 : 0) << contents.topics[i].name;
    EXPECT_EQ(contents.topics[i].covariance, i == 1 || i == 3);
  }
  EXPECT_EQ(contents.topics[0].type, "float64 (2, 3, 4)");
  EXPECT_EQ(contents.topics[5].type, "float64");
}

TEST(ArrayLog, two_arrays_of_one_sensor_are_refused) {
  expect_array_error(ArraysInMemory().add("nis_2", {2, 3}).add("nis_3", {2, 3}),
                     "nis_2 and nis_3 are both of the sensor without a name");
  expect_array_error(
      ArraysInMemory().add("innovation_gps", {2, 3}).add("S_gps", {2, 3}).add("nis_gps_1", {2, 3}),
      "innovation_gps and nis_gps_1 are both of the sensor 'gps'");
}

TEST(ArrayLog, a_name_that_a_terminal_would_obey_is_refused) {
  const std::string problem = "runs.npz: sensor 'gps?[31m': its name holds a control character";
  expect_array_error(
      ArraysInMemory().add("innovation_gps\x1b[31m", {1, 1, 1}, {1}).add("S_gps\x1b[31m", {1, 1, 1, 1}, {1}),
      problem);
  expect_array_error(ArraysInMemory().add("nis_gps\x1b[31m_2", {1, 1}, {1}), problem);
}

TEST(ArrayLog, no_runs_are_refused) {
  expect_array_error(ArraysInMemory().add("error", {0, 5, 2}).add("P", {0, 5, 2, 2}), "one or more runs");
  expect_array_error(ArraysInMemory().add("nis_2", {0, 5}), "accepted are");
}

}  // namespace
}  // namespace credence::internal
