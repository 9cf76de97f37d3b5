#include "reports/document/study/comparison_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <span>
#include <stdexcept>
#include <utility>

#include "analysis/laws/joint/multiple_tests.h"
#include "analysis/laws/mean/hall_score.h"
#include "analysis/laws/mean/ratio_of_factors.h"
#include "analysis/laws/normal_quantile.h"
#include "core/append_item.h"
#include "core/nan.h"
#include "core/number_text.h"
#include "montecarlo/scenario/scenario_text.h"
#include "reports/document/logs/log_gate.h"
#include "reports/document/study/calibration_report.h"
#include "reports/document/verdict_text.h"
#include "reports/figures/step_axis.h"
#include "reports/render/json_numbers.h"
#include "reports/render/parsed_json.h"

namespace credence::internal {
namespace {

ComparedMean mean_of(const ConsistencyVerdict& v) {
  return v.count == 0 ? ComparedMean{kNaN, kNaN} : ComparedMean{v.mean, v.expected};
}

/// The mean at every step over what it should be; NaN where a step has no data.
std::vector<double> ratios_of(const ConsistencyVerdict& v) {
  std::vector<double> ratios;
  ratios.reserve(v.steps.size());
  for (const StepTest& s : v.steps) ratios.push_back(s.total_dof > 0.0 ? s.mean / s.expected : kNaN);
  return ratios;
}

/// The object under a key, an empty one where there is none.
Json object(const Json& j, const char* key) {
  const auto found = j.find(key);
  if (found == j.end() || found->is_null()) return Json::object();
  return found->get_ref<const Json::object_t&>();
}

/// The number under a key, NaN where there is none.
double number(const Json& j, const char* key) {
  const auto found = j.find(key);
  return found == j.end() || found->is_null() ? kNaN : found->get<double>();
}

ComparedMean mean_of(const Json& document, const char* key) {
  const Json mean = object(document, key);
  return {number(mean, "mean"), number(mean, "expected")};
}

/// Throws Json::exception where a member is missing or of another kind, std::invalid_argument for a verdict
/// that is none, and by require_possible.
ComparedStudy compared_document(const std::string& name, const Json& j) {
  require_possible(name, j);
  ComparedStudy study{.name = name,
                      .runs = j.at("runs").get<std::int64_t>(),
                      .verdict = j.at("verdict").get<std::string>(),
                      .p_value = number(object(j, j.contains("stop") ? "stop" : "word"), "p_value"),
                      .nees = mean_of(j, "nees"),
                      .nis = mean_of(j, "nis")};
  if (j.contains("vehicle_nees")) study.pose = mean_of(j, "vehicle_nees");
  const Json factor = object(j.at("nees"), "factor");
  study.factor.mean = number(factor, "value");
  study.factor.lower = number(factor, "lower");
  study.factor.upper = number(factor, "upper");
  if (study.factor.lower > study.factor.mean || study.factor.upper < study.factor.mean) {
    throw std::invalid_argument(
        fmt::format("{}: nees.factor.value = {}: must lie in its interval, from {} to {}", name,
                    study.factor.mean, study.factor.lower, study.factor.upper));
  }
  if (std::isnan(study.factor.lower)) study.factor.mean = kNaN;
  if (std::isnan(study.factor.upper)) study.factor.upper = std::numeric_limits<double>::infinity();
  study.units = unit_factors_of(j.value("calibration", Json::object()));
  study.confidence = number(j.at("nees"), "confidence");
  if (!verdict_named(study.verdict)) {
    throw std::invalid_argument(
        fmt::format("{}: verdict = {}: accepted are consistent, optimistic, pessimistic, mixed, not Gaussian "
                    "and undecided",
                    name, study.verdict));
  }
  if (j.contains("swept")) study.cell = cell_name(j["swept"]);
  if (j.contains("scenario") && j["scenario"].contains("name"))
    study.name = j["scenario"]["name"].get<std::string>();
  return study;
}

std::string mean_text(const ComparedMean& m) {
  if (!std::isfinite(m.mean) || !std::isfinite(m.expected)) return "–";
  return fmt::format("{} of {}", number_text(m.mean, 4), number_text(m.expected, 4));
}

Json mean_json(const ComparedMean& m) { return {{"mean", m.mean}, {"expected", m.expected}}; }

FactorInterval interval_of(const ComparedStudy& study) {
  const MeanInterval& f = study.factor;
  return {f.mean, f.lower, f.upper, normal_quantile_two_sided(study.confidence)};
}

/// Of one configuration of sweeps; nothing where a factor has no interval.
std::optional<FactorChange> change_of_cells(const ComparedStudy& after, const ComparedStudy& before,
                                            double confidence) {
  if (std::isnan(after.confidence + before.confidence)) return {};
  const FactorInterval second = interval_of(after), first = interval_of(before);
  if (!second.is_known() || !first.is_known()) return {};
  const RatioOfFactors r = ratio_of_factors(second, first, confidence);
  return FactorChange{.part = "NEES",
                      .ratio = r.ratio,
                      .before = first.factor,
                      .after = second.factor,
                      .p_value = r.p_value,
                      .p_middle = p_value_of_middle(second, first)};
}

ReportTable comparison_table(std::span<const ComparedStudy> studies, double confidence) {
  using enum ColumnAlign;
  ReportTable table{.title = "Each result, and what it differs by from the first",
                    .columns = {{"study", words},
                                {"runs"},
                                {"verdict", words},
                                {"factor on P", words},
                                {"NEES", words},
                                {"of the pose", words},
                                {"NIS", words},
                                {"against the first", words}}};
  bool paired = false, unpaired = false, of_fewer = false;
  const std::vector<std::optional<RunDifference>> differences = differences_from_first(studies, confidence);
  for (std::size_t i = 0; i < studies.size(); ++i) {
    const ComparedStudy& s = studies[i];
    std::string difference = "–";
    if (i > 0) {
      const std::optional<RunDifference>& d = differences[i];
      if (d)
        difference = fmt::format("{}, {}", mean_interval_text(d->interval), p_value_statement(d->adjusted));
      (d ? paired : unpaired) = true;
      of_fewer = of_fewer || (d && s.nees_of_runs.size() != studies.front().nees_of_runs.size());
    }
    table.add({s.name, s.runs, TableCell(s.verdict, verdict_tone(s.verdict)), mean_interval_text(s.factor),
               mean_text(s.nees), s.pose ? mean_text(*s.pose) : "–", mean_text(s.nis), difference});
  }
  constexpr std::ptrdiff_t kPose = 5;
  if (std::ranges::none_of(studies, [](const ComparedStudy& s) { return s.pose.has_value(); }))
    table.remove_column(kPose);
  table.notes.push_back(
      "factor on P: the true covariance over the claimed one, on average over steps, with its interval.");
  if (paired) {
    table.notes.push_back(fmt::format(
        "against the first: NEES over dof, this study minus the first, run by run under the same "
        "noise, with its interval at {:g} % and the p-value of no difference, Holm over the studies.{}",
        100.0 * confidence,
        of_fewer ? " Of different numbers of runs those that both have are compared." : ""));
  }
  const std::vector<std::vector<FactorChange>> changes = changes_from_first(studies, confidence);
  for (std::size_t i = 0; i < studies.size(); ++i) {
    for (const FactorChange& change : changes[i]) {
      if (change.adjusted <= 1.0 - confidence)
        table.notes.push_back(
            fmt::format("{} is {}.", studies[i].name, change_text(change, 1.0 - confidence)));
    }
  }
  if (unpaired) {
    table.notes.push_back(
        "–: cannot be paired run by run: that takes results stored by run --out of the same world, noise, "
        "seed and steps, in which no run failed. Of logs the factors on P are paired by the names of their "
        "files.");
  }
  return table;
}

bool is_untrusted_alone(const ComparedStudy& study) {
  const std::optional<Verdict> verdict = verdict_named(study.verdict);
  return verdict && is_unsafe(*verdict);
}

/// Which are also when all are judged together (Holm).
std::vector<std::string> untrusted_of(std::span<const ComparedStudy> studies, double confidence) {
  std::vector<double> p_values;
  for (const ComparedStudy& study : studies) p_values.push_back(study.p_value);
  const std::vector<double> adjusted = holm(p_values);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < studies.size(); ++i) {
    if (is_untrusted_alone(studies[i]) && !(adjusted[i] > 1.0 - confidence)) names.push_back(studies[i].name);
  }
  return names;
}

/// Over time where all studies tell it: their steps may be of different lengths.
Panel over_steps(std::span<const ComparedStudy> studies, FigureText title,
                 std::vector<double> ComparedStudy::*ratios) {
  const bool timed = std::ranges::all_of(
      studies, [&](const ComparedStudy& s) { return (s.*ratios).empty() || s.times != nullptr; });
  const auto times_of = [timed](const ComparedStudy& s) { return timed ? s.times.get() : nullptr; };
  Panel panel{.title = std::move(title), .x_label = timed ? "time (s)" : "step", .y_label = "mean over dof"};
  panel.series.push_back(level_series("consistent", ColourRole::neutral, 1.0));
  for (std::size_t i = 0; i < studies.size(); ++i) {
    const std::vector<double>& values = studies[i].*ratios;
    if (values.empty()) continue;
    panel.series.push_back(line_series(studies[i].name, numbered_role(static_cast<Index>(i)),
                                       step_places(times_of(studies[i]), values.size()), values));
  }
  return panel;
}

/// NEES over dof of each study less that of the first, run by run.
Panel difference_panel(std::span<const ComparedStudy> studies, double confidence) {
  Panel panel{.title = "Against the first, run by run",
              .x_label = "study, as in the table",
              .y_label = "difference of NEES over dof",
              .x_range = AxisRange{0.5, static_cast<double>(studies.size()) + 0.5}};
  for (std::size_t i = 1; i <= studies.size(); ++i) panel.x_names.push_back(fmt::to_string(i));
  panel.series.push_back(level_series("no difference", ColourRole::neutral, 0.0));
  for (std::size_t i = 1; i < studies.size(); ++i) {
    const std::optional<RunDifference> d = paired_difference(studies[i], studies.front(), confidence);
    if (!d) continue;
    panel.series.push_back(error_bar_series(studies[i].name, numbered_role(static_cast<Index>(i)),
                                            {static_cast<double>(i) + 1.0}, {d->interval.mean},
                                            {d->interval.lower}, {d->interval.upper}));
  }
  return panel;
}

Figure comparison_figure(std::span<const ComparedStudy> studies, double confidence) {
  Figure figure{.name = "comparison",
                .caption =
                    "Mean over the runs at every step, over its expected value: above 1 the errors are "
                    "larger than the covariance says.",
                .rows = 1,
                .cols = 0};
  for (Panel& panel : std::vector{over_steps(studies, "NEES", &ComparedStudy::nees_of_steps),
                                  over_steps(studies, "NIS", &ComparedStudy::nis_of_steps),
                                  difference_panel(studies, confidence)}) {
    if (panel.series.size() > 1) figure.panels.push_back(std::move(panel));
  }
  figure.cols = static_cast<int>(figure.panels.size());
  return figure;
}

/// Whether the factor of `other` is farther from 1 than that of `nearest`, to whichever side that is, by more
/// than `widths` of their intervals together.
bool is_farther(const ComparedStudy& other, const ComparedStudy& nearest, double widths) {
  const auto width_to = [](const MeanInterval& of, double bound) {
    return std::abs(std::log(bound / of.mean));
  };
  const bool large = other.factor.mean > 1.0;
  const double towards_one = width_to(other.factor, large ? other.factor.lower : other.factor.upper);
  const double away = std::max(width_to(nearest.factor, nearest.factor.lower),
                               width_to(nearest.factor, nearest.factor.upper));
  return factor_distance(other) - factor_distance(nearest) > widths * std::hypot(towards_one, away);
}

/// The one of several whose factor on P is nearest to 1, where every other is clearly farther, at this
/// confidence of all (Bonferroni; their intervals as of independent runs, which those on common noise are
/// not).
const ComparedStudy* nearest_of(std::span<const ComparedStudy> studies, double confidence) {
  const ComparedStudy* nearest = nullptr;
  std::size_t known = 0;
  for (const ComparedStudy& study : studies) {
    if (!std::isfinite(factor_distance(study))) continue;
    ++known;
    if (nearest == nullptr || factor_distance(study) < factor_distance(*nearest)) nearest = &study;
  }
  if (known < 2) return nullptr;
  const double of_each = confidence_of_each(confidence, known - 1);
  const double widths = normal_quantile_two_sided(of_each) / normal_quantile_two_sided(confidence);
  const bool clearly = std::ranges::all_of(studies, [&](const ComparedStudy& study) {
    return &study == nearest || !std::isfinite(factor_distance(study)) || is_farther(study, *nearest, widths);
  });
  return clearly ? nearest : nullptr;
}

ReportAnswer comparison_answer(std::span<const ComparedStudy> studies, double confidence) {
  const std::vector<std::string> untrusted = untrusted_of(studies, confidence);
  ReportAnswer answer{.tone = CellTone::alarm,
                      .text = fmt::format("{} of {} cannot be trusted: {}", untrusted.size(), studies.size(),
                                          fmt::join(untrusted, ", "))};
  if (untrusted.empty()) {
    std::map<std::string, std::size_t> verdicts;
    for (const ComparedStudy& study : studies) ++verdicts[study.verdict];
    std::string counts;
    for (const auto& [verdict, count] : verdicts) append_item(counts, fmt::format("{} {}", count, verdict));
    const bool all_consistent =
        verdicts.size() == 1 && verdicts.begin()->first == to_string(Verdict::consistent);
    const bool some_alone = std::ranges::any_of(studies, is_untrusted_alone);
    answer = {all_consistent ? CellTone::good : CellTone::caution,
              fmt::format("Of {} results{} none is called optimistic: {}", studies.size(),
                          some_alone ? ", taken together," : "", counts)};
  }
  // One that cannot be trusted is no one's choice beside others that can.
  const auto is_choice = [&](const ComparedStudy& nearest) {
    return untrusted.size() == studies.size() || std::ranges::count(untrusted, nearest.name) == 0;
  };
  if (const ComparedStudy* const nearest = nearest_of(studies, confidence);
      nearest != nullptr && is_choice(*nearest)) {
    answer.text += fmt::format("; nearest to right: {}, factor on P {}", nearest->name,
                               number_text(nearest->factor.mean, 3));
  }
  return answer;
}

}  // namespace

