#pragma once

#include <span>
#include <vector>

/// @file
/// Several families of tests, each with its direction, joined into one word at one level.
///
/// All p-values, NEES and NIS, run means, steps, blocks, are one family of hypotheses under the weighted
/// procedure of S. Holm, "A simple sequentially rejective multiple test procedure", Scand. J. Stat. 6 (1979):
/// P(any true hypothesis is rejected) ≤ α under any dependence. It is the closed test (Marcus, Peritz,
/// Gabriel, Biometrika 63, 1976) whose intersections are tested by weighted Bonferroni, and rejects anything
/// iff weighted Bonferroni does: a consistent filter is called anything else with probability ≤ α. So each
/// rejection may be told with its own direction and span, and directions that are both rejected are both real
/// ("mixed"): never "pessimistic, hence safe" while an optimistic test rejects.

namespace credence::internal {

/// What a small p-value speaks for.
enum class Departure {
  optimistic,   ///< the statistic is too large: P is too small
  pessimistic,  ///< too small: P is too large
};

/// One hypothesis. A p-value of a direction is one-sided; NaN, a test without data, is no member.
struct DirectedTest {
  Departure departure = Departure::optimistic;
  double p_value = 1.0;
};

/// Tests that share one part of the level, in equal parts of it among those with data.
struct TestFamily {
  double weight = 1.0;
  std::span<const DirectedTest> tests;
};

/// What they say together.
struct JointTests {
  std::vector<std::vector<double>> adjusted;  ///< p-values as the families; ≤ α: rejected
  double p_value = 1.0;                       ///< the least adjusted; NaN without any test
  double optimistic_p_value = 1.0;            ///< the least adjusted of this departure; 1 without one
  double pessimistic_p_value = 1.0;

  bool optimistic(double level) const { return optimistic_p_value <= level; }
  bool pessimistic(double level) const { return pessimistic_p_value <= level; }
};

/// Joins the families. A family without data leaves its weight to the others, which is valid as long as what
/// has data does not depend on the errors. Throws std::invalid_argument for a weight that is not finite and
/// positive or a p-value outside [0, 1].
JointTests join_tests(std::span<const TestFamily> families);

}  // namespace credence::internal
