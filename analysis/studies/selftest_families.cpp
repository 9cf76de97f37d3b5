#include "analysis/studies/selftest_families.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "analysis/evidence/verdicts/word.h"
#include "analysis/laws/correlation/error_modulation.h"
#include "analysis/laws/correlation/modulation.h"
#include "analysis/laws/joint/betting_e_value.h"
#include "analysis/laws/joint/multiple_tests.h"
#include "analysis/laws/mean/effective_sample.h"
#include "analysis/laws/mean/influence_interval.h"
#include "analysis/studies/selftest_study.h"

namespace credence::internal {
namespace {

// The sums of a growing study.
class GrowingStudy {
 public:
  GrowingStudy(const SyntheticFilter& filter, const NoiseSource& noise, std::int64_t first_block)
      : filter_(filter), noise_(noise), next_block_(first_block) {}

  void add_chunk() {
    const auto samples = filter_.simulate(noise_, next_block_++);
    add_samples(filter_, samples, nees, nis);
    Eigen::Array<double, 1, SyntheticFilter::kRuns> sums;
    sums.setZero();
    for (int k = 0; k < SyntheticFilter::kSteps; ++k) {
      sums += filter_.nees(k, samples[static_cast<std::size_t>(k)].error);
    }
    const BettingPrices prices = betting_prices(SyntheticFilter::kStateDof);
    for (int run = 0; run < SyntheticFilter::kRuns; ++run) {
      constexpr double kDof = SyntheticFilter::kStateDof * SyntheticFilter::kSteps;
      runs.add(sums(run), kDof, static_cast<std::int64_t>(SyntheticFilter::kStateDof));
      betting.add(sums(run) / kDof, prices);
    }
    dofs = synthetic_dofs(nis, SyntheticFilter::kInnovationDof);  // those of NEES are the same
  }

  std::vector<Moments> nees = std::vector<Moments>(SyntheticFilter::kSteps);
  std::vector<Moments> nis = nees;
  std::vector<double> dofs;
  RunAverages runs;
  RunBetting betting;