std::string cell_name(const Json& swept) {
  std::map<std::string, std::string> values;  // in the order of the keys, whatever that of the axes
  for (const auto& [key, value] : swept.items())
    values[key] = value.is_string() ? value.get<std::string>() : value.dump();
  std::string name;
  for (const auto& [key, value] : values) append_item(name, fmt::format("{} = {}", key, value));
  return name;
}

const ComparedStudy* reference_of(std::span<const ComparedStudy> studies, std::size_t i) {
  const ComparedStudy& study = studies[i];
  if (study.cell.empty() && studies.front().cell.empty()) return i > 0 ? &studies.front() : nullptr;
  if (study.of_sweep == studies.front().of_sweep) return nullptr;
  for (const ComparedStudy& other : studies) {
    if (other.of_sweep != studies.front().of_sweep) break;
    if (other.cell == study.cell) return &other;
  }
  return nullptr;
}

CellTone verdict_tone(const std::string& verdict) {
  const std::optional<Verdict> known = verdict_named(verdict);
  return known ? verdict_cell(*known).tone : CellTone::plain;
}

std::string mean_interval_text(const MeanInterval& i) {
  return std::isfinite(i.mean) ? interval_text(i.mean, i.lower, i.upper) : "–";
}

double factor_distance(const ComparedStudy& study) { return std::abs(std::log(study.factor.mean)); }

