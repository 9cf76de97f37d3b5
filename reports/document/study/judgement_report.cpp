#include "reports/document/study/judgement_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "analysis/evidence/causes/advice.h"
#include "analysis/evidence/verdicts/judgement_tests.h"
#include "core/append_item.h"
#include "core/nan.h"
#include "core/number_text.h"
#include "reports/document/shown_unit.h"
#include "reports/figures/step_axis.h"

namespace credence::internal {
namespace {

std::string factor_text(const ScaleAdvice& scale) {
  return fmt::format("{} ({} … {})", number_text(scale.factor, 3), number_text(scale.lower, 3),
                     number_text(scale.upper, 3));
}

/// Two digits of a share in percent, without an exponent.
std::string percent_text(double share) {
  const double percent = 100.0 * share;
  return percent < 99.5 ? fmt::format("{:.2g}", percent) : number_text(percent, 2);
}

/// "25 %", and of what is beyond ten times in words.
std::string off_by_text(double share) {
  constexpr double kWrittenOut = 9.0;
  return share > kWrittenOut ? "more than a factor of ten" : percent_text(share) + " %";
}

/// By how much the truth is more than what is claimed, or the claim more than the truth: 1.25 and 0.8 are
/// both off by a quarter.
double off_by(double factor) { return std::max(factor, 1.0 / factor) - 1.0; }

void advise_settling(const char* what, const char* matrix, const SettlingRuns& settle, std::int64_t runs,
                     std::vector<std::string>& sentences) {
  if (settle.runs == 0) return;
  sentences.push_back(fmt::format(
      "{0}: {8} would have revealed {1} too small by {2} or too large by {3}; to reveal the {5} % "
      "by which it looks too {4} would take {6} runs (power {7:g} %).",
      what, matrix, off_by_text(off_by(settle.detectable.above)),
      off_by_text(off_by(settle.detectable.below)), settle.observed_factor > 1.0 ? "small" : "large",
      percent_text(off_by(settle.observed_factor)), settle.runs, 100.0 * kSettlingPower,
      runs == 1 ? "this run" : "these runs"));
}

std::string titled(const char* what, const SensorJudgement& sensor) {
  return sensor.name.empty() ? what : fmt::format("{}: {}", what, sensor.name);
}

Panel histogram_panel(const SensorJudgement& sensor) {
  constexpr std::size_t kBars = 32;
  const std::vector<std::int64_t>& counts = sensor.histogram;
  const std::size_t merged = counts.size() / kBars;
  std::int64_t total = 0;
  for (const std::int64_t count : counts) total += count;
  FigureData x, density;
  for (std::size_t i = 0; i < kBars; ++i) {
    std::int64_t in_bar = 0;
    for (std::size_t j = 0; j < merged; ++j) in_bar += counts[i * merged + j];
    x.push_back(static_cast<double>(i) / kBars);
    density.push_back(total > 0 ? static_cast<double>(in_bar) * kBars / static_cast<double>(total) : kNaN);
  }
  x.push_back(1.0);
  density.push_back(density.back());
  const double spread = 2.0 * std::sqrt((kBars - 1.0) / std::max(1.0, static_cast<double>(total)));
  Panel panel{.title = titled("NIS against its law", sensor), .x_label = "F(NIS)", .y_label = "density"};
  panel.x_range = AxisRange{0.0, 1.0};
  panel.series.push_back(band_series("±2σ expected", ColourRole::bound, {0.0, 1.0},
                                     {1.0 - spread, 1.0 - spread}, {1.0 + spread, 1.0 + spread}));
  panel.series.push_back(step_series("measured", ColourRole::first, x, density));
  return panel;
}

Panel correlation_panel(const SensorJudgement& sensor, bool nis_alone, double confidence) {
  const WhitenessTest& w = sensor.whiteness;
  FigureData x, upper, lower;
  for (std::size_t h = 0; h < w.autocorrelation.size(); ++h) {
    x.push_back(static_cast<double>(h + 1));
    upper.push_back(w.band[h]);
    lower.push_back(-w.band[h]);
  }
  Panel panel{.title = titled("Whiteness", sensor),
              .x_label = "lag (steps)",
              .y_label = nis_alone ? figure_markup("autocorrelation of Φ^{−1}(F(NIS))")
                                   : FigureText("autocorrelation of innovation")};
  panel.x_range = AxisRange{0.0, static_cast<double>(x.size()) + 1.0};  // no point on the frame
  panel.series.push_back(
      band_series(fmt::format("{:g} %", 100.0 * confidence), ColourRole::bound, x, lower, upper));
  panel.series.push_back(point_series("measured", ColourRole::first, x, w.autocorrelation));
  return panel;
}

/// Whether a region holds the truth often enough, at half of the steps at least, to be worth looking at: of
/// many states almost none lies within 1σ in all of them.
bool tells(const CoverageVerdict& coverage) {
  constexpr double kLeast = 0.01;
  const auto enough = std::ranges::count_if(coverage.steps, [](const CoverageStep& step) {
    return step.count.total > 0 && step.expected >= kLeast;
  });
  return enough > 0 && 2 * enough >= coverage.tests;
}

/// Whether the truth of all runs inside, or of none, on the side where the share of it is, would fail at some
/// step: of few runs and a share expected near 0 or 1 it cannot.
bool can_fail(const CoverageVerdict& coverage, double alpha) {
  const CoverageCount& all = coverage.pooled;
  const bool too_few = static_cast<double>(all.inside) < coverage.expected * static_cast<double>(all.total);
  return std::ranges::any_of(coverage.steps, [&](const CoverageStep& step) {
    const double of_one = too_few ? 1.0 - step.expected : step.expected;
    const double p_value = 2.0 * std::pow(of_one, static_cast<double>(step.count.total));
    return step.count.total > 0 && p_value * static_cast<double>(coverage.tests) <= alpha;
  });
}

Panel coverage_panel(const Judgement& j) {
  const StepTimes* const times = j.nees.times.get();
  Panel panel{.title = "Coverage", .x_label = step_label(times), .y_label = "truth inside (%)"};
  for (std::size_t i = 0; i < j.coverage.size(); ++i) {
    if (!tells(j.coverage[i])) continue;
    FigureData x, inside, expected;
    for (std::size_t k = 0; k < j.coverage[i].steps.size(); ++k) {
      const CoverageStep& step = j.coverage[i].steps[k];
      if (step.count.total == 0) continue;
      x.push_back(step_place(times, 1 + static_cast<std::int64_t>(k) * j.step_stride));
      inside.push_back(100.0 * step.interval.value);
      expected.push_back(100.0 * step.expected);
    }
    const std::string sigmas = fmt::format("{:g}σ", CoverageSums::kSigmas[i]);
    const ColourRole role = numbered_role(static_cast<Index>(i));
    panel.series.push_back(line_series(sigmas + " expected", role, x, expected));
    panel.series.back().stroke = StrokeStyle::dashed;
    panel.series.push_back(line_series(sigmas, role, x, inside));
  }
  return panel;
}

constexpr const char* kSaysNothing = "says nothing here";

}  // namespace

ReportTable tests_table(const Judgement& j) {
  using enum ColumnAlign;
  ReportTable table{
      .title = "All tests",
      .columns = {{"test", words}, {"measured", words}, {"p-value"}, {"adjusted"}, {"says", words}}};
  const double alpha = 1.0 - j.confidence;
  const auto says_nothing = [&](const NamedTest& test) {
    for (std::size_t i = 0; i < j.coverage.size(); ++i) {
      const bool of_region = test.name == fmt::format("coverage of {:g}σ", CoverageSums::kSigmas[i]);
      if (of_region && test.p_value > alpha && !can_fail(j.coverage[i], alpha)) return true;
    }
    return false;
  };
  for (const NamedTest& test : j.tests) {
    const TableCell says = says_nothing(test)         ? TableCell(kSaysNothing, CellTone::muted)
                           : std::isnan(test.p_value) ? TableCell("not tested", CellTone::muted)
                           : test.adjusted <= alpha   ? TableCell("fails", CellTone::alarm)
                           : test.p_value <= alpha    ? TableCell("fails alone", CellTone::caution)
                                                      : TableCell("passes", CellTone::good);
    table.add({test.name, test.says, p_value_text(test.p_value), p_value_text(test.adjusted), says});
  }
  table.notes = {
      fmt::format("Over {}, NEES and NIS over all of a study. Each p-value holds its own false-alarm rate.",
                  counted(j.runs, "run")),
      fmt::format(
          "adjusted (Holm): a consistent filter has any of them below {:g} with at most {:g} % probability.",
          alpha, 100.0 * alpha)};
  const auto is_silent = [](const auto& row) { return row.back().text == kSaysNothing; };
  if (std::ranges::any_of(table.rows, is_silent)) {
    table.notes.push_back(fmt::format(
        "{}: of so few runs a share that is expected so near 0 or 100 % cannot fail.", kSaysNothing));
  }
  return table;
}

std::string contradiction_of_stop(const StudyAnalysis& a) {
  const Verdict verdict = overall_verdict(a);
  if (!a.stop || verdict == a.stop->verdict) return {};
  if (verdict == Verdict::not_gaussian) {
    return fmt::format("{}, for which the rule's tests of steps and innovations do not allow", a.word.says);
  }
  const std::span<const BlockVerdict> blocks =
      a.judgement ? a.judgement->blocks : std::span<const BlockVerdict>();
  const std::string clause = word_clause(a.word, a.nees, blocks);
  return fmt::format(
      "the rule proves the mean of NEES alone, and the filter is {}, by tests whose number of runs "
      "must be set in advance, as study.runs without a rule does",
      clause);
}

std::string stop_sentence(const StudyAnalysis& a) {
  const StopDecision& stop = a.stop.value();
  const std::string runs =
      fmt::format("after {} of at most {} runs", a.statistics.runs, a.scenario.most_runs());
  if (a.timed_out) {
    return fmt::format("Out of time {}: {} so far, at any look p = {}.", runs, to_string(stop.verdict),
                       number_text(stop.p_value, 3));
  }
  const std::string at_any_look = fmt::format("{}, however often one looked (p = {})",
                                              to_string(stop.verdict), number_text(stop.p_value, 3));
  const std::string all_the_same = contradiction_of_stop(a);
  const std::string caveat = all_the_same.empty() ? "" : fmt::format(" All the same: {}.", all_the_same);
  if (stop.reason == "precision") {
    const bool proved = stop.verdict != Verdict::undecided;
    return fmt::format("Stopped by precision {}: mean NEES {} ({} … {}); {}.{}", runs,
                       number_text(stop.mean_nees.mean, 4), number_text(stop.mean_nees.lower, 4),
                       number_text(stop.mean_nees.upper, 4),
                       proved ? at_any_look : "this stop gives no verdict", caveat);
  }
  const std::string factors =
      std::isnan(stop.scale.lower)
          ? "no single factor on P agrees with what was seen at all steps"
          : fmt::format("P times a factor from {} to {} agrees with what was seen",
                        number_text(stop.scale.lower, 3), number_text(stop.scale.upper, 3));
  return fmt::format("Stopped by {} {}: {}; {}.{}", stop.reason == "verdict" ? "verdict" : "the last look",
                     runs, at_any_look, factors, caveat);
}

std::string exact_sentence(const StudyAnalysis& a) {
  constexpr double kRounding = 1e-9;
  double nees = 0.0, nis = 0.0, outside = 0.0;
  Index nees_dof = 0, nis_dof = 0;
  for (const ExactMoments& step : a.exact) {
    outside = std::max(outside, step.outside);
    nees += step.nees;
    nees_dof += step.nees_dof;
    nis += step.nis;
    nis_dof += step.nis_dof;
  }
  if (nees_dof == 0 || nis_dof == 0) return {};
  const auto steps = static_cast<double>(a.exact.size());
  const auto per_step = [steps](double sum) { return number_text(sum / steps, 4); };
  const std::string factor = number_text(nees / static_cast<double>(nees_dof), 4);
  return fmt::format(
      "Exact, without sampling noise: mean NEES {} of {}{}, mean NIS {} of {}.{}", per_step(nees),
      per_step(static_cast<double>(nees_dof)),
      factor == "1.000" ? "" : fmt::format(" (scaling P by {} would make it right)", factor), per_step(nis),
      per_step(static_cast<double>(nis_dof)),
      outside <= kRounding
          ? ""
          : fmt::format(
                " That is where P has a variance: up to {} % of that of the errors is where it claims "
                "certainty, and there P is too small.",
                percent_text(outside)));
}

namespace {

/// What is proved, what is right whatever the law, and how good the estimate is.
void add_law_sentences(const Judgement& b, std::vector<std::string>& sentences) {
  const double alpha = 1.0 - b.confidence;
  const std::string proof = proof_sentence(b);
  const Verdict word = b.word.verdict;
  if (!proof.empty() && !is_inconsistent(word) && word != Verdict::undecided)
    sentences.push_back("Proved: " + proof);
  const ShapeJudgement& shape = b.law.shape;
  // Proved of Gaussian errors only.
  if (shape.proved_within <= 1.0 && b.word.verdict == Verdict::consistent) {
    sentences.push_back(fmt::format("Proved at step {}: every direction of P is right within {} %.",
                                    shape.proved_at, percent_text(shape.proved_within)));
  }
  const SecondMomentTest& second = b.law.second_moments.test;
  if (second.reason.empty()) {
    const double p = std::min(second.p_value.optimistic, second.p_value.pessimistic);
    const bool alone = p <= alpha && !is_inconsistent(word);
    sentences.push_back(
        fmt::format("Without assuming Gaussian errors: their mean squares over all rows {} P{} ({}{}); the "
                    "most certain deviation is in the direction of {}, a factor of {} ({} … {}).",
                    p <= alpha ? "disagree with" : "agree with",
                    b.law.second_moments.of.empty()
                        ? ""
                        : fmt::format(" of the block {}, the only one looked at in so large a state",
                                      b.law.second_moments.of),
                    p_value_statement(p), alone ? ", which is no evidence among so many tests" : "",
                    b.law.second_moments.worst, number_text(second.worst.mean, 3),
                    number_text(second.worst.lower, 3), number_text(second.worst.upper, 3)));
  }
  const ScoreJudgement& log = b.law.log_score;
  if (log.value.count > 0) {
    const std::string interval =
        log.value.reason.empty()
            ? fmt::format("{} … {}", number_text(log.value.lower, 4), number_text(log.value.upper, 4))
            : "no interval: " + std::string(log.value.reason);
    sentences.push_back(
        fmt::format("Log score {} ({}) per step, {} if P were right; of two filters the one that scores "
                    "higher is better.",
                    number_text(log.value.mean, 4), interval, number_text(log.expected, 4)));
  }
}

}  // namespace

std::string proof_sentence(const Judgement& j) {
  const EquivalenceJudgement& proof = j.law.equivalence;
  if (!(proof.p_value <= 1.0 - j.confidence)) return {};
  return fmt::format("on average over a run every mean NEES and NIS is right within {} %.",
                     percent_text(proof.proved_within));
}

namespace {

/// Of several sensors each has a factor of its own.
std::vector<std::string> scaled_sensors(const Judgement& b) {
  std::vector<std::string> sentences;
  if (!b.scale_innovation.reason.empty()) return sentences;
  for (const SensorJudgement& sensor : b.sensors) {
    const double factor = sensor.nis.mean / sensor.nis.expected;
    if (sensor.nis.verdict != (factor > 1.0 ? Verdict::optimistic : Verdict::pessimistic)) continue;
    sentences.push_back(fmt::format("Scaling S of {} by {} would make its mean NIS right.", sensor.name,
                                    number_text(factor, 3)));
  }
  return sentences;
}

/// Where errors are too large for P long before the block that is told: "It is seen first in the pose, from
/// step 136 on." A block that fails only by itself is no place.
std::string first_sign(const Judgement& b, const BlockVerdict& told) {
  constexpr std::int64_t kMuchEarlier = 20;  // of so many parts of all steps, one
  const auto first_of = [](const ConsistencyVerdict& v) { return v.step_of(v.optimistic_steps.first); };
  const auto is_seen = [](const ConsistencyVerdict& v) {
    return v.verdict == Verdict::optimistic && v.optimistic_steps.count > 0;
  };
  if (!is_seen(told.verdict)) return {};
  const ConsistencyVerdict* first = &told.verdict;
  std::string name;
  const auto look_at = [&](const ConsistencyVerdict& v, const std::string& test, const std::string& of) {
    if (!is_seen(v) || !speaks(b, test) || first_of(v) >= first_of(*first)) return;
    first = &v;
    name = of;
  };
  look_at(b.nees, "NEES", "the whole state");
  for (const BlockVerdict& block : b.blocks) look_at(block.verdict, "NEES of " + block.name, block.name);
  const std::int64_t earlier = first_of(told.verdict) - first_of(*first);
  if (name.empty() || kMuchEarlier * earlier < told.verdict.step_of(std::ssize(told.verdict.steps)))
    return {};
  return fmt::format("It is seen first in {}, {}.", name, when_text(*first, Verdict::optimistic));
}

/// Whether the whole state is further off than any of its blocks, by what they share.
bool is_between_blocks(const Judgement& b) {
  constexpr double kMuchLess = 0.3;
  const auto off = [](const ConsistencyVerdict& v) { return std::abs(v.mean / v.expected - 1.0); };
  return is_inconsistent(b.nees.verdict) && std::ranges::all_of(b.blocks, [&](const BlockVerdict& block) {
           return off(block.verdict) < kMuchLess * off(b.nees);
         });
}

/// "; in steps 1 to 4 it is 17.3 of 2.000": where steps that reject lie together, or decided, and are not
/// all.
std::string mean_at_steps(const ConsistencyVerdict& v) {
  const StepSpan& span = v.verdict == Verdict::pessimistic ? v.pessimistic_steps : v.optimistic_steps;
  const std::int64_t length = span.last - span.first + 1;
  const bool apart = span.count == 1 || 2 * span.count < length;
  if (span.count == 0 || length >= std::ssize(v.steps) || (apart && !v.decided_by_steps)) return {};
  double sum = 0.0, count = 0.0, dof = 0.0;
  for (std::int64_t k = span.first; k <= span.last; ++k) {
    const StepTest& step = v.steps[static_cast<std::size_t>(k - 1)];
    if (!step.has_data()) continue;
    sum += static_cast<double>(step.count) * step.mean;
    count += static_cast<double>(step.count);
    dof += step.total_dof;
  }
  if (count == 0.0) return {};
  return fmt::format("; {} {} it is {} of {}", span.count == 1 ? "at" : "in", v.text_of(span),
                     number_text(sum / count, 4), number_text(dof / count, 4));
}

std::string block_sentence(const Judgement& b, const BlockVerdict& block) {
  const std::string lead =
      is_between_blocks(b)
          ? fmt::format(
                "Most of the inconsistency is in what blocks share, the correlations between them: "
                "mean NEES {} of the whole state where {} is expected. Of the blocks it is clearest in",
                number_text(b.nees.mean, 4), number_text(b.nees.expected, 4))
          : "The inconsistency is clearest in the block";
  return fmt::format("{} “{}”, which is {}: mean NEES {} where {} is expected{}.", lead, block.name,
                     to_string(block.verdict.verdict), number_text(block.verdict.mean, 4),
                     number_text(block.verdict.expected, 4), mean_at_steps(block.verdict));
}

/// Of a filter that is optimistic here and pessimistic there: the side of which no cause speaks, unless it is
/// explained elsewhere.
std::string unexplained_side(std::span<const CauseFound> causes, Verdict explained) {
  if (causes.empty()) return {};
  const auto all = [&](Verdict side) {
    return std::ranges::all_of(causes, [side](const CauseFound& c) { return side_of(c.cause) == side; });
  };
  for (const Verdict told : {Verdict::optimistic, Verdict::pessimistic}) {
    const Verdict other = told == Verdict::optimistic ? Verdict::pessimistic : Verdict::optimistic;
    if (!all(told) || other == explained) continue;
    return fmt::format("That explains only where it is {}: of where it is {} no cause was found.",
                       to_string(told), to_string(other));
  }
  return {};
}

}  // namespace

std::vector<std::string> advice_sentences(const Judgement& b, Verdict explained) {
  std::vector<std::string> sentences;
  // What rejects alone and not beside all others is nothing to mend.
  const bool wrong = is_inconsistent(b.word.verdict);
  if (wrong && b.responsible.index >= 0) {
    const BlockVerdict& block = b.blocks[static_cast<std::size_t>(b.responsible.index)];
    sentences.push_back(block_sentence(b, block));
    if (std::string first = first_sign(b, block); !first.empty()) sentences.push_back(std::move(first));
  } else if (wrong && b.responsible.joint_only) {
    sentences.push_back(
        "Every block of the state is consistent and the whole is not: the correlations between blocks are "
        "wrong.");
  }
  for (const CauseFound& cause : b.causes) {
    sentences.push_back(fmt::format("{}: {} — {}.",
                                    b.word.verdict == Verdict::consistent ? "Noticed" : "Likely cause",
                                    to_string(cause.cause), cause.why));
  }
  if (!wrong) return sentences;
  if (b.word.verdict == Verdict::mixed) {
    if (std::string rest = unexplained_side(b.causes, explained); !rest.empty())
      sentences.push_back(std::move(rest));
  }
  const ScaleAdvice& scale = b.scale_covariance;
  if (scale.reason.empty() && b.word.verdict != Verdict::mixed && (scale.lower > 1.0 || scale.upper < 1.0)) {
    const std::string left = left_by_scale(b.nees, b.blocks);
    sentences.push_back(fmt::format("Scaling P by {} would make the mean NEES right{}.", factor_text(scale),
                                    left.empty() ? "" : " but leave " + left));
  }
  // A scale of S that mends NIS leaves errors that are wrong in the other direction worse.
  if (b.word.verdict == Verdict::mixed && is_inconsistent(b.nees.verdict) && b.nees.verdict != b.nis.verdict)
    return sentences;
  const ScaleAdvice& of_S = b.scale_innovation;
  if (b.sensors.size() > 1) {
    std::ranges::move(scaled_sensors(b), std::back_inserter(sentences));
  } else if (is_inconsistent(b.nis.verdict) && of_S.reason.empty() &&
             (of_S.lower > 1.0 || of_S.upper < 1.0)) {
    std::string sentence = fmt::format("Scaling S by {} would make the mean NIS right", factor_text(of_S));
    if (b.scale_measurement_noise.reason.empty()) {
      sentence += fmt::format(
          "; so would scaling R alone by {}, if the rest of S stayed: where a larger R makes P larger it "
          "overshoots",
          factor_text(b.scale_measurement_noise));
    }
    sentences.push_back(sentence + ".");
  }
  return sentences;
}

namespace {

/// Whether Jacobians at the truth claim much more than the bound.
bool is_loose(const BlockAccuracy& row) {
  constexpr double kLoose = 0.8;
  return row.bound < kLoose * row.at_truth;
}

std::string efficiency_text(const MeanInterval& efficiency) {
  return efficiency.count == 0 ? "–" : interval_text(efficiency.mean, efficiency.lower, efficiency.upper);
}

/// The runs that the averages of errors are of, where some failed: 7 of 12; else 0.
std::int64_t runs_averaged(const Judgement& judgement) {
  std::int64_t most = 0;
  for (const BlockAccuracy& row : judgement.accuracy) most = std::max(most, row.squared_error.count);
  return most < judgement.runs ? most : 0;
}

std::string bound_sentence(const Judgement& judgement) {
  std::vector<std::string> parts;
  for (const BlockAccuracy& row : judgement.accuracy) {
    if (std::isnan(row.bound)) continue;
    const ShownUnit unit = shown_unit(row.unit);
    const auto root = [&](double squared) { return unit.scale * std::sqrt(squared); };
    const MeanInterval& squared = row.squared_error;
    // Where the bound is loose, what Jacobians at the truth claim is what errors should be compared with.
    const std::string yardstick =
        is_loose(row) ? fmt::format("with Jacobians at the truth {}, bound {} (loose)",
                                    number_text(root(row.at_truth), 3), number_text(root(row.bound), 3))
                      : fmt::format("bound {}", number_text(root(row.bound), 3));
    const std::string claims =
        std::isnan(row.claimed) ? "" : fmt::format(", P claims {}", number_text(root(row.claimed), 3));
    parts.push_back(fmt::format("{}{} {}{}, {}", row.of, unit_in_brackets(unit.name),
                                interval_text(root(squared.mean), root(squared.lower), root(squared.upper)),
                                claims, yardstick));
  }
  if (parts.empty()) return {};
  const std::int64_t averaged = runs_averaged(judgement);
  return fmt::format(
      "RMSE beside P and the posterior Cramér-Rao bound{}: {}.",
      averaged > 0 ? fmt::format(", of the {} of {} runs that did not fail", averaged, judgement.runs) : "",
      fmt::join(parts, "; "));
}

}  // namespace

ReportTable accuracy_table(const Judgement& judgement, const PosteriorBound* bound) {
  using enum ColumnAlign;
  ReportTable table{.title = "How large the errors are, and how large P says they are",
                    .columns = {{"block", words}, {"RMSE", words}, {"P claims"}}};
  const bool bounded = bound != nullptr && bound->reason.empty();
  if (bounded) {
    for (const char* title : {"with Jacobians at the truth", "bound"}) table.columns.push_back({title});
    table.columns.push_back({"efficiency", words});
  }
  for (const BlockAccuracy& row : judgement.accuracy) {
    const ShownUnit unit = shown_unit(row.unit);
    const auto root = [&](double squared) { return unit.scale * std::sqrt(squared); };
    const MeanInterval& squared = row.squared_error;
    std::vector<TableCell> cells = {
        row.of + unit_in_brackets(unit.name),
        interval_text(root(squared.mean), root(squared.lower), root(squared.upper)),
        TableCell(root(row.claimed), 3)};
    if (bounded) {
      const bool known = !std::isnan(row.bound);
      for (const double value : {row.at_truth, row.bound}) {
        cells.push_back(known ? TableCell(root(value), 3) : TableCell("–"));
      }
      cells.push_back(efficiency_text(row.efficiency()));
    }
    table.add(std::move(cells));
  }
  if (bounded) {
    table.notes.push_back(fmt::format(
        "Averages over steps and runs, roots of summed squares. With Jacobians at the truth: what the filter "
        "would claim if it linearised there. Bound: the posterior Cramér-Rao bound, below which no filter "
        "without bias is, its Jacobians at the truth{}. Efficiency: its square over the mean squared error.",
        bound->runs > 1 ? fmt::format(" averaged over {} runs", bound->runs) : ""));
    if (std::ranges::any_of(judgement.accuracy, is_loose)) {
      table.notes.emplace_back(
          "The bound is loose here: Jacobians differ from run to run, and their mean tells what none of them "
          "tells alone. What Jacobians at the truth claim is no bound, and the better yardstick.");
    }
  } else {
    table.notes.emplace_back("Averages over steps and runs, roots of summed squares.");
  }
  if (const std::int64_t averaged = runs_averaged(judgement); averaged > 0) {
    table.notes.push_back(
        fmt::format("Only the {} of {} runs that did not fail are averaged: the errors of the others may be "
                    "the largest{}.",
                    averaged, judgement.runs, bounded ? ", and an efficiency above 1 is then no merit" : ""));
  }
  if (bound != nullptr && !bound->reason.empty()) {
    table.notes.push_back("No Cramér-Rao bound: " + bound->reason + ".");
  }
  return table;
}

std::string power_clause(const Judgement& judgement) {
  constexpr double kHalf = 0.5;
  const SettlingRuns& settle = judgement.settle_nees;
  if (settle.runs == 0 || !(off_by(settle.detectable.above) > kHalf)) return {};
  return fmt::format("; the data are too few to reveal P too small by less than {}",
                     off_by_text(off_by(settle.detectable.above)));
}

std::vector<std::string> statistics_sentences(const Judgement& b) {
  std::vector<std::string> sentences;
  add_law_sentences(b, sentences);
  advise_settling("NEES", "P", b.settle_nees, b.runs, sentences);
  advise_settling("NIS", "S", b.settle_nis, b.runs, sentences);
  if (std::string bound = bound_sentence(b); !bound.empty()) sentences.push_back(std::move(bound));
  return sentences;
}

namespace {

/// The sensors in the order in which a figure of the first ones shows them: of more than those the ones whose
/// NIS is inconsistent first, the worst of them before the others, then by the other two tests.
std::vector<const SensorJudgement*> sensors_to_show(const Judgement& j, std::size_t most) {
  std::vector<const SensorJudgement*> sensors;
  for (const SensorJudgement& sensor : j.sensors) {
    if (sensor.fit.count > 0 || sensor.whiteness.reason.empty()) sensors.push_back(&sensor);
  }
  if (sensors.size() <= most) return sensors;
  const auto goodness = [](const SensorJudgement* sensor) {
    const ConsistencyVerdict& nis = sensor->nis;
    const auto known = [](double p_value) { return std::fmin(p_value, 1.0); };
    if (!is_inconsistent(nis.verdict))
      return std::pair(1.0 + known(std::fmin(sensor->fit.anderson_p_value, sensor->whiteness.p_value)), 0.0);
    // p-values of many values may all be 0.
    return std::pair(known(nis.p_value), -std::abs(nis.mean / nis.expected - 1.0) * std::sqrt(0.5 * nis.dof));
  };
  std::ranges::stable_sort(sensors, {}, goodness);
  return sensors;
}

}  // namespace

Figure evidence_figure(const std::string& name, const Judgement& j, std::span<const Sensor> of_logs) {
  constexpr std::size_t kSensors = 3;
  const auto is_nis_alone = [of_logs](const SensorJudgement& sensor) {
    const auto of_log = std::ranges::find(of_logs, sensor.name, &Sensor::name);
    return of_log != of_logs.end() && of_log->nis_alone;
  };
  const std::vector<const SensorJudgement*> sensors = sensors_to_show(j, kSensors);
  const std::size_t shown = std::min(kSensors, sensors.size());
  Figure figure{.name = name + "-battery"};
  bool histograms = false, of_innovations = false, of_nis = false;
  for (const SensorJudgement* const sensor : std::span(sensors).first(shown)) {
    if (sensor->fit.count > 0) {
      figure.panels.push_back(histogram_panel(*sensor));
      histograms = true;
    }
    if (!sensor->whiteness.reason.empty()) continue;
    const bool nis_alone = is_nis_alone(*sensor);
    figure.panels.push_back(correlation_panel(*sensor, nis_alone, j.confidence));
    (nis_alone ? of_nis : of_innovations) = true;
  }
  std::string parts;
  const auto tell = [&parts](const char* part) { append_item(parts, part, "; "); };
  if (histograms)
    tell("the values of NIS taken through their distribution function, which makes them uniform");
  if (of_innovations) tell("the correlation of the normalised innovation with itself in time");
  if (of_nis)
    tell("the correlation with itself in time of NIS, made normal through its distribution function");
  constexpr std::int64_t kRuns = 5;  // of fewer a share of them jumps from step to step
  if (j.runs >= kRuns && j.coverage.front().tests > 0 && std::ranges::any_of(j.coverage, tells)) {
    figure.panels.push_back(coverage_panel(j));
    tell("how often the truth lies within kσ of the whole state");
  }
  figure.caption = fmt::format("Further tests, over {}: {}.", counted(j.runs, "run"), parts);
  if (shown < sensors.size())
    figure.caption +=
        fmt::format(" Of {} sensors {} are shown, inconsistent ones first.", sensors.size(), shown);
  arrange(figure);
  return figure;
}

}  // namespace credence::internal
