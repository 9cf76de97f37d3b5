#include "reports/document/tuning/tune_report.h"

#include <fmt/format.h>

#include <memory>
#include <utility>

#include "core/append_item.h"
#include "core/nan.h"
#include "core/number_text.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/registry.h"
#include "reports/document/tuning/tuning_tables.h"
#include "reports/document/verdict_text.h"
#include "reports/figures/tune_figures.h"
#include "reports/render/json_numbers.h"
#include "reports/render/utf8_text.h"

namespace credence::internal {
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
          {"nis", {{"mean", a.nis.mean}, {"expected", a.nis.expected}}},
          {"nees", {{"mean", a.nees.mean}, {"expected", a.nees.expected}}},
          {"whiteness_p_value", whiteness_p_value(a)},
          {"state_log_score", state_score(a)},
          {"runs", a.statistics.runs}};
}

Json fresh_noise_json(const ScenarioTuning& t) {
  if (!t.held_out) return nullptr;
  Json j = study_verdict_json(t.held_out->after);
  j["seed"] = t.held_out->after.scenario.study.seed;
  j["detectable"] = {
      {"below", t.held_out->detectable.below}, {"above", t.held_out->detectable.above}, {"power", 0.8}};
  j["before"] = study_verdict_json(t.held_out->before);
  return j;
}

Json nis_ridge_json(const ScenarioTuning& t) {
  return json_list(t.ridge, [&](const RidgePoint& point) -> Json {
    Json values;
    for (const NoiseValue& value : t.score->model().values(point.phi)) {
      const ScenarioScore::Key key = t.score->key(value.name);
      values[key.name] = value.value * key.unit;
    }
    return {{"values", std::move(values)},
            {"lag_one_correlation", point.lag_one},
            {"log_score_loss", point.drop / t.tuning.steps}};
  });
}

std::string ridge_sentence(const ScenarioTuning& t, const RidgePoint& point) {
  std::string values;
  const std::vector<NoiseValue> tuned = t.score->model().values(t.tuning.phi);
  const std::vector<NoiseValue> there = t.score->model().values(point.phi);
  for (std::size_t i = 0; i < there.size(); ++i) {
    if (there[i].value == tuned[i].value) continue;
    const ScenarioScore::Key key = t.score->key(there[i].name);
    append_item(values, fmt::format("{} = {}", key.name, number_text(there[i].value * key.unit, 3)));
  }
  return fmt::format("{} (lag-one correlation {}, log likelihood lower by {})", values,
                     number_text(point.lag_one, 2), number_text(point.drop, 3));
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
  const std::string asked = asked_noise_text("The innovations", t.tuning);
  if (!t.held_out) return {t.tuning.converged ? CellTone::plain : CellTone::caution, asked};
  const Verdict verdict = overall_verdict(t.held_out->after);
  return {verdict == Verdict::consistent && t.tuning.converged ? CellTone::good : CellTone::caution,
          fmt::format("{}; with the tuned noise the filter is {} on fresh noise", asked, to_string(verdict))};
}

std::vector<std::string> tune_sentences(const ScenarioTuning& t) {
  std::vector<std::string> sentences = t.tuning.notes;
  if (t.held_out && is_inconsistent(overall_verdict(t.held_out->after))) {
    sentences.push_back(
        "Tuned noise has an error of its own, which as many fresh runs can see: of linear filters of the "
        "right form that were tried 10 to 40 % are called inconsistent on it.");
  }
  if (t.ridge.empty()) return sentences;
  std::string points;
  for (const RidgePoint& point : t.ridge) {
    append_item(points, ridge_sentence(t, point), "; ");
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
  return text_of_json(j);
}

}  // namespace

std::string tuned_toml(const ScenarioTuning& t) {
  return fmt::format("# {} with the noise that {} runs of its world ask for (credence tune).\n{}",
                     printable_line(t.scenario.name), t.scenario.study.runs, canonical_toml(t.tuned));
}

Document tune_document(ScenarioTuning given) {
  const auto shared = std::make_shared<const ScenarioTuning>(std::move(given));
  const ScenarioTuning& t = *shared;
  Document document("Tuning " + t.scenario.name, "The noise that the innovations ask for, by Credence");
  document.answer = tune_answer(t);
  document.json = [shared] { return tune_json(*shared); };

  const ReportTable forecast = tune_forecast_table(t.tuning.forecast);
  const ReportTable noise = tuned_noise_table(t.scenario.name, t.score->engine(), t.tuning);
  const ReportTable gain = tune_gain_table(t);
  const std::vector<std::string> sentences = tune_sentences(t);
  document.show_answer();
  document.show_apart({forecast, noise});
  document.brief.emplace_back(gain);
  document.show(sentences);

  document.section("Noise");
  document.facts({{"world", world_text(t.scenario)},
                  {"runs", fmt::format("{} of {} steps", t.scenario.study.runs, t.scenario.study.steps)},
                  {"engine", t.score->engine()}});
  document.table(noise);
  document.table(gain);
  document.bullets(sentences);
  document.section("What could be known");
  document.table(forecast);
  if (t.tuning.anything_known()) {
    document.section("Figures");
    document.figure("profiles", [shared] { return tune_profile_figure(*shared); });
    if (t.ridge_of) document.figure("surface", [shared] { return tune_surface_figure(*shared); });
    document.section("Tuned scenario");
    document.verbatim(tuned_toml(t));
  }
  document.section("Settings");
  document.verbatim(canonical_toml(t.scenario));
  return document;
}

}  // namespace credence::internal
