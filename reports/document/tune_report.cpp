#include "reports/document/tune_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/nan.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/registry.h"
#include "reports/document/replay_judgement.h"
#include "reports/document/study_table.h"
#include "reports/figures/draw_figures.h"
#include "reports/figures/tune_figures.h"
#include "reports/render/atomic_file.h"
#include "reports/render/html_page.h"
#include "reports/render/json_numbers.h"
#include "reports/render/number_text.h"

namespace credence {
namespace {

std::string or_dash(double value, int significant = 4) {
  return std::isnan(value) ? "–" : number_text(value, significant);
}

std::string tuned_interval_text(double lower, double upper) {
  if (std::isnan(lower)) return "–";
  return fmt::format("{} … {}", number_text(lower, 4), number_text(upper, 4));
}

Json tuned_parameter_json(const TunedParameter& p) {
  Json j{
      {"name", p.name},
      {"value", json_number(p.value)},
      {"lower", json_number(p.lower)},
      {"upper", json_number(p.upper)},
      {"identifiable", p.identifiable},
      {"steps_for_10_percent", json_number(p.steps_for_10_percent)},
      {"before", json_number(p.before)},
      {"bootstrap", {{"lower", json_number(p.bootstrap_lower)}, {"upper", json_number(p.bootstrap_upper)}}}};
  if (!p.identifiable) j["null_reason"] = p.reason;
  return j;
}

/// ln of the density of the true state under the filter's law, a step; NaN where it is not known.
double state_score(const StudyAnalysis& analysis) {
  return analysis.judgement ? analysis.judgement->law.log_score.value.mean : kNaN;
}

const WhitenessTest* whiteness(const StudyAnalysis& analysis) {
  if (!analysis.judgement || analysis.judgement->sensors.empty()) return nullptr;
  return &analysis.judgement->sensors.front().whiteness;
}

double whiteness_p_value(const StudyAnalysis& analysis) {
  const WhitenessTest* const test = whiteness(analysis);
  return test == nullptr ? kNaN : test->p_value;
}

Json study_verdict_json(const StudyAnalysis& a) {
  return {{"verdict", to_string(overall_verdict(a))},
          {"says", a.word.says},
          {"nis", {{"mean", json_number(a.nis.mean)}, {"expected", json_number(a.nis.expected)}}},
          {"nees", {{"mean", json_number(a.nees.mean)}, {"expected", json_number(a.nees.expected)}}},
          {"whiteness_p_value", json_number(whiteness_p_value(a))},
          {"state_log_score", json_number(state_score(a))},
          {"runs", a.statistics.runs}};
}

Json fresh_noise_json(const ScenarioTuning& t) {
  if (!t.held_out) return nullptr;
  Json j = study_verdict_json(t.held_out->after);
  j["seed"] = t.held_out->after.scenario.study.seed;
  j["detectable"] = {{"below", json_number(t.held_out->detectable.below)},
                     {"above", json_number(t.held_out->detectable.above)},
                     {"power", 0.8}};
  j["before"] = study_verdict_json(t.held_out->before);
  return j;
}

Json tune_forecast_json(const TuningForecast& forecast) {
  Json all = Json::array();
  for (const TuningForecast::Parameter& p : forecast.parameters) {
    Json& j = all.emplace_back(Json{{"name", p.name},
                                    {"identifiable", p.identifiable},
                                    {"relative_error", json_number(p.relative_error)},
                                    {"steps_for_10_percent", json_number(p.steps_for_10_percent)}});
    if (!p.identifiable) j["null_reason"] = p.reason;
  }
  return all;
}

Json nis_ridge_json(const ScenarioTuning& t) {
  Json ridge = Json::array();
  const ScoreModel& model = t.score->model();
  for (const RidgePoint& point : t.ridge) {
    Json values;
    for (const NoiseValue& value : model.values(point.phi)) {
      const ScenarioScore::Key key = t.score->key(value.name);
      values[key.name] = json_number(value.value * key.unit);
    }
    ridge.push_back({{"values", std::move(values)},
                     {"lag_one_correlation", json_number(point.lag_one)},
                     {"log_score_loss", json_number(point.drop / t.tuning.steps)}});
  }
  return ridge;
}

std::string ridge_sentence(const ScenarioTuning& t, const RidgePoint& point) {
  std::string values;
  const std::vector<NoiseValue> tuned = t.score->model().values(t.tuning.phi);
  const std::vector<NoiseValue> there = t.score->model().values(point.phi);
  for (std::size_t i = 0; i < there.size(); ++i) {
    if (there[i].value == tuned[i].value) continue;
    const ScenarioScore::Key key = t.score->key(there[i].name);
    values += fmt::format("{}{} = {}", values.empty() ? "" : ", ", key.name,
                          number_text(there[i].value * key.unit, 3));
  }
  return fmt::format("{} (lag-one correlation {}, log likelihood lower by {})", values,
                     number_text(point.lag_one, 2), number_text(point.drop, 3));
}

}  // namespace

ReportTable tune_forecast_table(const TuningForecast& forecast) {
  ReportTable table{.title = "What these data can tell, if the present filter is right",
                    .columns = {{"parameter", ColumnAlign::words},
                                {"known to ±", ColumnAlign::numbers},
                                {"steps for ±10 %", ColumnAlign::numbers},
                                {"", ColumnAlign::words}},
                    .rows = {},
                    .notes = {fmt::format("{} steps. ±: one standard error of the logarithm.",
                                          fmt::format("{:.0f}", forecast.steps))}};
  for (const TuningForecast::Parameter& p : forecast.parameters) {
    const std::string error =
        std::isnan(p.relative_error) ? "–" : number_text(100.0 * p.relative_error, 3) + " %";
    table.add({p.name, error,
               std::isnan(p.steps_for_10_percent) ? TableCell("–")
                                                  : TableCell(std::llround(p.steps_for_10_percent)),
               p.identifiable ? TableCell("") : TableCell("held: " + p.reason, CellTone::caution)});
  }
  return table;
}

ReportTable tune_table(const ScenarioTuning& t) {
  ReportTable table{
      .title = fmt::format("{}: the noise that the data ask for", t.scenario.name),
      .columns = {{"parameter", ColumnAlign::words},
                  {"present"},
                  {"tuned"},
                  {fmt::format("{:g} % interval", 100.0 * t.tuning.confidence), ColumnAlign::words},
                  {"by resampling", ColumnAlign::words},
                  {"steps for ±10 %"}},
      .rows = {},
      .notes = {fmt::format(
          "{}. Interval: {}. By resampling: {} units of data drawn with replacement, one Newton step each.",
          t.score->engine(),
          t.tuning.misspecified ? "the sandwich of observed information and scores" : "observed information",
          t.tuning.units)}};
  for (const TunedParameter& p : t.tuning.parameters) {
    const std::string limits =
        std::isnan(p.lower) ? p.reason : "only within " + tuned_interval_text(p.lower, p.upper);
    table.add({p.name, TableCell(p.before),
               p.identifiable ? TableCell(p.value) : TableCell("not identifiable", CellTone::caution),
               p.identifiable ? tuned_interval_text(p.lower, p.upper) : limits,
               tuned_interval_text(p.bootstrap_lower, p.bootstrap_upper),
               std::isnan(p.steps_for_10_percent) ? TableCell("–")
                                                  : TableCell(std::llround(p.steps_for_10_percent))});
  }
  return table;
}

ReportTable tune_gain_table(const ScenarioTuning& t) {
  ReportTable table{
      .title = "Before and after",
      .columns = {{"", ColumnAlign::words}, {"present", ColumnAlign::words}, {"tuned", ColumnAlign::words}},
      .rows = {},
      .notes = {}};
  const Tuning& g = t.tuning;
  table.add({"log score of the innovations, a step", or_dash(g.score_before, 6), or_dash(g.score_after, 6)});
  table.add(
      {"mean NIS (expected " + number_text(g.dof, 4) + ")", or_dash(g.nis_before), or_dash(g.nis_after)});
  table.add(
      {"lag-one correlation of the innovations", or_dash(g.lag_one_before, 2), or_dash(g.lag_one_after, 2)});
  if (!t.held_out) return table;
  const StudyAnalysis &before = t.held_out->before, &after = t.held_out->after;
  table.add(
      {"fresh noise: verdict", verdict_cell(overall_verdict(before)), verdict_cell(overall_verdict(after))});
  table.add({"fresh noise: mean NIS", or_dash(before.nis.mean), or_dash(after.nis.mean)});
  table.add({"fresh noise: mean NEES (expected " + number_text(after.nees.expected, 4) + ")",
             or_dash(before.nees.mean), or_dash(after.nees.mean)});
  table.add({"fresh noise: whiteness, p-value", p_value_text(whiteness_p_value(before)),
             p_value_text(whiteness_p_value(after))});
  table.add({"fresh noise: log score of the state, a step", or_dash(state_score(before), 6),
             or_dash(state_score(after), 6)});
  table.notes.push_back(fmt::format(
      "Likelihood ratio {} with {} dof, p {}{}. Fresh noise: {} runs of seed {}, which find a factor below "
      "{} "
      "or above {} on S with 80 % power.",
      number_text(g.likelihood_ratio, 4), g.coordinates.size(),
      g.likelihood_ratio_p_value < 1e-12 ? "" : "= ", p_value_text(g.likelihood_ratio_p_value),
      after.statistics.runs, after.scenario.study.seed, number_text(t.held_out->detectable.below, 3),
      number_text(t.held_out->detectable.above, 3)));
  return table;
}

ReportAnswer tune_answer(const ScenarioTuning& t) {
  if (!t.tuning.anything_known()) {
    std::string why = t.tuning.notes.empty() ? "Nothing could be told" : t.tuning.notes.back();
    if (why.ends_with('.')) why.pop_back();
    return {CellTone::caution, why};
  }
  std::string found;
  for (const TunedParameter& p : t.tuning.parameters) {
    if (!p.identifiable) continue;
    found += fmt::format("{}{} = {} ({})", found.empty() ? "" : ", ", p.name, number_text(p.value, 3),
                         tuned_interval_text(p.lower, p.upper));
  }
  if (!t.held_out) return {CellTone::plain, "The innovations ask for " + found};
  const Verdict verdict = overall_verdict(t.held_out->after);
  return {verdict == Verdict::consistent ? CellTone::good : CellTone::caution,
          fmt::format("The innovations ask for {}; with it the filter is {} on fresh noise", found,
                      to_string(verdict))};
}

std::vector<std::string> tune_sentences(const ScenarioTuning& t) {
  std::vector<std::string> sentences = t.tuning.notes;
  if (t.ridge.empty()) return sentences;
  std::string points;
  for (const RidgePoint& point : t.ridge) {
    points += (points.empty() ? "" : "; ") + ridge_sentence(t, point);
  }
  sentences.push_back(
      "NIS alone cannot tell these from the tuned noise, its mean is as expected there too: " + points + ".");
  return sentences;
}

std::string tune_json(const ScenarioTuning& t) {
  const Tuning& g = t.tuning;
  Json j;
  j["schema"] = kSchema;
  j["scenario"] = Json::parse(scenario_to_json(t.scenario));
  j["engine"] = t.score->engine();
  j["runs"] = t.scenario.study.runs;
  j["steps"] = t.scenario.study.steps;
  j["confidence"] = g.confidence;
  j["forecast"] = tune_forecast_json(g.forecast);
  j["parameters"] = Json::array();
  for (const TunedParameter& p : g.parameters) j["parameters"].push_back(tuned_parameter_json(p));
  j["coordinates"] = g.coordinates;
  j["correlation"] = json_matrix(g.correlation);
  j["log_score"] = {{"before", json_number(g.score_before)},
                    {"after", json_number(g.score_after)},
                    {"likelihood_ratio", json_number(g.likelihood_ratio)},
                    {"likelihood_ratio_p_value", json_number(g.likelihood_ratio_p_value)}};
  j["innovations"] = {
      {"nis",
       {{"before", json_number(g.nis_before)}, {"after", json_number(g.nis_after)}, {"expected", g.dof}}},
      {"lag_one_correlation",
       {{"before", json_number(g.lag_one_before)}, {"after", json_number(g.lag_one_after)}}}};
  j["intervals"] = g.misspecified ? "sandwich" : "observed information";
  j["information_ratio"] = json_number(g.information_ratio);
  j["ridge"] = nis_ridge_json(t);
  j["held_out"] = fresh_noise_json(t);
  j["notes"] = tune_sentences(t);
  return j.dump(1);
}

std::string tuned_toml(const ScenarioTuning& t) {
  return fmt::format("# {} with the noise that {} runs of its world ask for (credence tune).\n{}",
                     t.scenario.name, t.scenario.study.runs, canonical_toml(t.tuned));
}

void write_tune_report(const std::filesystem::path& directory, const ScenarioTuning& t,
                       const Provenance& provenance) {
  const std::filesystem::path folder = directory / "figures";
  make_directories(folder);
  const std::vector<Figure> figures = tune_figures(t);
  const std::vector<Drawing> drawings = draw_all(figures, folder);

  HtmlPage page("Tuning " + t.scenario.name, "The noise that the innovations ask for, by Credence");
  const ReportAnswer answer = tune_answer(t);
  page.answer(answer.tone, answer.text + ".");
  page.section("Noise");
  page.facts({{"world", world_text(t.scenario)},
              {"runs", fmt::format("{} of {} steps", t.scenario.study.runs, t.scenario.study.steps)},
              {"engine", t.score->engine()}});
  page.table(tune_table(t));
  page.table(tune_gain_table(t));
  page.bullets(tune_sentences(t));
  page.section("What could be known");
  page.table(tune_forecast_table(t.tuning.forecast));
  if (!figures.empty()) page.section("Figures");
  for (std::size_t i = 0; i < figures.size(); ++i) page.figure(figures[i], drawings[i], directory);
  if (t.tuning.anything_known()) {
    page.section("Tuned scenario");
    page.verbatim(tuned_toml(t));
  }
  page.section("Settings");
  page.verbatim(canonical_toml(t.scenario));
  page.provenance(provenance);
  page.write(directory / "index.html");
}

}  // namespace credence
