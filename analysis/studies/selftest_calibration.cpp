#include "analysis/studies/selftest_calibration.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "analysis/laws/chi_square.h"
#include "analysis/studies/selftest_families.h"

namespace credence {
namespace {

constexpr double kLevels[] = {0.05, 0.01};

std::int64_t single_run_blocks(const SelftestOptions& options) {
  return (options.studies + SyntheticFilter::kRuns - 1) / SyntheticFilter::kRuns;
}

StudyShare share_of_true(const std::vector<char>& hits) {
  return share_of(std::count(hits.begin(), hits.end(), 1), static_cast<std::int64_t>(hits.size()));
}

void calibrate_battery(const SelftestOptions& options, SelftestWorkers& workers, SelftestResult& result) {
  const SyntheticFilter filter({});
  const BatteryLaws laws = battery_laws(filter, SyntheticFilter::kRuns);
  const NoiseSource noise(options.seed, SelftestNoise::kBattery);
  const std::size_t studies = static_cast<std::size_t>(options.studies);
  std::vector<std::vector<BatteryResult>> all(studies);
  std::vector<char> sum_alarm(studies), band_alarm(studies), gate_alarm(studies);
  workers.for_each(options.studies, [&](std::int64_t i) {
    const SyntheticStudy study = make_study(filter, noise, i, 1);
    const std::size_t at = static_cast<std::size_t>(i);
    all[at] = battery_results(filter, laws, study);
    const double dof = SyntheticFilter::kStateDof * SyntheticFilter::kSteps * SyntheticFilter::kRuns;
    sum_alarm[at] = is_alarm(two_sided_p_value(study.run_sum_nees.mean * SyntheticFilter::kRuns, dof),
                             kSelftestPowerLevel)
                        ? 1
                        : 0;
    band_alarm[at] =
        judge_nis(study.nis, synthetic_dofs(study.nis, 2.0), 1.0 - kSelftestPowerLevel).share_outside > 0 ? 1
                                                                                                          : 0;
    gate_alarm[at] =
        is_alarm(judge_nis(study.gated_nis, synthetic_dofs(study.gated_nis, 2.0), 1.0 - kSelftestPowerLevel)
                     .p_value,
                 kSelftestPowerLevel)
            ? 1
            : 0;
  });
  if (workers.stopped()) return;
  for (std::size_t test = 0; test < all.front().size(); ++test) {
    for (const double level : kLevels) {
      const auto alarms = std::count_if(all.begin(), all.end(), [&](const std::vector<BatteryResult>& r) {
        return is_alarm(r[test].p_value, level);
      });
      result.calibration.push_back({std::string(all.front()[test].name), all.front()[test].exactness, level,
                                    share_of(alarms, options.studies)});
    }
  }
  result.naive = {
      {"NEES summed over time as chi square", "NEES verdict, any correlation in time", kSelftestPowerLevel,
       share_of_true(sum_alarm)},
      {"any step outside its pointwise band", "NIS verdict", kSelftestPowerLevel, share_of_true(band_alarm)},
      {"gated NIS against the plain law", "gated NIS verdict, truncated law", kSelftestPowerLevel,
       share_of_true(gate_alarm)}};
}

void calibrate_looks(const SelftestOptions& options, SelftestWorkers& workers, SelftestResult& result) {
  const SyntheticFilter filter({});
  const NoiseSource noise(options.seed, SelftestNoise::kLooks);
  const std::vector<StopRule> rules{{.confidence = 0.95},
                                    {.confidence = 0.99},
                                    {.confidence = 0.95, .on_verdict = false, .precision = 0.1},
                                    {.confidence = 0.99, .on_verdict = false, .precision = 0.1}};
  const std::size_t studies = static_cast<std::size_t>(options.studies);
  std::vector<std::vector<char>> wrong(rules.size(), std::vector<char>(studies));
  std::vector<char> naive(studies / 4);
  workers.for_each(options.studies, [&](std::int64_t i) {
    const std::size_t at = static_cast<std::size_t>(i);
    const std::vector<SequentialOutcome> outcomes = sequential_outcomes(filter, rules, noise, i);
    for (std::size_t rule = 0; rule < rules.size(); ++rule) {
      const MeanInterval& mean = outcomes[rule].mean_nees;
      const bool covers =
          mean.lower <= SyntheticFilter::kStateDof && SyntheticFilter::kStateDof <= mean.upper;
      const Verdict verdict = outcomes[rule].verdict;
      wrong[rule][at] = rules[rule].on_verdict ? is_inconsistent(verdict) : !covers;
    }
    if (at < naive.size())
      naive[at] = naive_looks_reject(filter, noise, i, 1.0 - kSelftestPowerLevel) ? 1 : 0;
  });
  for (std::size_t rule = 0; rule < rules.size(); ++rule) {
    const bool verdict = rules[rule].on_verdict;
    result.calibration.push_back({verdict ? "stop by verdict, a look after every chunk"
                                          : "stop by precision, interval of the mean NEES",
                                  verdict ? Exactness::conservative : Exactness::approximate,
                                  kLevels[rule % std::size(kLevels)], share_of_true(wrong[rule])});
  }
  result.naive.push_back({"a fixed-sample verdict after every chunk, stop at the first rejection",
                          "stop by verdict, a look after every chunk", kSelftestPowerLevel,
                          share_of_true(naive)});
}

void calibrate_sweep(const SelftestOptions& options, SelftestWorkers& workers, SelftestResult& result) {
  const SyntheticSweep sweep;
  const NoiseSource noise(options.seed, SelftestNoise::kSweep);
  const std::size_t studies = static_cast<std::size_t>(options.studies);
  std::vector<std::vector<SyntheticSweep::Discoveries>> all(studies);
  workers.for_each(options.studies, [&](std::int64_t i) {
    all[static_cast<std::size_t>(i)] = sweep.discoveries(noise, i, kLevels);
  });
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

void calibrate_single_runs(const SelftestOptions& options, SelftestWorkers& workers, SelftestResult& result) {
  const NoiseSource noise(options.seed, SelftestNoise::kSingleRuns);
  const std::int64_t blocks = single_run_blocks(options);
  std::vector<std::array<double, SyntheticFilter::kRuns>> all(static_cast<std::size_t>(blocks));
  workers.for_each(blocks, [&](std::int64_t block) {
    all[static_cast<std::size_t>(block)] = single_run_p_values(noise, block);
  });
  for (const double level : kLevels) {
    std::int64_t alarms = 0;
    for (const auto& block : all) {
      alarms += std::count_if(block.begin(), block.end(), [&](double p) { return is_alarm(p, level); });
    }
    result.calibration.push_back({"NEES of one long run, effective sample size", Exactness::approximate,
                                  level, share_of(alarms, blocks * SyntheticFilter::kRuns)});
  }
}

}  // namespace

std::int64_t calibration_work(const SelftestOptions& options) {
  return 3 * options.studies + single_run_blocks(options);
}

void calibrate(const SelftestOptions& options, SelftestWorkers& workers, SelftestResult& result) {
  calibrate_battery(options, workers, result);
  calibrate_looks(options, workers, result);
  calibrate_sweep(options, workers, result);
  calibrate_single_runs(options, workers, result);
}

}  // namespace credence