std::vector<std::vector<FactorChange>> changes_from_first(std::span<const ComparedStudy> studies,
                                                          double confidence) {
  std::vector<std::vector<FactorChange>> changes(studies.size());
  std::vector<double> p_values;
  for (std::size_t i = 1; i < studies.size(); ++i) {
    const ComparedStudy* const reference = reference_of(studies, i);
    if (reference == nullptr) continue;
    changes[i] = compare_factors(studies[i].units, reference->units, confidence);
    if (!studies[i].cell.empty() && !paired_difference(studies[i], *reference, confidence)) {
      if (auto change = change_of_cells(studies[i], *reference, confidence))
        changes[i].push_back(std::move(*change));
    }
    for (const FactorChange& change : changes[i]) p_values.push_back(change.p_value);
  }
  const std::vector<double> adjusted = holm(p_values);
  std::size_t at = 0;
  for (std::vector<FactorChange>& of_study : changes) {
    for (FactorChange& change : of_study) change.adjusted = adjusted[at++];
  }
  return changes;
}

std::string comparison_json(std::span<const ComparedStudy> studies, double confidence) {
  Json all = Json::array();
  const std::vector<std::optional<RunDifference>> differences = differences_from_first(studies, confidence);
  const std::vector<std::vector<FactorChange>> changes = changes_from_first(studies, confidence);
  for (std::size_t i = 0; i < studies.size(); ++i) {
    const ComparedStudy& s = studies[i];
    Json j = {{"name", s.name},
              {"configuration", s.cell.empty() ? Json(nullptr) : Json(s.cell)},
              {"runs", s.runs},
              {"verdict", s.verdict},
              {"factor", json_interval(s.factor)},
              {"nees", mean_json(s.nees)},
              {"vehicle_nees", s.pose ? mean_json(*s.pose) : Json(nullptr)},
              {"nis", mean_json(s.nis)},
              {"paired_difference", nullptr},
              {"changes", Json::array()}};
    for (const FactorChange& change : changes[i]) j["changes"].push_back(change_json(change));
    if (const std::optional<RunDifference>& d = differences[i]) {
      j["paired_difference"] = json_interval(d->interval);
      j["paired_difference"].update({{"p_value", d->p_value}, {"adjusted_p_value", d->adjusted}});
    }
    all.push_back(std::move(j));
  }
  return text_of_json({{"schema", kSchema}, {"confidence", confidence}, {"studies", std::move(all)}});
}

