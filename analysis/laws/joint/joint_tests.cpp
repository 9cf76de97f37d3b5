#include "analysis/laws/joint/joint_tests.h"

#include <algorithm>
#include <cmath>

#include "analysis/laws/joint/multiple_tests.h"
#include "analysis/laws/require.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

// All tests of all families with the weight of each.
struct FlatTests {
  std::vector<double> p_values, weights;
};

FlatTests flatten(std::span<const TestFamily> families) {
  FlatTests flat;
  for (const TestFamily& family : families) {
    require_positive("weight", family.weight);
    const auto with_data = std::ranges::count_if(
        family.tests, [](const DirectedTest& test) { return !std::isnan(test.p_value); });
    for (const DirectedTest& test : family.tests) {
      flat.p_values.push_back(test.p_value);
      flat.weights.push_back(family.weight / static_cast<double>(std::max<std::ptrdiff_t>(1, with_data)));
    }
  }
  return flat;
}

}  // namespace

JointTests join_tests(std::span<const TestFamily> families) {
  const FlatTests flat = flatten(families);
  const std::vector<double> adjusted = weighted_holm(flat.p_values, flat.weights);
  JointTests joint;
  bool any = false;
  std::size_t i = 0;
  for (std::size_t f = 0; f < families.size(); ++f) {
    std::vector<double>& own = joint.adjusted.emplace_back();
    for (std::size_t t = 0; t < families[f].tests.size(); ++t, ++i) {
      own.push_back(adjusted[i]);
      if (std::isnan(adjusted[i])) continue;
      double& least = families[f].tests[t].departure == Departure::optimistic ? joint.optimistic_p_value
                                                                              : joint.pessimistic_p_value;
      least = std::min(least, adjusted[i]);
      any = true;
    }
  }
  joint.p_value = any ? std::min(joint.optimistic_p_value, joint.pessimistic_p_value) : kNaN;
  return joint;
}

}  // namespace credence::internal
