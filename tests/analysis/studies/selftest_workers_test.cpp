#include "analysis/studies/selftest_workers.h"

#include <gtest/gtest.h>

#include "analysis/studies/selftest_tests.h"
#include "montecarlo/engine/shared_tasks.h"
#include "tests/montecarlo/engine/thread_ranks.h"

namespace credence::internal {
namespace {

TEST(SelftestWorkers, ResultsOfOtherRanksAreThoseOfOne) {
  constexpr std::int64_t kStudies = 200;
  on_ranks(3, [&](ThreadRanks& ranks) {
    SelftestOptions options{.threads = 1, .ranks = &ranks};
    std::int64_t told = 0;
    options.progress = [&](std::int64_t done, std::int64_t) { told = done; };
    SelftestWorkers workers(options, kStudies);
    std::vector<std::vector<TestResult>> tests(kStudies);
    std::vector<double> p_values(kStudies);
    try {
      workers.for_each(
          kStudies,
          [&](std::int64_t i) {
            const auto at = static_cast<std::size_t>(i);
            p_values[at] = 1.0 / static_cast<double>(i + 1);
            tests[at].assign(at % 3, {"test " + std::to_string(i), Exactness::conservative, p_values[at]});
            if (!is_helper(&ranks)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
          },
          tests, p_values);
    } catch (const RanksEnded&) {
    }
    finish_ranks(ranks);
    EXPECT_EQ(workers.stopped(), is_helper(&ranks));
    if (is_helper(&ranks)) return;
    EXPECT_EQ(told, kStudies);
    for (std::size_t i = 0; i < p_values.size(); ++i) {
      EXPECT_EQ(p_values[i], 1.0 / static_cast<double>(i + 1));
      ASSERT_EQ(tests[i].size(), i % 3) << i;
      for (const TestResult& test : tests[i]) {
        EXPECT_EQ(test.name, "test " + std::to_string(i));
        EXPECT_EQ(test.exactness, Exactness::conservative);
        EXPECT_EQ(test.p_value, p_values[i]);
      }
    }
  });
}

}  // namespace
}  // namespace credence::internal