ComparedStudy compared(const StudyAnalysis& a) {
  ComparedStudy study{.name = a.scenario.name,
                      .runs = a.statistics.runs,
                      .verdict = std::string(to_string(overall_verdict(a))),
                      .p_value = overall_p_value(a),
                      .factor = a.nees.factor,
                      .nees = mean_of(a.nees),
                      .nis = mean_of(a.nis),
                      .confidence = a.nees.confidence};
  if (a.vehicle_nees) study.pose = mean_of(*a.vehicle_nees);
  study.noise = fmt::format("{:016x}, seed {}, {} steps", noise_group(a.scenario), a.scenario.study.seed,
                            a.scenario.study.steps);
  if (a.statistics.failures.empty()) study.nees_of_runs = a.statistics.nees_of_runs.first;
  study.nees_of_steps = ratios_of(a.nees);
  study.nis_of_steps = ratios_of(a.nis);
  study.times = a.nees.times;
  return study;
}

std::vector<ComparedStudy> compared_documents(const std::string& name, std::string_view json) {
  const Json document = parsed_json(name, json);
  require_schema(name, document);
  std::vector<ComparedStudy> studies;
  try {
    if (document.contains("studies") && document["studies"].is_array()) {
      for (const Json& study : document["studies"]) studies.push_back(compared_document(name, study));
    } else if (document.contains("configurations") && document.contains("points")) {
      for (const Json& study : document["configurations"]) studies.push_back(compared_document(name, study));
    } else {
      studies.push_back(compared_document(name, document));
    }
  } catch (const Json::exception&) {
    throw std::invalid_argument(
        fmt::format("{}: is not a document of `credence run`, `sweep` or `check` with --format json", name));
  }
  if (studies.empty()) throw std::invalid_argument(fmt::format("{}: holds no results to compare", name));
  return studies;
}

