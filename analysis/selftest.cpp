#include "analysis/selftest.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <utility>

#include "analysis/chi_square.h"
#include "analysis/selftest_families.h"
#include "core/parallel_tasks.h"

namespace credence {
namespace {

constexpr double kLevels[] = {0.05, 0.01};
constexpr double kFamilyLevel = 1e-3;
constexpr double kPowerLevel = 0.05;
constexpr int kWrongBlocks = 4;  // of kRuns runs each, in a study of a wrong filter
constexpr double kCaughtWanted = 0.95;
constexpr double kNamedWanted = 0.8;

// Noise that different parts of the selftest draw from.
enum NoiseGroup : std::uint64_t { kBattery = 1, kLooks, kSweep, kSingleRuns, kWrong = 100, kSavings = 200 };

struct ExpectedCause {
  Defect defect;
  Cause cause;
};

constexpr ExpectedCause kWrongFilters[] = {
    {Defect::process_noise_too_small, Cause::process_noise_too_small},
    {Defect::process_noise_too_large, Cause::process_noise_too_large},
    {Defect::measurement_noise_too_small, Cause::measurement_noise_too_small},
    {Defect::measurement_noise_too_large, Cause::measurement_noise_too_large},
    {Defect::wrong_dof, Cause::wrong_dof},
    {Defect::unwrapped_angle, Cause::unwrapped_angle},
    {Defect::dropped_cross_covariance, Cause::cross_covariance},
    {Defect::coloured_noise, Cause::coloured_noise},
    {Defect::initial_covariance, Cause::initial_covariance},
    {Defect::gated_innovations, Cause::gated_innovations},
    {Defect::biased_measurement, Cause::biased_innovation},
};

constexpr Defect kClearCases[] = {Defect::process_noise_too_small, Defect::process_noise_too_large,
                                  Defect::measurement_noise_too_small, Defect::measurement_noise_too_large};

// Work items on some threads, with progress over all of them; the order of execution changes nothing, as each
// item writes only what is its own.
class Workers {
 public:
  Workers(const SelftestOptions& options, std::int64_t total) : options_(options), total_(total) {}

  void for_each(std::int64_t count, const std::function<void(std::int64_t)>& work) {
    for_each_task(count, options_.threads, options_.stop, [&](std::int64_t i) {
      work(i);
      const std::lock_guard lock(mutex_);
      ++done_;
      if (options_.progress) options_.progress(done_, total_);
    });
  }

  bool stopped() const { return options_.stop != nullptr && options_.stop->load(std::memory_order_relaxed); }

