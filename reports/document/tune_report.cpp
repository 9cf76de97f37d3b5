#include "reports/document/tune_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/nan.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/registry.h"
#include "reports/document/replay_judgement.h"
#include "reports/document/study_table.h"
#include "reports/document/tuning_tables.h"
#include "reports/figures/draw_figures.h"
#include "reports/figures/tune_figures.h"
#include "reports/render/atomic_file.h"
#include "reports/render/html_page.h"
#include "reports/render/json_numbers.h"
#include "reports/render/number_text.h"

namespace credence {
namespace {

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

ReportTable tune_table(const ScenarioTuning& t) {
  return tuned_noise_table(t.scenario.name, t.score->engine(), t.tuning);
}

ReportTable tune_gain_table(const ScenarioTuning& t) {
  const Tuning& g = t.tuning;
  ReportTable table = score_gain_table(g);
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
      "{} Fresh noise: {} runs of seed {}, which find a factor below {} or above {} on S with 80 % power.",
      likelihood_ratio_text(g), after.statistics.runs, after.scenario.study.seed,
      number_text(t.held_out->detectable.below, 3), number_text(t.held_out->detectable.above, 3)));
  return table;
}

ReportAnswer tune_answer(const ScenarioTuning& t) {
  if (!t.tuning.anything_known()) return nothing_told(t.tuning);
  const std::string found = found_noise_text(t.tuning);
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
  j.update(tuning_json(g));
  j["ridge"] = nis_ridge_json(t);
  j["held_out"] = fresh_noise_json(t);
  j["notes"] = tune_sentences(t);
  return j.dump(1);
}

std::string tuned_toml(const ScenarioTuning& t) {
  return fmt::format("# {} with the noise that {} runs of its world ask for (credence tune).\n{}",
                     t.scenario.name, t.scenario.study.runs, canonical_toml(t.tuned));
}

void write_tune_report(const ReportFolder& directory, const ScenarioTuning& t, const Provenance& provenance) {
  const std::vector<Figure> figures = tune_figures(t);
  const std::vector<Drawing> drawings = draw_all(figures, directory);

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
