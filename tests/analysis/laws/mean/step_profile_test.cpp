#include "analysis/laws/mean/step_profile.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

#include "tests/analysis/evidence/synthetic_studies.h"

namespace credence::internal {
namespace {

/// Squares of Student's t with five dof, of mean `mean_at(k)`, times a scale of each run, of mean 1.
template <typename MeanAt>
std::vector<std::vector<double>> heavy_runs(std::size_t runs, std::size_t steps, std::mt19937_64& generator,
                                            MeanAt mean_at) {
  std::student_t_distribution<double> student(5.0);
  std::uniform_real_distribution<double> uniform(0.5, 1.5);
  std::vector<std::vector<double>> all(runs, std::vector<double>(steps));
  for (std::vector<double>& run : all) {
    const double scale = uniform(generator);
    for (std::size_t k = 0; k < steps; ++k)
      run[k] = scale * mean_at(k) * 0.6 * std::pow(student(generator), 2);
  }
  return all;
}

TEST(StepProfile, HasItsLevelWhateverTheLaw) {
  std::mt19937_64 generator(91);
  constexpr int kStudies = 2000;
  int of_runs = 0, of_stretches = 0;
  for (int study = 0; study < kStudies; ++study) {
    const auto flat = heavy_runs(20, 40, generator, [](std::size_t) { return 1.0; });
    of_runs += step_profile_p_value(flat) <= 0.05;
    std::vector<std::vector<double>> few = heavy_runs(3, 400, generator, [](std::size_t) { return 1.0; });
    few[1].resize(300);
    of_stretches += step_profile_p_value(few, 7) <= 0.05;
  }
  const double most = 0.05 + 5.0 * test::binomial_standard_error(0.05, kStudies);
  EXPECT_LE(of_runs / 2000.0, most);
  EXPECT_GE(of_runs, 20);
  EXPECT_LE(of_stretches / 2000.0, most);
  EXPECT_GE(of_stretches, 20);
}

TEST(StepProfile, SeesStepsThatAreWrongWhereTheMeanIsRight) {
  std::mt19937_64 generator(92);
  const auto wave = [](std::size_t k) { return 1.0 + 0.9 * std::sin(0.3 * static_cast<double>(k)); };
  int of_runs = 0, of_stretches = 0;
  for (int study = 0; study < 100; ++study) {
    of_runs += step_profile_p_value(heavy_runs(60, 80, generator, wave)) <= 0.05;
    of_stretches += step_profile_p_value(heavy_runs(4, 4000, generator, wave), 5) <= 0.05;
  }
  EXPECT_GE(of_runs, 95);
  EXPECT_GE(of_stretches, 90);  // numpy: 97.7 %
}

// Two runs of two steps in ten stretches of one: of each half s = w x with w of the other.
TEST(StepProfile, ByHand) {
  std::vector<double> first(10, 2.0), second(10, 1.5);
  second[0] = 0.0;
  // Nine products of 0.5 and one of −1: mean 0.35, variance 0.225, t = 0.35/0.15 of nine dof.
  EXPECT_NEAR(step_profile_p_value(std::vector<std::vector<double>>{first, second}, 10), 0.0445, 5e-4);
}

TEST(StepProfile, TooLittleData) {
  const std::vector<double> run(100, 1.0);
  EXPECT_TRUE(std::isnan(step_profile_p_value(std::vector<std::vector<double>>(19, run))));
  EXPECT_TRUE(std::isnan(step_profile_p_value(std::vector<std::vector<double>>(1, run), 50)));
  EXPECT_EQ(step_profile_p_value(std::vector<std::vector<double>>(20, run)), 1.0) << "all are right";
}

}  // namespace
}  // namespace credence::internal