 private:
  const SelftestOptions& options_;
  std::mutex mutex_;
  std::int64_t done_ = 0, total_;
};

std::int64_t wrong_filter_studies(const SelftestOptions& options) { return options.studies / 10; }
std::int64_t saving_studies(const SelftestOptions& options) { return options.studies / 20; }
std::int64_t single_run_blocks(const SelftestOptions& options) {
  return (options.studies + SyntheticFilter::kRuns - 1) / SyntheticFilter::kRuns;
}

std::int64_t total_work(const SelftestOptions& options) {
  return 3 * options.studies + single_run_blocks(options) +
         static_cast<std::int64_t>(std::size(kWrongFilters)) * wrong_filter_studies(options) +
         static_cast<std::int64_t>(std::size(kClearCases)) * saving_studies(options);
}

bool is_alarm(double p_value, double level) { return p_value <= level; }

StudyShare share_of(std::int64_t hits, std::int64_t studies) {
  return {.count = {.inside = hits, .total = studies}};
}

StudyShare share_of(const std::vector<char>& hits) {
  return share_of(std::count(hits.begin(), hits.end(), 1), static_cast<std::int64_t>(hits.size()));
}

void calibrate_battery(const SelftestOptions& options, Workers& workers, SelftestResult& result) {
  const SyntheticFilter filter({});
  const BatteryLaws laws = battery_laws(filter, SyntheticFilter::kRuns);
  const NoiseSource noise(options.seed, kBattery);
  const std::size_t studies = static_cast<std::size_t>(options.studies);
  std::vector<std::vector<BatteryResult>> all(studies);
  std::vector<char> sum_alarm(studies), band_alarm(studies), gate_alarm(studies);
  workers.for_each(options.studies, [&](std::int64_t i) {
    const SyntheticStudy study = make_study(filter, noise, i, 1);
    const std::size_t at = static_cast<std::size_t>(i);
    all[at] = battery_results(filter, laws, study);
    const double dof = SyntheticFilter::kStateDof * SyntheticFilter::kSteps * SyntheticFilter::kRuns;
    sum_alarm[at] =
        is_alarm(two_sided_p_value(study.run_sum_nees.mean * SyntheticFilter::kRuns, dof), kPowerLevel) ? 1
                                                                                                        : 0;
    band_alarm[at] =
        judge_nis(study.nis, synthetic_dofs(study.nis, 2.0), 1.0 - kPowerLevel).share_outside > 0 ? 1 : 0;
    gate_alarm[at] =
        is_alarm(judge_nis(study.gated_nis, synthetic_dofs(study.gated_nis, 2.0), 1.0 - kPowerLevel).p_value,
                 kPowerLevel)
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
  result.naive = {{"NEES summed over time as chi square", "NEES verdict, any correlation in time",
                   kPowerLevel, share_of(sum_alarm)},
                  {"any step outside its pointwise band", "NIS verdict", kPowerLevel, share_of(band_alarm)},
                  {"gated NIS against the plain law", "gated NIS verdict, truncated law", kPowerLevel,
                   share_of(gate_alarm)}};
}

void calibrate_looks(const SelftestOptions& options, Workers& workers, SelftestResult& result) {
  const SyntheticFilter filter({});
  const NoiseSource noise(options.seed, kLooks);
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
    if (at < naive.size()) naive[at] = naive_looks_reject(filter, noise, i, 1.0 - kPowerLevel) ? 1 : 0;
  });
  for (std::size_t rule = 0; rule < rules.size(); ++rule) {
    const bool verdict = rules[rule].on_verdict;
    result.calibration.push_back({verdict ? "stop by verdict, a look after every chunk"
                                          : "stop by precision, interval of the mean NEES",
                                  verdict ? Exactness::conservative : Exactness::approximate,
                                  kLevels[rule % std::size(kLevels)], share_of(wrong[rule])});
  }
  result.naive.push_back({"a fixed-sample verdict after every chunk, stop at the first rejection",
                          "stop by verdict, a look after every chunk", kPowerLevel, share_of(naive)});
}

void calibrate_sweep(const SelftestOptions& options, Workers& workers, SelftestResult& result) {
  const SyntheticSweep sweep;
  const NoiseSource noise(options.seed, kSweep);
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

void calibrate_single_runs(const SelftestOptions& options, Workers& workers, SelftestResult& result) {
  const NoiseSource noise(options.seed, kSingleRuns);
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

WrongFilterResult try_wrong_filter(const SelftestOptions& options, Workers& workers, ExpectedCause wrong) {
  const SyntheticFilter filter(setup_of(wrong.defect));
  const BatteryLaws laws = battery_laws(filter, kWrongBlocks * SyntheticFilter::kRuns);
  const NoiseSource noise(options.seed, kWrong + static_cast<std::uint64_t>(wrong.defect));
  const std::int64_t studies = wrong_filter_studies(options);
  std::vector<std::vector<BatteryResult>> all(static_cast<std::size_t>(studies));
  std::vector<std::optional<Cause>> causes(static_cast<std::size_t>(studies));
  workers.for_each(studies, [&](std::int64_t i) {
    const std::size_t at = static_cast<std::size_t>(i);
    const SyntheticStudy study = make_study(filter, noise, i * kWrongBlocks, kWrongBlocks);
    all[at] = battery_results(filter, laws, study);
    const std::vector<CauseFound> found = battery_causes(filter, study, 1.0 - kPowerLevel);
    if (!found.empty()) causes[at] = found.front().cause;
  });
  WrongFilterResult result{.name = std::string(to_string(wrong.defect)),
                           .caught_wanted = kCaughtWanted,
                           .expected = wrong.cause,
                           .named_wanted = kNamedWanted};
  if (workers.stopped()) return result;
  for (std::size_t test = 0; test < all.front().size(); ++test) {
    const auto found = std::count_if(all.begin(), all.end(), [&](const std::vector<BatteryResult>& r) {
      return is_alarm(r[test].p_value, kPowerLevel);
    });
    result.power.push_back({std::string(all.front()[test].name), share_of(found, studies)});
  }
  result.caught = result.power.back().measured;
  std::map<Cause, std::int64_t> counts;
  for (const auto& cause : causes) {
    if (cause) ++counts[*cause];
  }
  for (const auto& [cause, count] : counts) {
    result.causes.push_back({cause, static_cast<double>(count) / static_cast<double>(studies)});
  }
  std::ranges::stable_sort(result.causes, std::ranges::greater{}, &NamedCause::share);
  result.named = share_of(counts[wrong.cause], studies);
  return result;
}

SavingResult measure_saving(const SelftestOptions& options, Workers& workers, Defect defect) {
  const SyntheticFilter filter(setup_of(defect));
  const NoiseSource noise(options.seed, kSavings + static_cast<std::uint64_t>(defect));
  const std::int64_t studies = saving_studies(options);
  const StopRule rule{.confidence = 1.0 - kPowerLevel};
  std::vector<SequentialOutcome> outcomes(static_cast<std::size_t>(studies));
  workers.for_each(studies, [&](std::int64_t i) {
    outcomes[static_cast<std::size_t>(i)] =
        sequential_outcomes(filter, std::span(&rule, 1), noise, i).front();
  });
  Moments runs;
  CoverageCount caught;
  for (const SequentialOutcome& outcome : outcomes) {
    runs.add(static_cast<double>(outcome.runs));
    caught.add(is_inconsistent(outcome.verdict));
  }
  return {.name = std::string(to_string(defect)),
          .max_runs = kSequentialChunks * SyntheticFilter::kRuns,
          .runs = student_interval(runs, 0.95),
          .caught = {.count = caught}};
}

}  // namespace

void judge_selftest(SelftestResult& result) {
  const double rows = static_cast<double>(result.calibration.size() + 2 * result.wrong_filters.size());
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
                filter.named.interval.upper >= filter.named_wanted;
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
                        .wrong_filter_studies = wrong_filter_studies(options),
                        .runs = SyntheticFilter::kRuns,
                        .wrong_filter_runs = kWrongBlocks * SyntheticFilter::kRuns,
                        .steps = SyntheticFilter::kSteps,
                        .power_level = kPowerLevel};
  Workers workers(options, total_work(options));
  calibrate_battery(options, workers, result);
  calibrate_looks(options, workers, result);
  calibrate_sweep(options, workers, result);
  calibrate_single_runs(options, workers, result);
  for (const ExpectedCause& wrong : kWrongFilters) {
    result.wrong_filters.push_back(try_wrong_filter(options, workers, wrong));
  }
  for (const Defect defect : kClearCases) {
    result.savings.push_back(measure_saving(options, workers, defect));
  }
  result.complete = !workers.stopped();
  if (result.complete) judge_selftest(result);
  return result;
}

}  // namespace credence
