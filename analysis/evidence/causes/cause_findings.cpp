#include "analysis/evidence/causes/cause_findings.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <iterator>
#include <limits>
#include <numeric>
#include <span>

#include "analysis/evidence/causes/white_errors.h"
#include "analysis/evidence/verdicts/judgement_tests.h"
#include "analysis/evidence/verdicts/series_verdicts.h"
#include "analysis/laws/chi_square/chi_square.h"
#include "analysis/laws/correlation/opposed_moments.h"
#include "analysis/laws/correlation/sample_correlation.h"
#include "analysis/laws/mean/effective_sample.h"
#include "analysis/laws/mean/student.h"
#include "analysis/laws/shape/second_moments.h"
#include "core/append_item.h"

namespace credence::internal {
namespace {

/// NIS of one dimension that ends where the law of χ², scaled to its mean, has many values left. No factor on
/// S does that, at a probability of 2e-9, but a gate does, whatever the scale.
std::optional<Findings::CutOff> cut_off_of(const SensorSums& sums, const SensorJudgement& s) {
  constexpr double kFewest = 20.0;
  if (sums.by_dimension.size() != 1 || s.nis.verdict != Verdict::pessimistic) return std::nullopt;
  const auto& [dim, values] = *sums.by_dimension.begin();
  const auto dof = static_cast<double>(dim);
  const double scale = values.value.mean / dof;
  if (!(scale > 0.0)) return std::nullopt;
  const double expected =
      static_cast<double>(values.value.count) * chi_square_survival(sums.largest_nis / scale, dof);
  if (!(expected >= kFewest)) return std::nullopt;
  return Findings::CutOff{sums.largest_nis, expected};
}

/// The most wrong component of a sensor, where the others have other factors, beyond both intervals: what is
/// wrong in all components alike is no matter of one.
std::optional<Findings::WrongComponent> wrong_component_of(const SensorSums& sums, const SensorJudgement& s) {
  const std::vector<ComponentVariance>& all = s.components.components;
  const auto worst = static_cast<std::size_t>(s.components.worst);
  const ComponentVariance& most = all[worst];
  const auto distance = [&most](double mean) { return std::abs(std::log(mean / most.mean)); };
  std::optional<double> nearest;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (i == worst || all[i].count == 0) continue;
    const bool apart = most.mean > 1.0 ? most.lower > all[i].mean && most.mean > all[i].upper
                                       : most.upper < all[i].mean && most.mean < all[i].lower;
    if (!apart) return std::nullopt;
    if (!nearest || distance(all[i].mean) < distance(*nearest)) nearest = all[i].mean;
  }
  if (!nearest) return std::nullopt;
  Moments factors;
  for (const ComponentVariance& component : all)
    if (component.count > 0) factors.add(component.mean);
  return Findings::WrongComponent{component_name(s, s.components.worst),
                                  s.name,
                                  most,
                                  *nearest,
                                  sums.measurement_share.count > 0 ? sums.measurement_share.mean : kNaN,
                                  s.nis.mean / s.nis.expected,
                                  factors.mean};
}

/// Of a component that is larger and one that is smaller, each by its own noise, R turns the innovations of
/// the large one back and those of the small one on, and Q the other way round.
double opposed_lags(const LagProducts& lags, Index large, Index small) {
  if (lags.pairs(0) == 0 || lags.pairs(1) == 0 || std::max(large, small) >= lags.dim()) return 0.0;
  const Matrix together = lags.product(0), next = lags.product(1);
  const auto lag_1 = [&](Index i) {
    return next(i, i) / static_cast<double>(lags.pairs(1)) * static_cast<double>(lags.pairs(0)) /
           together(i, i);
  };
  return (lag_1(large) - lag_1(small)) * std::sqrt(0.5 * static_cast<double>(lags.pairs(1)));
}

/// The components of a sensor that are farthest from S, where one is clearly larger and another smaller.
std::optional<Findings::OpposedComponents> opposed_components_of(const SensorSums& sums,
                                                                 const SensorJudgement& s) {
  constexpr double kClearly = 1.2;
  const std::vector<ComponentVariance>& all = s.components.components;
  const auto place = [&all](auto of) { return static_cast<Index>(of - all.begin()); };
  const Index large = place(std::ranges::max_element(
                  all, {}, [](const auto&c) { return c.count > 0 ? c.lower : -1.0; })),
              small = place(std::ranges::min_element(all, {}, [](const auto&c) {
                return c.count > 0 ? c.upper : std::numeric_limits<double>::infinity();
              }));
  const ComponentVariance &larger = all[static_cast<std::size_t>(large)],
                          &smaller = all[static_cast<std::size_t>(small)];
  if (!(larger.lower > kClearly) || !(smaller.upper < 1.0 / kClearly)) return std::nullopt;
  return Findings::OpposedComponents{component_name(s, large),
                                     component_name(s, small),
                                     larger,
                                     smaller,
                                     sums.varies ? 0.0 : opposed_lags(sums.lags.of_values(), large, small),
                                     sums.measurement_share.count > 0 ? sums.measurement_share.mean : kNaN};
}

/// Whether another sensor is as wrong, of which the component is not then the most wrong part.
bool is_outdone(const Findings::WrongComponent& component, const Findings& findings) {
  return std::ranges::any_of(findings.wrong_sensors, [&](const Findings::WrongSensor& of) {
    return of.name != component.sensor &&
           std::abs(std::log(of.nis)) >= std::abs(std::log(component.factor.mean));
  });
}

/// The most wrong pair of a sensor, where its sum and difference are wrong otherwise, beyond both intervals.
std::optional<Findings::WrongPair> wrong_pair_of(const SensorSums& sums, const SensorJudgement& s) {
  const Index of_sum = s.pairs.worst - s.pairs.worst % 2, of_difference = of_sum + 1;
  const auto at = [&](Index i) { return s.pairs.components[static_cast<std::size_t>(i)]; };
  const ComponentVariance sum = at(of_sum), difference = at(of_difference);
  if (!(sum.lower > difference.upper || difference.lower > sum.upper)) return std::nullopt;
  return Findings::WrongPair{pair_name(s, of_sum), pair_name(s, of_difference), sum, difference,
                             sums.measurement_share.count > 0 ? sums.measurement_share.mean : kNaN};
}

/// What speaks of one sensor.
void add_sensor_findings(const SensorSums& sums, const SensorJudgement& s, const Judgement& j, Findings& f) {
  // A correlation of NIS does not tell by its sign what causes it.
  const bool not_white = !sums.sensor.nis_alone && speaks(j, of_sensor(kWhiteness, s));
  // Of several sensors the one that is most correlated with itself.
  const auto lag_1 = [](const WhitenessTest& test) { return std::abs(test.autocorrelation.at(0)); };
  const bool largest =
      !f.whiteness || (not_white && (!f.not_white || lag_1(s.whiteness) > lag_1(*f.whiteness)));
  if (largest && !sums.sensor.nis_alone) {
    f.whiteness = s.whiteness;
    f.whiteness_nis = s.nis.mean / s.nis.expected;
  }
  f.not_white = f.not_white || not_white;
  if (speaks(j, of_sensor(kComponents, s))) {
    const auto wrong = wrong_component_of(sums, s);
    const auto size = [](const Findings::WrongComponent& of) { return std::abs(std::log(of.factor.mean)); };
    if (wrong && (!f.wrong_component || size(*wrong) > size(*f.wrong_component))) f.wrong_component = wrong;
    const auto opposed = opposed_components_of(sums, s);
    const auto apart = [](const Findings::OpposedComponents& of) { return of.large.mean / of.small.mean; };
    if (opposed && (!f.opposed_components || apart(*opposed) > apart(*f.opposed_components)))
      f.opposed_components = opposed;
  }
  if (speaks(j, of_sensor(kPairs, s)) && !speaks(j, of_sensor(kComponents, s))) {
    const auto wrong = wrong_pair_of(sums, s);
    const auto size = [](const Findings::WrongPair& of) {
      return std::abs(std::log(of.sum.mean / of.difference.mean));
    };
    if (wrong && (!f.wrong_pair || size(*wrong) > size(*f.wrong_pair))) f.wrong_pair = wrong;
  }
  // Of many sensors one rejects by itself where nothing is wrong: as take_back has it.
  if (j.sensors.size() > 1 && !sums.sensor.nis_alone && is_inconsistent(s.nis.verdict) &&
      is_inconsistent(j.word.verdict))
    f.wrong_sensors.push_back({s.name, s.nis.mean / s.nis.expected, s.whiteness,
                               sums.measurement_share.count > 0 ? sums.measurement_share.mean : kNaN});
  if (speaks(j, of_sensor(kInnovationMean, s)) &&
      (!f.innovation_mean || s.mean.p_value < f.innovation_mean->p_value))
    f.innovation_mean = s.mean;
  if (s.gate && !s.gate->known) f.gate = s.gate;
  if (const auto cut_off = s.gate ? std::nullopt : cut_off_of(sums, s);
      cut_off && (!f.cut_off || cut_off->expected > f.cut_off->expected))
    f.cut_off = cut_off;
  if (s.perhaps_gate && s.nis.verdict == Verdict::pessimistic) f.perhaps_gate = s.perhaps_gate;
  // Bonferroni over the sensors; NaN stays.
  const auto of_all = [&j](double p) { return std::min(1.0, static_cast<double>(j.sensors.size()) * p); };
  // Of one run, whose P may change in time by itself, NIS that does looks as if P answered it.
  const bool in_time = j.runs == 1 && s.over_time.p_value <= 1.0 - j.confidence;
  if (auto rejection = find_gate_rejection(sums.changes); rejection && !in_time) {
    rejection->p_value = of_all(rejection->p_value);
    if (!f.rejection || rejection->p_value < f.rejection->p_value) f.rejection = rejection;
  }
  ZeroMeanTest first = test_zero_mean(sums.first);
  first.p_value = of_all(first.p_value);
  if (first.reason.empty() && (!f.first_innovation || first.p_value < f.first_innovation->p_value))
    f.first_innovation = first;
  if (!speaks(j, of_sensor(kNisBody, s)) && !speaks(j, of_sensor(kNisTails, s))) return;
  const auto beyond = [](const CoverageCount& tail) {
    return static_cast<double>(tail.total - tail.inside) / static_cast<double>(tail.total);
  };
  if (f.far_tail && !(beyond(sums.far_tail) > beyond(*f.far_tail))) return;
  f.fit = s.fit;
  f.far_tail = sums.far_tail;
  f.far_tail_nis = {s.nis.mean, s.nis.expected};
}

/// A verdict that the word has taken back when it joined all says nothing of a cause.
void take_back(const Word& word, ConsistencyVerdict& verdict) {
  if (!is_inconsistent(word.verdict) && is_inconsistent(verdict.verdict))
    verdict.verdict = Verdict::consistent;
}

Findings::GrossOutliers gross_outliers_of(const Evidence& e) {
  Findings::GrossOutliers gross;
  std::int64_t early = 0, all = 0;
  const std::size_t steps = e.study.steps.size();
  for (std::size_t k = 0; k < steps; ++k) {
    const std::int64_t values = e.study.steps[k][Quantity::nis].count;
    const std::int64_t clean = k < e.clean_nis.size() ? e.clean_nis[k].value.count : 0;
    all += values;
    gross.all += values - clean;
    gross.at_steps.push_back(values - clean);
    if (k < steps / 5) {
      early += values;
      gross.early += values - clean;
    } else if (k >= steps / 2) {
      gross.late.merge({.inside = clean, .total = values});
    }
  }
  gross.early_share = all > 0 ? static_cast<double>(early) / static_cast<double>(all) : 0.0;
  return gross;
}

/// Of the step before the first innovation of any run; empty where the first step has one, or of a map, whose
/// landmarks begin with measurements that make no innovation.
Moments nees_before_innovations(const Evidence& e) {
  const auto& steps = e.study.steps;
  const auto first =
      std::ranges::find_if(steps, [](const StepStatistics& step) { return step[Quantity::nis].count > 0; });
  const bool of_map = std::ranges::any_of(
      e.blocks, [](const BlockSums& b) { return b.part == Part::landmark || b.part == Part::map; });
  if (of_map || first == steps.begin() || first == steps.end()) return {};
  return (*std::prev(first))[Quantity::nees];
}

void add_growth(const Evidence& e, Findings& f) {
  const auto& steps = e.study.steps;
  if (e.step_stride > 1) return;
  const auto speaks_at = [](const StepStatistics& step) { return step[Quantity::nis].count > 0; };
  const auto before = static_cast<std::size_t>(std::ranges::find_if(steps, speaks_at) - steps.begin());
  VectorMoments ends;  // ln NEES of each run at the first and the last step before any innovation
  for (const std::vector<double>& nees : e.whole_runs.nees) {
    if (nees.size() != steps.size()) continue;
    double without = 0.0, with = 0.0, mean = 0.0;
    for (std::size_t k = 0; k < before; ++k) mean += nees[k] / static_cast<double>(before);
    if (f.nees_before_innovations.count > 0) {
      f.nees_of_runs_before_innovations.add(mean);
      ends.add(Vector{{std::log(nees.front()), std::log(nees[before - 1])}});
    }
    for (std::size_t k = 1; k < nees.size(); ++k) {
      (speaks_at(steps[k]) ? with : without) += nees[k] - nees[k - 1];
      if (k + 1 == before) f.growth_before_innovations.add(without);
    }
    if (const std::span<const double> all = nees; all.size() >= 5)
      f.growth.add(average_of(all.subspan(all.size() / 2)) - average_of(all.first(all.size() / 5)));
    f.growth_without_innovations.add(without);
    f.growth_with_innovations.add(with);
  }
  constexpr std::int64_t kFewestRuns = 10;
  if (before < 2 || ends.count < kFewestRuns) return;
  if (const auto correlation = sample_correlation(ends)) f.kept_before_innovations = (*correlation)(0, 1);
}

/// The group of each state: those of a group are correlated with each other, if only through others, by what
/// P claims at some step of some run, and with no other state. There u = R^{-1/2} D⁻¹ e has of a group the
/// errors of it alone.
std::vector<Index> claimed_groups(const LawSums& law) {
  std::vector<Index> group(static_cast<std::size_t>(law.second_moments.dim()));
  std::iota(group.begin(), group.end(), Index{0});
  for (std::size_t p = 1; p < group.size(); ++p) {
    for (std::size_t q = 0; q < p; ++q) {
      if (!law.correlated[pair_of(static_cast<Index>(p), static_cast<Index>(q))]) continue;
      const auto [joined, other] = std::minmax(group[p], group[q]);
      std::ranges::replace(group, Index(other), Index(joined));
    }
  }
  return group;
}

/// Whether errors that P claims to be uncorrelated are, over all steps of the runs: of A_pq, the average of
/// u_p u_q over a run, or a stretch of few, which is half the difference of those along (e_p ± e_q)/√2. These
/// two do not vary against each other where u_p and u_q are independent, so that their variances add up to
/// one that is no less; Student's t, Bonferroni over the pairs. None where P claims no such thing; a reason
/// for a state too large for A, or too few runs.
std::optional<ErrorCorrelationTest> test_claimed_uncorrelated(const Evidence& e, const Judgement& j) {
  constexpr std::int64_t kFewestRuns = 10;
  const SecondMoments second = moments_tested(e, j.law.second_moments);
  if (!e.joint_covariance || std::ssize(e.layout.states) < 2) return std::nullopt;
  ErrorCorrelationTest result{.runs = second.runs(), .p_value = 1.0};
  if (std::ssize(e.layout.states) > largest_averaged(e.layout)) {
    result.reason = "too many states";
  } else if (second.runs() == 0) {
    result.reason = "no row has the errors of all states";
  } else if (second.runs() < kFewestRuns) {
    result.reason = "fewer than 10 runs, and no stretches of them that are independent";
  }
  if (!result.reason.empty()) {
    result.p_value = kNaN;
    return result;
  }
  if (!e.law.averaged.empty() || second.dim() != std::ssize(e.layout.states)) return std::nullopt;
  if (e.law.correlated.size() != pair_of(second.dim(), 0)) return std::nullopt;
  const std::vector<Index> group = claimed_groups(e.law);
  const std::vector<SecondMomentDirection> directions = second_moment_directions(second.dim());
  const auto runs = static_cast<double>(second.runs());
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const auto& [p, q, sign] = directions[i];
    if (sign <= 0 || group[static_cast<std::size_t>(p)] == group[static_cast<std::size_t>(q)]) continue;
    const SkewedMoments &sum = second.along()[i], &difference = second.along()[i + 1];
    const double covariance = 0.5 * (sum.mean - difference.mean);
    const double variance = 0.25 * (sum.m2 + difference.m2) / (runs - 1.0);
    if (!(variance > 0.0)) continue;
    const double squares = second.along()[static_cast<std::size_t>(p * p)].mean *
                           second.along()[static_cast<std::size_t>(q * q)].mean;
    result.dof += 1.0;
    result.largest = std::max(result.largest, std::abs(covariance) / std::sqrt(squares));
    const double t = covariance / std::sqrt(variance / runs);
    result.p_value = std::min(result.p_value, student_two_sided_p_value(t, runs - 1.0));
  }
  if (result.dof == 0.0) return std::nullopt;
  result.p_value = std::min(1.0, result.dof * result.p_value);
  return result;
}

