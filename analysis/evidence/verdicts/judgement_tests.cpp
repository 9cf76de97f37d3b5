#include "analysis/evidence/verdicts/judgement_tests.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "analysis/laws/joint/multiple_tests.h"
#include "core/append_item.h"
#include "core/nan.h"
#include "core/number_text.h"

namespace credence::internal {
namespace {

NamedTest verdict_test(std::string name, const ConsistencyVerdict& v) {
  if (v.verdict == Verdict::undecided)
    return {std::move(name), Exactness::conservative, kNaN, kNaN, v.reason};
  return {
      std::move(name), Exactness::conservative, v.p_value, kNaN,
      fmt::format("mean {}, expected {}, {} tests", number_text(v.mean), number_text(v.expected), v.tests)};
}

/// A test with a reason where it was not made.
NamedTest reasoned_test(std::string name, Exactness exactness, std::string_view reason, double p_value,
                        std::string says) {
  if (!reason.empty()) return {std::move(name), exactness, kNaN, kNaN, std::string(reason)};
  return {std::move(name), exactness, p_value, kNaN, std::move(says)};
}

void list_sensor(const SensorJudgement& s, bool alone, std::vector<NamedTest>& tests) {
  if (!alone) tests.push_back(verdict_test("NIS of " + s.name, s.nis));
  tests.push_back(reasoned_test(
      of_sensor(kNisBody, s), Exactness::conservative, s.fit.reason, s.fit.kolmogorov_p_value,
      fmt::format("Kolmogorov-Smirnov D = {} of {} values", number_text(s.fit.kolmogorov, 3), s.fit.count)));
  tests.push_back(reasoned_test(of_sensor(kNisTails, s), Exactness::approximate, s.fit.reason,
                                s.fit.anderson_p_value,
                                fmt::format("Anderson-Darling A² = {}", number_text(s.fit.anderson, 3))));
  tests.push_back(reasoned_test(
      of_sensor(kWhiteness, s), Exactness::approximate, s.whiteness.reason, s.whiteness.p_value,
      fmt::format("portmanteau Q = {}, dof {:g}", number_text(s.whiteness.statistic), s.whiteness.dof)));
  const double largest = s.mean.mean.size() > 0 ? s.mean.mean.cwiseAbs().maxCoeff() : 0.0;
  tests.push_back(reasoned_test(of_sensor(kInnovationMean, s), Exactness::exact, s.mean.reason,
                                s.mean.p_value, fmt::format("largest {} σ", number_text(largest, 3))));
  if (!std::isnan(s.over_time.p_value)) {
    tests.push_back({of_sensor(kNisOverTime, s), Exactness::approximate, s.over_time.p_value, kNaN,
                     "waves and slow changes of its ranks"});
  }
  const auto add = [&](const char* name, const ComponentTest& test, const auto& says) {
    if (test.components.empty()) return;
    tests.push_back(reasoned_test(of_sensor(name, s), Exactness::conservative, test.reason,
                                  std::min(test.p_value.optimistic, test.p_value.pessimistic),
                                  says(test.components[static_cast<std::size_t>(test.worst)])));
  };
  add(kComponents, s.components, [&s](const ComponentVariance& worst) {
    return fmt::format("{} squared is {} ({} … {}) times its S", component_name(s, s.components.worst),
                       number_text(worst.mean, 3), number_text(worst.lower, 3), number_text(worst.upper, 3));
  });
  add(kPairs, s.pairs, [&s](const ComponentVariance& worst) {
    return fmt::format("times {} ({} … {}) in the direction of {}", number_text(worst.mean, 3),
                       number_text(worst.lower, 3), number_text(worst.upper, 3), pair_name(s, s.pairs.worst));
  });
}

/// The p-values of those tests of tails that were made.
std::string tails_say(const GaussianityJudgement& g) {
  const std::pair<const char*, double> made[] = {
      {"errors", g.nees_tail_p_value}, {"NIS", g.nis_tail_p_value}, {"NIS far out", g.far_nis_p_value}};
  std::string text;
  for (const auto& [name, p_value] : made) {
    if (!std::isnan(p_value)) append_item(text, fmt::format("{} p = {}", name, number_text(p_value, 3)));
  }
  return text;
}

void list_law(const LawJudgement& law, bool has_truth, std::vector<NamedTest>& tests) {
  for (const SensorPairJudgement& pair : law.sensor_pairs) {
    tests.push_back(reasoned_test(
        pair_test(pair), Exactness::approximate, pair.correlation.reason, pair.correlation.p_value,
        fmt::format("largest {} of {} steps", number_text(pair.correlation.largest, 3),
                    pair.correlation.values)));
  }
  const GaussianityJudgement& g = law.gaussianity;
  tests.push_back(reasoned_test(
      kHeavyTails, Exactness::conservative,
      std::isnan(g.tail_p_value) ? "fewer than ten runs, and too few rows of them that are independent" : "",
      g.tail_p_value, tails_say(g)));
  if (!has_truth) return;
  const SecondMomentTest& second = law.second_moments.test;
  tests.push_back(
      reasoned_test("second moments of the errors", Exactness::conservative, second.reason,
                    std::min(second.p_value.optimistic, second.p_value.pessimistic),
                    fmt::format("times {} ({} … {}) in the direction of {}",
                                number_text(second.worst.mean, 3), number_text(second.worst.lower, 3),
                                number_text(second.worst.upper, 3), law.second_moments.worst)));
  const ZeroMeanTest& mean = law.error_mean.test;
  tests.push_back(
      reasoned_test(kErrorMean, Exactness::exact, mean.reason, mean.p_value,
                    mean.mean.size() > 0
                        ? fmt::format("largest {} σ, of {}", number_text(mean.mean.cwiseAbs().maxCoeff(), 3),
                                      law.error_mean.largest)
                        : ""));
  const ShapeJudgement& shape = law.shape;
  const auto factor = [&](Index i) {
    const Vector& all = shape.shape.factors;
    return all.size() > 0 ? all[i < 0 ? all.size() - 1 : i] : kNaN;
  };
  tests.push_back(
      reasoned_test("shape of P", Exactness::approximate, shape.reason, shape.p_value,
                    fmt::format("factors {} to {} over the directions at step {}", number_text(factor(0), 3),
                                number_text(factor(-1), 3), shape.step)));
}

/// The share over all steps, which may be as expected, and where it is not the step that decided.
std::string coverage_says(const Judgement& j, const CoverageVerdict& c) {
  const double share = static_cast<double>(c.pooled.inside) / static_cast<double>(c.pooled.total);
  std::string says =
      fmt::format("{} % inside, {} % expected", number_text(100.0 * share), number_text(100.0 * c.expected));
  if (c.p_value > 1.0 - j.confidence || c.worst_step < 0) return says;
  const CoverageStep& step = c.steps[static_cast<std::size_t>(c.worst_step)];
  ConsistencyVerdict steps;
  steps.step_stride = j.step_stride;
  steps.times = j.nees.times;
  return says + fmt::format("; what decided is {}, with {} of {} inside and {} % expected",
                            steps.text_of_step(c.worst_step + 1), step.count.inside,
                            counted(step.count.total, "run"), number_text(100.0 * step.expected));
}

void list_errors(const Evidence& e, const Judgement& j, std::vector<NamedTest>& tests) {
  for (std::size_t i = 0; i < j.coverage.size(); ++i) {
    const CoverageVerdict& c = j.coverage[i];
    if (c.tests == 0) continue;
    tests.push_back({fmt::format("coverage of {:g}σ", CoverageSums::kSigmas[i]), Exactness::conservative,
                     c.p_value, kNaN, coverage_says(j, c)});
  }
  tests.push_back(reasoned_test(
      e.layout.blocks.empty() ? "credibility of P" : "credibility of P in " + e.layout.blocks.front().name,
      Exactness::approximate, j.credibility.reason, j.credibility.p_value,
      fmt::format("inclination {} dB at the last step, noncredibility {} dB",
                  number_text(j.credibility.inclination, 3), number_text(j.credibility.noncredibility, 3))));
  tests.push_back(reasoned_test(
      kErrorCorrelation, Exactness::approximate, j.error_correlation.reason, j.error_correlation.p_value,
      fmt::format("largest {} at the last step, dof {:g}", number_text(j.error_correlation.largest, 3),
                  j.error_correlation.dof)));
}

}  // namespace

std::string over_time_test(const NeesOverTime& nees) {
  return nees.of.empty() ? "NEES over time" : fmt::format("NEES of {} over time", nees.of);
}

std::string pair_test(const SensorPairJudgement& pair) {
  return fmt::format("innovations of {} and {} at one step", pair.first, pair.second);
}

std::string of_sensor(const char* test, const SensorJudgement& sensor) {
  return sensor.name.empty() ? test : fmt::format("{} of {}", test, sensor.name);
}

std::string component_name(const SensorJudgement& sensor, Index component) {
  return fmt::format("component {} of {}", component + 1,
                     sensor.name.empty() ? "the innovation" : sensor.name);
}

std::string pair_name(const SensorJudgement& sensor, Index direction) {
  Index q = direction / 2, p = 1;
  for (; q >= p; ++p) q -= p;
  return fmt::format("components {} {} {} of {}", q + 1, direction % 2 == 0 ? "+" : "−", p + 1,
                     sensor.name.empty() ? "the innovation" : sensor.name);
}

std::vector<NamedTest> list_tests(const Evidence& e, const Judgement& j) {
  std::vector<NamedTest> tests;
  if (e.has_truth) tests.push_back(verdict_test("NEES", j.nees));
  for (const NeesOverTime& nees : j.nees_over_time) {
    tests.push_back({over_time_test(nees), Exactness::conservative, nees.p_value, kNaN,
                     fmt::format("waves of {:.0f} rows speak most", nees.wave)});
  }
  tests.push_back(verdict_test("NIS", j.nis));
  for (const BlockVerdict& block : j.blocks)
    tests.push_back(verdict_test("NEES of " + block.name, block.verdict));
  for (const SensorJudgement& sensor : j.sensors) list_sensor(sensor, j.sensors.size() == 1, tests);
  if (e.has_truth) list_errors(e, j, tests);
  list_law(j.law, e.has_truth, tests);
  std::vector<double> p_values;
  p_values.reserve(tests.size());
  for (const NamedTest& test : tests) p_values.push_back(test.p_value);
  const std::vector<double> adjusted = holm(p_values);
  for (std::size_t i = 0; i < tests.size(); ++i) tests[i].adjusted = adjusted[i];
  return tests;
}

bool speaks(const Judgement& j, std::string_view name) {
  const auto test = std::ranges::find(j.tests, name, &NamedTest::name);
  return test != j.tests.end() && test->adjusted <= 1.0 - j.confidence;
}

bool any_block_is_wrong(const Judgement& j) {
  return std::ranges::any_of(
      j.blocks, [](const BlockVerdict& block) { return is_inconsistent(block.verdict.verdict); });
}

}  // namespace credence::internal
