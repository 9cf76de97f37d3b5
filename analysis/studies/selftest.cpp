#include "analysis/studies/selftest.h"

#include <fmt/format.h>

#include <stdexcept>

#include "analysis/studies/selftest_calibration.h"
#include "analysis/studies/selftest_filter.h"
#include "analysis/studies/selftest_power.h"

namespace credence::internal {
namespace {

constexpr double kFamilyLevel = 1e-3;
constexpr double kDirectionWanted = 0.99;

}  // namespace

void judge_selftest(SelftestResult& result) {
  const double rows = static_cast<double>(result.calibration.size() + 3 * result.wrong_filters.size());
  result.family_level = kFamilyLevel;
  result.interval_confidence = 1.0 - kFamilyLevel / rows;
  const auto measure = [&](StudyShare& share) {
    share.interval = clopper_pearson(share.count, result.interval_confidence);
  };
  result.ok = true;
  for (CalibrationRow& row : result.calibration) {
    measure(row.measured);
    row.ok = row.measured.interval.lower <= row.nominal &&
             (row.exactness == Exactness::conservative || row.nominal <= row.measured.interval.upper);
    result.ok = result.ok && row.ok;
  }
  for (WrongFilterResult& filter : result.wrong_filters) {
    measure(filter.caught);
    measure(filter.named);
    for (PowerRow& row : filter.power) measure(row.measured);
    filter.ok = filter.caught.interval.upper >= filter.caught_wanted &&
                filter.caught.interval.lower <= filter.caught_most &&
                filter.named.interval.upper >= filter.named_wanted;
    if (filter.direction) {
      measure(filter.direction_right);
      filter.ok = filter.ok && filter.direction_right.interval.upper >= kDirectionWanted;
    }
    result.ok = result.ok && filter.ok;
  }
  for (NaiveRow& row : result.naive) measure(row.measured);
  for (SavingResult& saving : result.savings) measure(saving.caught);
}

SelftestResult run_selftest(const SelftestOptions& options) {
  if (options.studies < 100) {
    throw std::invalid_argument(fmt::format("studies = {} must be >= 100", options.studies));
  }
  if (options.threads < 0) {
    throw std::invalid_argument(fmt::format("threads = {} must be >= 0", options.threads));
  }
  SelftestResult result{.seed = options.seed,
                        .studies = options.studies,
                        .runs = SyntheticFilter::kRuns,
                        .steps = SyntheticFilter::kSteps};
  SelftestWorkers workers(options, calibration_work(options) + power_work(options));
  calibrate(options, workers, result);
  measure_power(options, workers, result);
  result.complete = !workers.stopped();
  if (result.complete) judge_selftest(result);
  return result;
}

}  // namespace credence::internal
