#include "analysis/studies/selftest_power.h"

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "analysis/studies/selftest_families.h"
#include "analysis/studies/selftest_study.h"
#include "analysis/studies/selftest_tests.h"

namespace credence::internal {
namespace {

constexpr int kWrongBlocks = 4;  // of kRuns runs each, in a study of a wrong filter
constexpr double kCaughtWanted = 0.95;
constexpr double kNamedWanted = 0.8;
constexpr double kAccusedMost = 0.1;  // of filters whose covariance is right

struct ExpectedCause {
  Defect defect;
  Cause cause;
  std::optional<Verdict> direction = {};
  bool covariance_right = false;
};

constexpr ExpectedCause kWrongFilters[] = {
    {Defect::process_noise_too_small, Cause::process_noise_too_small, Verdict::optimistic},
    {Defect::process_noise_too_large, Cause::process_noise_too_large, Verdict::pessimistic},
    {Defect::measurement_noise_too_small, Cause::measurement_noise_too_small, Verdict::optimistic},
    {Defect::measurement_noise_too_large, Cause::measurement_noise_too_large, Verdict::pessimistic},
    {Defect::wrong_dof, Cause::wrong_dof, Verdict::pessimistic},
    {Defect::unwrapped_angle, Cause::unwrapped_angle},
    {Defect::dropped_cross_covariance, Cause::cross_covariance},
    {Defect::coloured_noise, Cause::coloured_noise},
    {Defect::initial_covariance, Cause::initial_covariance, Verdict::optimistic},
    {Defect::gated_innovations, Cause::gated_innovations, {}, true},
    {Defect::biased_measurement, Cause::bias},
    {Defect::heavy_tails, Cause::heavy_tails, {}, true},
    {Defect::shared_prior, Cause::sequential_sensors, {}, true},
};

constexpr Defect kClearCases[] = {Defect::process_noise_too_small, Defect::process_noise_too_large,
                                  Defect::measurement_noise_too_small, Defect::measurement_noise_too_large};

std::int64_t studies_of_a_wrong_filter(const SelftestOptions& options) { return options.studies / 10; }
std::int64_t saving_studies(const SelftestOptions& options) { return options.studies / 20; }

WrongFilterResult try_wrong_filter(const SelftestOptions& options, SelftestWorkers& workers,
                                   ExpectedCause wrong) {
  const SyntheticFilter filter(setup_of(wrong.defect));
  const NoiseSource noise(options.seed, SelftestNoise::kWrong + static_cast<std::uint64_t>(wrong.defect));
  const std::int64_t studies = studies_of_a_wrong_filter(options);
  std::vector<std::vector<TestResult>> all(static_cast<std::size_t>(studies));
  std::vector<std::optional<Cause>> causes(static_cast<std::size_t>(studies));
  std::vector<Verdict> words(static_cast<std::size_t>(studies));
  workers.for_each(
      studies,
      [&](std::int64_t i) {
        const std::size_t at = static_cast<std::size_t>(i);
        CalibrationRecorder recorder;
        const Evidence evidence =
            synthetic_evidence(filter, noise, i * kWrongBlocks, kWrongBlocks * SyntheticFilter::kRuns,
                               SyntheticFilter::kSteps, &recorder);
        const auto [calibration, judgement] = judge_rows(evidence, recorder, 1.0 - kSelftestPowerLevel);
        all[at] = shipped_tests(evidence, judgement, calibration);
        words[at] = judgement.word.verdict;
        if (!judgement.causes.empty()) causes[at] = judgement.causes.front().cause;
      },
      all, causes, words);
  WrongFilterResult result{.name = std::string(to_string(wrong.defect)),
                           .caught_wanted = wrong.covariance_right ? 0.0 : kCaughtWanted,
                           .caught_most = wrong.covariance_right ? kAccusedMost : 1.0,
                           .direction = wrong.direction,
                           .expected = wrong.cause,
                           .named_wanted = kNamedWanted};
  if (workers.stopped()) return result;
  for (const AlarmCount& count : count_alarms(all, kSelftestPowerLevel))
    result.power.push_back({count.test->name, share_of(count.alarms, studies)});
  const std::int64_t caught = std::ranges::count_if(words, is_inconsistent);
  result.caught = share_of(caught, studies);
  if (wrong.direction) result.direction_right = share_of(std::ranges::count(words, *wrong.direction), caught);
  std::map<Cause, std::int64_t> counts;
  for (const auto& cause : causes) {
    if (cause) ++counts[*cause];
  }
  for (const auto& [cause, count] : counts) {
    result.causes.push_back({cause, static_cast<double>(count) / static_cast<double>(studies)});
  }
  std::ranges::stable_sort(result.causes, std::ranges::greater{}, &CauseShare::share);
  result.named = share_of(counts[wrong.cause], studies);
  return result;
}

SavingResult measure_saving(const SelftestOptions& options, SelftestWorkers& workers, Defect defect) {
  const SyntheticFilter filter(setup_of(defect));
  const NoiseSource noise(options.seed, SelftestNoise::kSavings + static_cast<std::uint64_t>(defect));
  const std::int64_t studies = saving_studies(options);
  const StopRule rule{.confidence = 1.0 - kSelftestPowerLevel};
  std::vector<std::int64_t> stopped_at(static_cast<std::size_t>(studies));
  std::vector<Verdict> words(static_cast<std::size_t>(studies));
  workers.for_each(
      studies,
      [&](std::int64_t i) {
        const std::size_t at = static_cast<std::size_t>(i);
        const SequentialOutcome outcome = sequential_outcomes(filter, std::span(&rule, 1), noise, i).front();
        stopped_at[at] = outcome.runs;
        words[at] = outcome.verdict;
      },
      stopped_at, words);
  Moments runs;
  CoverageCount caught;
  for (const std::int64_t count : stopped_at) runs.add(static_cast<double>(count));
  for (const Verdict word : words) caught.add(is_inconsistent(word));
  return {.name = std::string(to_string(defect)),
          .max_runs = kSequentialChunks * SyntheticFilter::kRuns,
          .runs = student_interval(runs, 0.95),
          .caught = {.count = caught}};
}

}  // namespace

std::int64_t power_work(const SelftestOptions& options) {
  return static_cast<std::int64_t>(std::size(kWrongFilters)) * studies_of_a_wrong_filter(options) +
         static_cast<std::int64_t>(std::size(kClearCases)) * saving_studies(options);
}

void measure_power(const SelftestOptions& options, SelftestWorkers& workers, SelftestResult& result) {
  result.wrong_filter_studies = studies_of_a_wrong_filter(options);
  result.wrong_filter_runs = kWrongBlocks * SyntheticFilter::kRuns;
  result.power_level = kSelftestPowerLevel;
  for (const ExpectedCause& wrong : kWrongFilters) {
    result.wrong_filters.push_back(try_wrong_filter(options, workers, wrong));
  }
  for (const Defect defect : kClearCases) {
    result.savings.push_back(measure_saving(options, workers, defect));
  }
}

}  // namespace credence::internal
