#include "analysis/studies/selftest_tests.h"

#include <algorithm>
#include <cmath>

#include "analysis/evidence/sequential/sequential_e_value.h"
#include "analysis/laws/joint/betting_e_value.h"
#include "analysis/laws/mean/hall_score.h"
#include "analysis/laws/scores/rmse_interval.h"
#include "analysis/studies/selftest_workers.h"
#include "core/nan.h"

namespace credence::internal {
namespace {

double betting_e_value_p(const RunAverages& runs) {
  if (runs.first.empty()) return kNaN;
  const BettingPrices prices = betting_prices(static_cast<double>(runs.least_dof));
  RunBetting betting;
  for (const double average : runs.first) betting.add(average, prices);
  return std::exp(-betting.log_e_value());
}

template <class Bin>
double smallest_adjusted(const std::vector<Bin>& bins) {
  double smallest = kNaN;
  for (const Bin& bin : bins) smallest = std::fmin(smallest, bin.adjusted);
  return smallest;
}

/// The smallest level asked for at which the interval misses what it is of.
template <class IntervalAt>
double p_value_of_interval(double truth, const IntervalAt& interval_at) {
  double p_value = 1.0;
  for (const double level : {0.05, 0.01}) {
    const auto interval = interval_at(1.0 - level);
    if (interval.lower > truth || interval.upper < truth) p_value = level;
  }
  return p_value;
}

double score_p_value(const ScoreMoments& score) {
  if (score.value.count == 0) return kNaN;
  return p_value_of_interval(score.expected.mean,
                             [&](double confidence) { return hall_interval(score.value, confidence); });
}

/// Of squared errors that are what P claims.
double rmse_p_value(const BlockSums& block) {
  return p_value_of_interval(block.claimed.mean, [&](double confidence) {
    return mean_square_interval(block.squared_error, confidence);
  });
}

}  // namespace

JudgedRows judge_rows(const Evidence& evidence, CalibrationRecorder& rows, double confidence) {
  JudgedRows judged{judge_calibration(rows, confidence), {}};
  JudgementContext context{.confidence = confidence};
  context.claimed_sigma = judged.calibration.claimed_sigma;
  judged.judgement = judge(evidence, context);
  return judged;
}

std::vector<AlarmCount> count_alarms(const std::vector<std::vector<TestResult>>& studies, double level) {
  std::vector<AlarmCount> counts;
  for (const std::vector<TestResult>& study : studies) {
    for (const TestResult& test : study) {
      auto of = std::ranges::find_if(counts, [&](const AlarmCount& c) { return c.test->name == test.name; });
      if (of == counts.end()) of = counts.insert(of, {&test});
      of->alarms += is_alarm(test.p_value, level) ? 1 : 0;
    }
  }
  return counts;
}

std::vector<TestResult> shipped_tests(const Evidence& e, const Judgement& j, const Calibration& c) {
  std::vector<TestResult> results;
  double smallest = 1.0;
  for (const NamedTest& test : j.tests) {
    results.push_back({test.name, test.exactness, test.p_value});
    if (!std::isnan(test.adjusted)) smallest = std::min(smallest, test.adjusted);
  }
  const auto conservative = [&](const char* name, double p_value) {
    TestResult& result = results.emplace_back();
    result.name = name;
    result.exactness = Exactness::conservative;
    result.p_value = p_value;
  };
  conservative("errors by claimed σ, Holm", smallest_adjusted(c.bins));
  conservative("NEES by distance, Holm", smallest_adjusted(c.distance));
  conservative("NIS far out", j.law.gaussianity.far_nis_p_value);
  conservative("interval of the log score", score_p_value(e.scores.log));
  conservative("interval of the energy score", score_p_value(e.scores.energy));
  // Over runs of which some have a P of their own it is wider than need be.
  for (const BlockSums& block : e.blocks) {
    results.push_back(
        {"interval of the RMSE of " + block.name, Exactness::conservative, rmse_p_value(block)});
  }
  const StudyStatistics& s = e.study;
  const double e_nees = log_e_nees(s.series(Quantity::nees), s.dofs(Quantity::nees));
  const double e_nis = log_e_nis(s.series(Quantity::nis), s.dofs(Quantity::nis));
  conservative("e-value of NEES, steps", std::exp(-e_nees));
  conservative("e-value of NEES, betting over runs", betting_e_value_p(s.nees_of_runs));
  conservative("e-value of NIS", std::exp(-e_nis));
  conservative("all tests together, Holm", smallest);
  conservative("the word", j.word.p_value);
  return results;
}

}  // namespace credence::internal