std::string unmarked_angles_of(const Evidence& e) {
  std::string text;
  for (const auto& [state, errors] : e.turns) {
    if (const auto turns = turns_off(errors)) append_item(text, turns_text(state, *turns), "; ");
  }
  for (const SensorSums& s : e.sensors) {
    const std::string of_sensor = turns_text(s.sensor.name, s.turns);
    if (!of_sensor.empty()) append_item(text, of_sensor, "; ");
  }
  return text;
}

/// Whether P is the same in all of several runs at each step: nothing then depends on what was measured, as a
/// gate would make it, and P changes with NIS because both change with time.
bool has_one_covariance(const StudyStatistics& study) {
  constexpr double kRounding = 1e-12;
  bool several = false;
  for (const Moments& trace : study.series(Quantity::trace)) {
    if (trace.count < 2) continue;
    several = true;
    if (!(std::sqrt(trace.variance()) <= kRounding * std::abs(trace.mean))) return false;
  }
  return several;
}

}  // namespace

Findings findings_of(const Evidence& e, const Judgement& j) {
  Findings findings{.nees = j.nees, .nis = j.nis};
  take_back(j.word, findings.nees);
  take_back(j.word, findings.nis);
  findings.inflated = e.layout.inflated;
  Moments share;
  for (std::size_t i = 0; i < j.sensors.size(); ++i) {
    add_sensor_findings(e.sensors[i], j.sensors[i], j, findings);
    findings.unwrapped_innovations += e.sensors[i].unwrapped;
    share.merge(e.sensors[i].measurement_share);
  }
  if (has_one_covariance(e.study)) findings.rejection.reset();
  findings.unmarked_angles = unmarked_angles_of(e);
  findings.far_tail_probability = SensorSums::kFarTail;
  findings.gross_outliers = gross_outliers_of(e);
  if (findings.far_tail && findings.gross_outliers.all > 0) {  // which only outliers are told by
    // Sensors taken in turn are independent where they fit; the bound for every dependence would let too much
    // pass.
    const StepSeries clean = series_of(e.clean_nis, e.study.steps.size());
    findings.gross_outliers.rest_fits =
        judge_nis(clean.moments, clean.dof, j.confidence).verdict == Verdict::consistent;
  }
  std::ranges::stable_sort(findings.wrong_sensors, std::ranges::greater{},
                           [](const auto& sensor) { return std::abs(std::log(sensor.nis)); });
  if (findings.wrong_component && is_outdone(*findings.wrong_component, findings))
    findings.wrong_component.reset();
  findings.narrow_angles = e.narrow_angles;
  if (speaks(j, kErrorMean)) findings.error_mean = {j.law.error_mean.test, j.law.error_mean.largest};
  findings.error_mean_runs = j.law.error_mean.test.count;
  findings.mean_at_steps = test_mean_at_steps(e.law.whitened);
  findings.block = j.responsible;
  findings.any_block_is_wrong = any_block_is_wrong(j);
  findings.claimed_sigma = j.claimed_sigma;
  findings.lost = j.lost;
  findings.error_correlation = test_claimed_uncorrelated(e, j);
  findings.nees_values = e.whole_runs.nees_values;
  if (e.step_stride == 1) findings.white_share = white_share_of(e.whole_runs.nees);
  findings.nees_before_innovations = nees_before_innovations(e);
  add_growth(e, findings);
  findings.nonlinear = e.layout.nonlinear;
  findings.lateness = test_lateness(e.lateness);
  if (share.count > 0) findings.measurement_noise_share = share.mean;
  for (std::size_t i = 0; i < e.sensor_pairs.size(); ++i) {
    const SensorPairJudgement& pair = j.law.sensor_pairs[i];
    if (!speaks(j, pair_test(pair))) continue;
    const double opposed = opposed_moments_p_value(e.sensor_pairs[i].both, e.sensor_pairs[i].first_dim);
    findings.sensor_pairs.push_back({pair.first, pair.second, pair.correlation, opposed});
  }
  const GaussianityJudgement& g = j.law.gaussianity;
  const bool open = j.word.verdict == Verdict::undecided;  // as where innovations are not white
  if (!open && j.lost.runs.empty() && speaks(j, kHeavyTails) &&
      g.right_but_heavy_tailed(1.0 - j.confidence)) {
    findings.heavy_tail_p_value = g.tail_p_value;
  }
  return findings;
}

}  // namespace credence::internal