std::optional<RunDifference> paired_difference(const ComparedStudy& study, const ComparedStudy& reference,
                                               double confidence) {
  const std::size_t runs = std::min(study.nees_of_runs.size(), reference.nees_of_runs.size());
  if (study.noise.empty() || study.noise != reference.noise || runs < 2) return std::nullopt;
  SkewedMoments differences, from_middle;
  Moments before, after;
  for (std::size_t i = 0; i < runs; ++i) {
    const double first = reference.nees_of_runs[i], second = study.nees_of_runs[i];
    before.add(first);
    after.add(second);
    differences.add(second - first);
    from_middle.add(0.5 * (first + second) - 1.0);
  }
  return RunDifference{.interval = paired_interval(differences, confidence),
                       .before = before.mean,
                       .after = after.mean,
                       .p_value = paired_p_value(differences),
                       .p_middle = paired_p_value(from_middle)};
}

Nearness nearness_of(const RunDifference& d, double level) {
  return nearness_of(FactorChange{.part = "NEES",
                                  .ratio = {},
                                  .before = d.before,
                                  .after = d.after,
                                  .p_value = d.p_value,
                                  .adjusted = d.adjusted,
                                  .p_middle = d.p_middle},
                     level);
}

std::vector<std::optional<RunDifference>> differences_from_first(std::span<const ComparedStudy> studies,
                                                                 double confidence) {
  std::vector<std::optional<RunDifference>> differences(studies.size());
  std::vector<double> p_values(studies.size(), kNaN);
  for (std::size_t i = 1; i < studies.size(); ++i) {
    if (const ComparedStudy* const reference = reference_of(studies, i))
      differences[i] = paired_difference(studies[i], *reference, confidence);
    if (differences[i]) p_values[i] = differences[i]->p_value;
  }
  const std::vector<double> adjusted = holm(p_values);
  for (std::size_t i = 1; i < studies.size(); ++i) {
    if (differences[i]) differences[i]->adjusted = adjusted[i];
  }
  return differences;
}

Document comparison_document(const std::vector<ComparedStudy>& studies, double confidence) {
  Document document("Results side by side", fmt::format("{} results, compared by Credence", studies.size()));
  document.answer = comparison_answer(studies, confidence);
  document.json = [studies, confidence] { return comparison_json(studies, confidence); };

  ReportTable table = comparison_table(studies, confidence);
  document.show_answer();
  document.brief.emplace_back(table);

  document.section("Side by side");
  document.table(std::move(table));
  document.figure(comparison_figure(studies, confidence));
  return document;
}

}  // namespace credence::internal
