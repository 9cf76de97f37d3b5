#include "analysis/studies/selftest_calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <span>
#include <vector>

#include "analysis/laws/chi_square/chi_square.h"
#include "analysis/studies/selftest_comparisons.h"
#include "analysis/studies/selftest_families.h"
#include "analysis/studies/selftest_study.h"
#include "analysis/studies/selftest_tests.h"
#include "core/append_item.h"

namespace credence::internal {
namespace {

constexpr double kLevels[] = {0.05, 0.01};

std::int64_t single_run_blocks(const SelftestOptions& options) {
  return (options.studies + SyntheticFilter::kRuns - 1) / SyntheticFilter::kRuns;
}

StudyShare share_of_true(const std::vector<char>& hits) {
  return share_of(std::ranges::count(hits, 1), static_cast<std::int64_t>(hits.size()));
}

/// The rows of tests that were made of every study; `of` ends their names.
void add_rows(const std::vector<std::vector<TestResult>>& studies, const char* of, SelftestResult& result) {
  std::vector<std::vector<AlarmCount>> counts;
  for (const double level : kLevels) counts.push_back(count_alarms(studies, level));
  for (std::size_t test = 0; test < counts.front().size(); ++test) {
    for (std::size_t at = 0; at < counts.size(); ++at) {
      const auto& [result_of, alarms] = counts[at][test];
      result.calibration.push_back(
          {result_of->name + of, result_of->exactness, kLevels[at], share_of(alarms, std::ssize(studies))});
    }
  }
}

/// Every shipped test on these filters, which are exact; `of` ends the names of the rows.
void calibrate_shipped(std::span<const SyntheticFilter> filters, const char* of, const NoiseSource& noise,
                       const SelftestOptions& options, SelftestWorkers& workers, SelftestResult& result) {
  const auto studies = static_cast<std::size_t>(options.studies);
  std::vector<std::vector<TestResult>> all(studies);
  std::vector<char> sum_alarm(studies), band_alarm(studies);
  workers.for_each(
      options.studies,
      [&](std::int64_t i) {
        CalibrationRecorder recorder;
        const Evidence evidence =
            synthetic_evidence(filters, noise, i, SyntheticFilter::kRuns, SyntheticFilter::kSteps, &recorder);
        const auto at = static_cast<std::size_t>(i);
        const auto [calibration, judgement] = judge_rows(evidence, recorder, 1.0 - kSelftestPowerLevel);
        all[at] = shipped_tests(evidence, judgement, calibration);
        const auto values = static_cast<double>(judgement.nees.count);
        const double sum = judgement.nees.mean * values;
        sum_alarm[at] = is_alarm(two_sided_p_value(sum, judgement.nees.dof), kSelftestPowerLevel) ? 1 : 0;
        band_alarm[at] = judgement.nis.share_outside > 0 ? 1 : 0;
      },
      all, sum_alarm, band_alarm);
  if (workers.stopped()) return;
  add_rows(all, of, result);
  if (filters.size() > 1) return;
  result.naive = {
      {"NEES summed over time as chi square", "NEES", kSelftestPowerLevel, share_of_true(sum_alarm)},
      {"any step outside its pointwise band", "NIS", kSelftestPowerLevel, share_of_true(band_alarm)}};
}

void calibrate_tests(const SelftestOptions& options, SelftestWorkers& workers, SelftestResult& result) {
  const SyntheticFilter one({});
  calibrate_shipped({&one, 1}, "", NoiseSource(options.seed, SelftestNoise::kTests), options, workers,
                    result);
  // As with missed measurements: every other run has a Q of its own and misses every third measurement.
  const SyntheticFilter two[] = {one, SyntheticFilter({.noise_ratio = 1.0, .every_third_missing = true})};
  calibrate_shipped(two, ", P differs between runs", NoiseSource(options.seed, SelftestNoise::kMixed),
                    options, workers, result);
}

/// The word in studies of other sizes and kinds; the largest cost most and are fewer.
struct WordSize {
  int runs;
  std::int64_t fewer;
  int steps = SyntheticFilter::kSteps;
  SyntheticSetup setup = {};
  const char* of = "";
};
const WordSize kWordSizes[] = {
    {1, 1},
    {2, 1},
    {5, 1},
    {10, 1},
    {50, 2},
    {200, 4},
    {20, 1, 10, {}, ", 10 steps"},
    {20, 1, SyntheticFilter::kSteps, {.noise_ratio = 1.0}, ", NEES nearly white"},
    {10, 1, SyntheticFilter::kSteps, {.noise_ratio = 1.0}, ", NEES nearly white"},
    {20, 1, SyntheticFilter::kSteps, {.every_third_missing = true}, ", every third measurement missing"}};

void calibrate_word(const SelftestOptions& options, SelftestWorkers& workers, SelftestResult& result) {
  std::uint64_t kind = 0;
  for (const WordSize& size : kWordSizes) {
    const SyntheticFilter filter(size.setup);
    const NoiseSource noise(options.seed, SelftestNoise::kWord + kind++);
    const std::int64_t studies = options.studies / size.fewer;
    const std::int64_t blocks = (size.runs + SyntheticFilter::kRuns - 1) / SyntheticFilter::kRuns;
    std::vector<double> p_values(static_cast<std::size_t>(studies));
    workers.for_each(
        studies,
        [&](std::int64_t i) {
          const Evidence evidence = synthetic_evidence(filter, noise, i * blocks, size.runs, size.steps);
          p_values[static_cast<std::size_t>(i)] =
              judge(evidence, {.confidence = 1.0 - kSelftestPowerLevel}).word.p_value;
        },
        p_values);
    for (const double level : kLevels) {
      const auto alarms = std::ranges::count_if(p_values, [&](double p) { return is_alarm(p, level); });
      result.calibration.push_back({fmt::format("the word, {}{}", counted(size.runs, "run"), size.of),
                                    Exactness::conservative, level, share_of(alarms, studies)});
    }
  }
}

/// "Proved within 10 %" of a P that is 10 % too small everywhere, the nearest that is not within.
void calibrate_proof(const SelftestOptions& options, SelftestWorkers& workers, SelftestResult& result) {
  constexpr double kMargin = 0.1;
  const SyntheticFilter filter({.noise_ratio = 1.0, .logged_scale = 1.0 / (1.0 + kMargin)});
  const NoiseSource noise(options.seed, SelftestNoise::kProof);
  std::vector<double> p_values(static_cast<std::size_t>(options.studies));
  workers.for_each(
      options.studies,
      [&](std::int64_t i) {
        const Evidence evidence = synthetic_evidence(filter, noise, i, SyntheticFilter::kRuns);
        p_values[static_cast<std::size_t>(i)] =
            judge_law(evidence, evidence.study, 1.0 - kSelftestPowerLevel, kMargin).equivalence.p_value;
      },
      p_values);
  for (const double level : kLevels) {
    const auto proved = std::ranges::count_if(p_values, [&](double p) { return is_alarm(p, level); });
    result.calibration.push_back({"“proved within 10 %” of a P 10 % too small", Exactness::conservative,
                                  level, share_of(proved, options.studies)});
  }
}

/// What compares and tunes; these cost most and are fewer.
std::int64_t comparison_studies(const SelftestOptions& options) { return options.studies / 4; }

void calibrate_comparisons(const SelftestOptions& options, SelftestWorkers& workers, SelftestResult& result) {
  const std::int64_t studies = comparison_studies(options);
  const SyntheticFilter slow({}), fast({.noise_ratio = 0.1});
  const NoiseSource noise(options.seed, SelftestNoise::kLogs);
  const auto seed_of = [&](std::uint64_t part, std::int64_t i) {
    return (options.seed << 32) + (part << 24) + static_cast<std::uint64_t>(i);
  };
  const std::function<std::vector<TestResult>(std::int64_t)> parts[] = {
      [&](std::int64_t i) { return log_comparison_tests(slow, fast, noise, i); },
      [&](std::int64_t i) { return estimator_tests(seed_of(SelftestNoise::kEstimators, i)); },
      [&](std::int64_t i) { return tuning_tests(seed_of(SelftestNoise::kTuning, i)); }};
  for (const auto& tests : parts) {
    std::vector<std::vector<TestResult>> all(static_cast<std::size_t>(studies));
    workers.for_each(
        studies, [&](std::int64_t i) { all[static_cast<std::size_t>(i)] = tests(i); }, all);
    if (!workers.stopped()) add_rows(all, "", result);  // a helper has the other parts before it
  }
}

std::int64_t word_studies(const SelftestOptions& options) {
  std::int64_t all = 0;
  for (const WordSize& size : kWordSizes) all += options.studies / size.fewer;
  return all;
}

void calibrate_looks(const SelftestOptions& options, SelftestWorkers& workers, SelftestResult& result) {
  const SyntheticFilter filter({});
  const NoiseSource noise(options.seed, SelftestNoise::kLooks);
  const std::vector<StopRule> rules{{.confidence = 0.95},
                                    {.confidence = 0.99},
                                    {.confidence = 0.95, .on_verdict = false, .precision = 0.1},
                                    {.confidence = 0.99, .on_verdict = false, .precision = 0.1}};
  struct Alarms {
    std::array<bool, 4> wrong{};  // by rule
    bool naive = false;           // asked of every fourth study
  };
  std::vector<Alarms> all(static_cast<std::size_t>(options.studies));
  const std::int64_t naive_studies = options.studies / 4;
  workers.for_each(
      options.studies,
      [&](std::int64_t i) {
        Alarms& alarms = all[static_cast<std::size_t>(i)];
        const std::vector<SequentialOutcome> outcomes = sequential_outcomes(filter, rules, noise, i);
        for (std::size_t rule = 0; rule < rules.size(); ++rule) {
          const MeanInterval& mean = outcomes[rule].mean_nees;
          const bool covers =
              mean.lower <= SyntheticFilter::kStateDof && SyntheticFilter::kStateDof <= mean.upper;
          const Verdict verdict = outcomes[rule].verdict;
          alarms.wrong[rule] = rules[rule].on_verdict ? is_inconsistent(verdict) : !covers;
        }
        if (i < naive_studies) alarms.naive = naive_looks_reject(filter, noise, i, 1.0 - kSelftestPowerLevel);
      },
      all);
  for (std::size_t rule = 0; rule < rules.size(); ++rule) {
    const bool verdict = rules[rule].on_verdict;
    const auto wrong = std::ranges::count_if(all, [&](const Alarms& a) { return a.wrong[rule]; });
    result.calibration.push_back({verdict ? "stop by verdict, a look after every chunk"
                                          : "stop by precision, interval of the mean NEES",
                                  verdict ? Exactness::conservative : Exactness::approximate,
                                  kLevels[rule % std::size(kLevels)], share_of(wrong, options.studies)});
  }
  result.naive.push_back({"a fixed-sample verdict after every chunk, stop at the first rejection",
                          "stop by verdict, a look after every chunk", kSelftestPowerLevel,
                          share_of(std::ranges::count_if(all, &Alarms::naive), naive_studies)});
}

void calibrate_sweep(const SelftestOptions& options, SelftestWorkers& workers, SelftestResult& result) {
  const SyntheticSweep sweep;
  const NoiseSource noise(options.seed, SelftestNoise::kSweep);
  const std::size_t studies = static_cast<std::size_t>(options.studies);
  std::vector<std::vector<SyntheticSweep::Discoveries>> all(studies);
  workers.for_each(
      options.studies,
      [&](std::int64_t i) { all[static_cast<std::size_t>(i)] = sweep.discoveries(noise, i, kLevels); }, all);
  if (workers.stopped()) return;
  for (std::size_t level = 0; level < std::size(kLevels); ++level) {
    std::int64_t any = 0, drawn = 0;
    for (const auto& study : all) {
      any += study[level].any_false;
      drawn += study[level].drawn_is_false;
    }
    result.calibration.push_back({"sweep of 12 exact filters, any discovery", Exactness::conservative,
                                  kLevels[level], share_of(any, options.studies)});
    result.calibration.push_back({"sweep of 8 exact and 4 wrong filters, false discovery rate",
                                  Exactness::conservative, kLevels[level], share_of(drawn, options.studies)});
  }
}

/// A test of long runs of one kind, by its p-values of each block of them.
template <std::size_t kStudies>
void calibrate_long_runs(std::array<double, kStudies> (*p_values)(const NoiseSource&, std::int64_t),
                         std::uint64_t group, const char* name, Exactness exactness,
                         const SelftestOptions& options, SelftestWorkers& workers, SelftestResult& result) {
  const NoiseSource noise(options.seed, group);
  const std::int64_t blocks = single_run_blocks(options);
  std::vector<std::array<double, kStudies>> all(static_cast<std::size_t>(blocks));
  workers.for_each(
      blocks, [&](std::int64_t block) { all[static_cast<std::size_t>(block)] = p_values(noise, block); },
      all);
  for (const double level : kLevels) {
    std::int64_t alarms = 0;
    for (const auto& block : all) {
      alarms += std::ranges::count_if(block, [&](double p) { return is_alarm(p, level); });
    }
    const auto studies = blocks * static_cast<std::int64_t>(kStudies);
    result.calibration.push_back({name, exactness, level, share_of(alarms, studies)});
  }
}

}  // namespace

std::int64_t calibration_work(const SelftestOptions& options) {
  return 5 * options.studies + word_studies(options) + 3 * comparison_studies(options) +
         4 * single_run_blocks(options);
}

void calibrate(const SelftestOptions& options, SelftestWorkers& workers, SelftestResult& result) {
  calibrate_tests(options, workers, result);
  calibrate_word(options, workers, result);
  calibrate_proof(options, workers, result);
  calibrate_comparisons(options, workers, result);
  calibrate_looks(options, workers, result);
  calibrate_sweep(options, workers, result);
  calibrate_long_runs(single_run_p_values, SelftestNoise::kSingleRuns,
                      "NEES of one long run, effective sample size", Exactness::approximate, options, workers,
                      result);
  calibrate_long_runs(nees_over_time_p_values, SelftestNoise::kSingleRuns, "NEES of one long run over time",
                      Exactness::conservative, options, workers, result);
  calibrate_long_runs(nis_over_time_p_values, SelftestNoise::kSingleRuns, "NIS of one long run over time",
                      Exactness::approximate, options, workers, result);
  calibrate_long_runs(agreement_p_values, SelftestNoise::kAgreement,
                      "agreement of the time offsets of four logs", Exactness::conservative, options, workers,
                      result);
}

}  // namespace credence::internal
