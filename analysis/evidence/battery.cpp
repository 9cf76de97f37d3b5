#include "analysis/evidence/battery.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/evidence/effective_steps.h"
#include "analysis/evidence/settling_power.h"
#include "analysis/laws/multiple_tests.h"
#include "analysis/laws/sample_size.h"
#include "core/nan.h"

namespace credence {
namespace {

constexpr const char* kNisBody = "NIS against its law, body";
constexpr const char* kNisTails = "NIS against its law, tails";
constexpr const char* kWhiteness = "whiteness of the innovation";
constexpr const char* kInnovationMean = "mean of the innovation";

std::vector<BlockVerdict> judge_blocks(const BlockStatistics& blocks, double confidence) {
  std::vector<BlockVerdict> verdicts;
  for (const BlockSeries& block : blocks.series()) {
    verdicts.push_back({block.name, judge_nees(block.nees, block.dof, confidence)});
  }
  return verdicts;
}

CoverageVerdict judge_region(const CoverageStatistics::Region& region, double confidence) {
  std::vector<double> expected;
  for (std::size_t k = 0; k < region.count.size(); ++k) {
    const auto total = static_cast<double>(region.count[k].total);
    expected.push_back(total > 0.0 ? std::min(1.0, region.expected[k] / total) : 0.0);
  }
  return judge_coverage(region.count, expected, confidence);
}

/// NaN unless there are enough whole runs of one length for a correlation in time.
double effective_steps_of(const RunStatistics& runs, std::size_t steps) {
  constexpr std::size_t kEnough = 50;
  const auto whole = [steps](const std::vector<double>& run) { return run.size() == steps; };
  if (runs.nees.size() < kEnough || steps < 2 || !std::ranges::all_of(runs.nees, whole)) return kNaN;
  return measured_effective_steps(runs.nees);
}

VerdictDesign design_of(const ConsistencyVerdict& verdict, bool white, double effective_steps) {
  const auto steps = static_cast<double>(std::max<std::int64_t>(1, verdict.steps_tested));
  const double effective = std::isfinite(effective_steps) ? std::clamp(effective_steps, 1.0, steps) : 1.0;
  return {.steps = steps,
          .dof_per_step = verdict.expected,
          .confidence = verdict.confidence,
          .white = white,
          .effective_steps = white ? steps : effective};
}

SettlingRuns settle(const ConsistencyVerdict& verdict, bool white, double effective_steps) {
  if (verdict.steps_tested == 0) return {.detectable = {}, .reason = "no data"};
  const double runs = static_cast<double>(verdict.count) / static_cast<double>(verdict.steps_tested);
  return runs_to_settle(verdict, design_of(verdict, white, effective_steps), runs, kSettlingPower);
}

void judge_scales(const BatteryStatistics& s, const ConsistencyVerdict& nis, Battery& battery) {
  const RunStatistics& runs = s.whole_runs;
  const double expected =
      runs.nees.empty() ? 0.0 : runs.expected_nees_sum / static_cast<double>(runs.nees.size());
  battery.scale_covariance = expected > 0.0 ? scale_of_covariance(runs.nees_sum, expected, battery.confidence)
                                            : no_scale("no run ended well");
  battery.scale_innovation = scale_of_innovation(nis);
  const Moments& share = s.innovations.measurement_share;
  battery.scale_measurement_noise =
      share.count > 0 && share.mean > 0.0
          ? scale_of_measurement_noise(battery.scale_innovation, std::min(1.0, share.mean))
          : no_scale(share.count > 0 ? "R is zero" : "R is not known");
}

BatteryTest verdict_test(std::string name, const ConsistencyVerdict& v) {
  if (v.verdict == Verdict::undecided) return {std::move(name), kNaN, kNaN, v.reason};
  return {std::move(name), v.p_value, kNaN,
          fmt::format("mean {:.4g}, expected {:.4g}, {} tests", v.mean, v.expected, v.tests)};
}

std::vector<BatteryTest> list_tests(const Battery& b, const ConsistencyVerdict& nees,
                                    const ConsistencyVerdict& nis) {
  std::vector<BatteryTest> tests = {verdict_test("NEES", nees), verdict_test("NIS", nis)};
  for (const BlockVerdict& block : b.blocks)
    tests.push_back(verdict_test("NEES of " + block.name, block.verdict));
  for (std::size_t i = 0; i < b.coverage.size(); ++i) {
    const CoverageVerdict& c = b.coverage[i];
    const double share = c.pooled.total == 0
                             ? kNaN
                             : static_cast<double>(c.pooled.inside) / static_cast<double>(c.pooled.total);
    tests.push_back({fmt::format("coverage of {:g}σ", CoverageStatistics::kSigmas[i]),
                     c.tests == 0 ? kNaN : c.p_value, kNaN,
                     fmt::format("{:.4g} % inside, {:.4g} % expected", 100.0 * share, 100.0 * c.expected)});
  }
  const auto add = [&](const char* name, std::string_view reason, double p_value, std::string says) {
    tests.push_back({name, reason.empty() ? p_value : kNaN, kNaN,
                     reason.empty() ? std::move(says) : std::string(reason)});
  };
  add(kNisBody, b.nis_fit.reason, b.nis_fit.kolmogorov_p_value,
      fmt::format("Kolmogorov-Smirnov D = {:.3g} of {} values", b.nis_fit.kolmogorov, b.nis_fit.count));
  add(kNisTails, b.nis_fit.reason, b.nis_fit.anderson_p_value,
      fmt::format("Anderson-Darling A² = {:.3g}", b.nis_fit.anderson));
  add(kWhiteness, b.whiteness.reason, b.whiteness.p_value,
      fmt::format("portmanteau Q = {:.4g}, dof {:g}", b.whiteness.statistic, b.whiteness.dof));
  add(kInnovationMean, b.innovation_mean.reason, b.innovation_mean.p_value,
      fmt::format("largest {:.3g} σ",
                  b.innovation_mean.mean.size() > 0 ? b.innovation_mean.mean.cwiseAbs().maxCoeff() : 0.0));
  add("credibility of the vehicle's P", b.credibility.reason, b.credibility.p_value,
      fmt::format("inclination {:.3g} dB at the last step, noncredibility {:.3g} dB",
                  b.credibility.inclination, b.credibility.noncredibility));
  std::vector<double> p_values;
  p_values.reserve(tests.size());
  for (const BatteryTest& test : tests) p_values.push_back(test.p_value);
  const std::vector<double> adjusted = holm(p_values);
  for (std::size_t i = 0; i < tests.size(); ++i) tests[i].adjusted = adjusted[i];
  return tests;
}

/// Whether a test speaks against the filter when the whole battery is taken together; a cause named for less
/// would be a guess.
bool speaks(const Battery& battery, std::string_view name) {
  const auto test = std::ranges::find(battery.tests, name, &BatteryTest::name);
  return test != battery.tests.end() && test->adjusted <= 1.0 - battery.confidence;
}

std::vector<CauseFound> causes_of(const BatteryStatistics& s, const Battery& battery,
                                  const ConsistencyVerdict& nees, const ConsistencyVerdict& nis) {
  Findings findings{.nees = nees, .nis = nis};
  if (speaks(battery, kWhiteness)) findings.whiteness = battery.whiteness;
  if (speaks(battery, kInnovationMean)) findings.innovation_mean = battery.innovation_mean;
  if (speaks(battery, kNisBody) || speaks(battery, kNisTails)) findings.fit = battery.nis_fit;
  if (findings.fit) findings.far_tail = s.innovations.far_tail;
  findings.far_tail_probability = InnovationStatistics::kFarTail;
  findings.block = battery.responsible;
  findings.nees_values = s.whole_runs.nees_values;
  findings.nonlinear = s.shape.vehicle_dim == 3;  // the planar worlds
  if (const Moments& share = s.innovations.measurement_share; share.count > 0) {
    findings.measurement_noise_share = share.mean;
  }
  return find_causes(findings);
}

}  // namespace

Battery judge_battery(const BatteryStatistics& s, const ConsistencyVerdict& nees,
                      const ConsistencyVerdict& nis) {
  Battery battery;
  battery.runs = s.runs;
  battery.confidence = nees.confidence;
  battery.blocks = judge_blocks(s.blocks, battery.confidence);
  // Of the same runs as the blocks: all runs of a long study see what the blocks of fewer cannot.
  const BlockSeries& whole = s.blocks.whole();
  battery.responsible =
      responsible_block(judge_nees(whole.nees, whole.dof, battery.confidence), battery.blocks);
  battery.nis_fit = test_uniform(s.innovations.nis);
  battery.nis_histogram = s.innovations.nis.counts();
  battery.whiteness = test_whiteness(s.innovations.products, battery.confidence);
  battery.innovation_mean = test_innovation_mean(s.innovations.run_mean);
  for (std::size_t i = 0; i < battery.coverage.size(); ++i) {
    battery.coverage[i] = judge_region(s.coverage.regions[i], battery.confidence);
  }
  const RunStatistics& runs = s.whole_runs;
  battery.credibility =
      runs.last_vehicle_error.size() > static_cast<std::size_t>(s.shape.vehicle_dim)
          ? credibility_index(runs.last_vehicle_error, runs.last_vehicle_covariance, battery.confidence)
          : CredibilityIndex{.reason = "fewer whole runs than the vehicle has dimensions"};
  for (std::size_t i = 0; i < battery.rmse.size(); ++i) {
    battery.rmse[i] = rmse_interval(runs.squared_error[i], battery.confidence);
  }
  battery.effective_steps = effective_steps_of(runs, s.shape.steps);
  judge_scales(s, nis, battery);
  battery.settle_nees = settle(nees, false, battery.effective_steps);
  battery.settle_nis = settle(nis, true, battery.effective_steps);
  battery.tests = list_tests(battery, nees, nis);
  battery.causes = causes_of(s, battery, nees, nis);
  return battery;
}

}  // namespace credence