 private:
  const SyntheticFilter& filter_;
  const NoiseSource& noise_;
  std::int64_t next_block_;
};

// As of a configuration of a sweep (sweep_p_values).
double word_p_value(const SyntheticFilter& filter, const NoiseSource& noise, std::int64_t block) {
  constexpr double kConfidence = 0.95;
  GrowingStudy study(filter, noise, block);
  study.add_chunk();
  const ConsistencyVerdict nees = judge_nees(study.nees, study.dofs, kConfidence, &study.runs);
  const ConsistencyVerdict nis = judge_nis(study.nis, study.dofs, kConfidence);
  return join_verdicts(word_parts(nees, nis, {}), kConfidence).p_value;
}

}  // namespace

std::vector<SequentialOutcome> sequential_outcomes(const SyntheticFilter& filter,
                                                   std::span<const StopRule> rules, const NoiseSource& noise,
                                                   std::int64_t index) {
  std::vector<SequentialOutcome> outcomes(rules.size());
  GrowingStudy study(filter, noise, index * kSequentialChunks);
  std::size_t running = rules.size();
  for (int chunk = 1; running > 0; ++chunk) {
    study.add_chunk();
    const StudyPrefix prefix{.nees = study.nees,
                             .nees_dof = study.dofs,
                             .nis = study.nis,
                             .nis_dof = study.dofs,
                             .runs = &study.runs,
                             .betting = &study.betting,
                             .last = chunk == kSequentialChunks};
    for (std::size_t i = 0; i < rules.size(); ++i) {
      if (outcomes[i].runs > 0) continue;
      const StopDecision decision = look(rules[i], prefix);
      if (!decision.stop) continue;
      outcomes[i] = {decision.verdict, study.runs.moments.count, decision.mean_nees};
      --running;
    }
  }
  return outcomes;
}

bool naive_looks_reject(const SyntheticFilter& filter, const NoiseSource& noise, std::int64_t index,
                        double confidence) {
  GrowingStudy study(filter, noise, index * kSequentialChunks);
  for (int chunk = 0; chunk < kSequentialChunks; ++chunk) {
    study.add_chunk();
    if (judge_nis(study.nis, study.dofs, confidence).verdict != Verdict::consistent) return true;
  }
  return false;
}

SyntheticSweep::SyntheticSweep() {
  for (int i = 0; i < kExact + kWrong; ++i) {
    const double noise_ratio = 0.0025 * std::pow(2.0, i);
    exact_.emplace_back(SyntheticSetup{.noise_ratio = noise_ratio});
    // Wrong by so little that some are found and some are not.
    if (i >= kExact) {
      wrong_.emplace_back(SyntheticSetup{.noise_ratio = noise_ratio, .measurement_scale = 0.92});
    }
  }
}

std::vector<SyntheticSweep::Discoveries> SyntheticSweep::discoveries(const NoiseSource& noise,
                                                                     std::int64_t index,
                                                                     std::span<const double> levels) const {
  std::vector<double> p_values;
  for (const SyntheticFilter& filter : exact_) p_values.push_back(word_p_value(filter, noise, index));
  const std::vector<double> all_exact = benjamini_yekutieli(p_values);
  for (std::size_t i = 0; i < wrong_.size(); ++i)
    p_values[kExact + i] = word_p_value(wrong_[i], noise, index);
  const std::vector<double> mixed = benjamini_yekutieli(p_values);
  const double draw = noise.uniform(index, 0, NoisePurpose::decision, 0);
  std::vector<Discoveries> result;
  for (const double level : levels) {
    const auto discovered = [level](double p) { return p <= level; };
    const auto wrongly = std::count_if(mixed.begin(), mixed.begin() + kExact, discovered);
    const auto all = std::ranges::count_if(mixed, discovered);
    result.push_back({.any_false = std::ranges::any_of(all_exact, discovered),
                      .drawn_is_false = draw * static_cast<double>(all) < static_cast<double>(wrongly)});
  }
  return result;
}

namespace {

constexpr double kMemory = 0.8;

/// Of every run an autoregression of variance 1.
std::vector<std::vector<double>> autoregressions(const NoiseSource& noise, std::int64_t block,
                                                 double phi = kMemory) {
  constexpr std::size_t kRuns = SyntheticFilter::kRuns;
  constexpr int kSteps = 2000;
  std::vector<double> normals(static_cast<std::size_t>(kSteps) * kRuns);
  noise.normals_of_runs(block * SyntheticFilter::kRuns, 1, kSteps, NoisePurpose::process, 1, normals);
  std::vector<std::vector<double>> runs(kRuns, std::vector<double>(kSteps));
  for (std::size_t run = 0; run < kRuns; ++run) {
    double value = normals[run];
    for (std::size_t k = 0; k < kSteps; ++k) {
      if (k > 0) value = phi * value + std::sqrt(1.0 - phi * phi) * normals[k * kRuns + run];
      runs[run][k] = value;
    }
  }
  return runs;
}

/// Of each run, whose NEES are the squares of an autoregression.
std::array<double, SyntheticFilter::kRuns> p_values_of_nees(const NoiseSource& noise, std::int64_t block,
                                                            double phi,
                                                            double (*p_value)(std::span<const double>)) {
  std::array<double, SyntheticFilter::kRuns> result{};
  std::vector<std::vector<double>> runs = autoregressions(noise, block, phi);
  for (std::size_t run = 0; run < result.size(); ++run) {
    for (double& value : runs[run]) value *= value;
    result[run] = p_value(runs[run]);
  }
  return result;
}

}  // namespace

std::array<double, SyntheticFilter::kRuns> single_run_p_values(const NoiseSource& noise, std::int64_t block) {
  return p_values_of_nees(noise, block, kMemory,
                          [](std::span<const double> nees) { return test_single_run(nees, 0.95).p_value; });
}

std::array<double, SyntheticFilter::kRuns> nees_over_time_p_values(const NoiseSource& noise,
                                                                   std::int64_t block) {
  std::array<double, SyntheticFilter::kRuns> result{};
  const std::vector<std::vector<double>> runs = autoregressions(noise, block);
  for (std::size_t run = 0; run < result.size(); ++run)
    result[run] = error_modulation(Matrix::Map(runs[run].data(), 1, std::ssize(runs[run]))).p_value;
  return result;
}

std::array<double, SyntheticFilter::kRuns> nis_over_time_p_values(const NoiseSource& noise,
                                                                  std::int64_t block) {
  return p_values_of_nees(noise, block, 0.0,
                          [](std::span<const double> nis) { return modulation(nis).p_value; });
}

std::array<double, SyntheticFilter::kRuns / 4> agreement_p_values(const NoiseSource& noise,
                                                                  std::int64_t block) {
  constexpr std::size_t kLogs = 4;
  std::array<double, SyntheticFilter::kRuns / kLogs> result{};
  const std::vector<std::vector<double>> runs = autoregressions(noise, block);
  for (std::size_t study = 0; study < result.size(); ++study) {
    std::vector<RunScores> logs;
    Moments all;
    for (std::size_t i = 0; i < kLogs; ++i) {
      const std::vector<double>& scores = runs[kLogs * study + i];
      logs.push_back({.values = scores, .information = std::vector<double>(scores.size(), 1.0)});
      for (const double score : scores) all.add(score);
    }
    for (RunScores& log : logs) {
      for (double& score : log.values) score -= all.mean;  // at the common estimate their sum is 0
    }
    result[study] = influence_interval(logs, 0.95).p_agreement;
  }
  return result;
}

}  // namespace credence::internal
