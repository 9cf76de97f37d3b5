#include "reports/document/tuning/replay_tune_report.h"

#include <fmt/format.h>

#include <array>

#include "core/number_text.h"
#include "reports/document/tuning/tuning_tables.h"
#include "reports/document/verdict_text.h"
#include "reports/figures/tune_figures.h"
#include "reports/render/json_numbers.h"

namespace credence::internal {
namespace {

constexpr const char* kReplayEngine = "replay as a black box, the same observations";

Verdict verdict_of(const InnovationTests& tests, double confidence) {
  if (is_inconsistent(tests.nis.verdict)) return tests.nis.verdict;
  for (const double p : tests.adjusted_p_value) {
    if (p <= 1.0 - confidence) return Verdict::mixed;
  }
  return tests.nis.verdict;
}

Json left_out_tests_json(const InnovationTests& tests, double confidence) {
  return {{"verdict", to_string(verdict_of(tests, confidence))},
          {"nis", {{"mean", tests.nis.mean}, {"expected", tests.nis.expected}}},
          {"nis_p_value", tests.adjusted_p_value[0]},
          {"law_p_value", tests.adjusted_p_value[1]},
          {"whiteness_p_value", tests.adjusted_p_value[2]},
          {"mean_p_value", tests.adjusted_p_value[3]},
          {"noise_scale",
           {{"scale", tests.noise_scale.scale},
            {"lower", tests.noise_scale.lower},
            {"upper", tests.noise_scale.upper}}}};
}

Json left_out_json(const ReplayTuning& t) {
  if (t.left_out.empty()) return nullptr;
  Json j = left_out_tests_json(t.after, t.tuning.confidence);
  j["runs"] = t.left_out.size();
  j["parts_are"] = t.parts_are_logs ? "logs" : "fifths";
  j["before"] = left_out_tests_json(t.before, t.tuning.confidence);
  j["parts"] = json_list(t.left_out, [&](const LeftOutPart& part) -> Json {
    Json values;
    for (std::size_t i = 0; i < part.values.size(); ++i) values[t.tuning.coordinates[i]] = part.values[i];
    return {{"name", part.name},
            {"sights", part.observations},
            {"tuned_apart", part.tuned_apart},
            {"tuned_on_the_others", std::move(values)},
            {"nis", {{"before", part.nis_before}, {"after", part.nis_after}}},
            {"log_score", {{"before", part.score_before}, {"after", part.score_after}}}};
  });
  return j;
}

ReportTable left_out_table(const ReplayTuning& t) {
  ReportTable table{
      .title =
          t.parts_are_logs ? "Each log by the noise of the others" : "Each fifth by the noise of the others",
      .columns = {{"", ColumnAlign::words},
                  {"observations"},
                  {"mean NIS, present"},
                  {"tuned"},
                  {"log score, present"},
                  {"tuned"}},
      .notes = {"Mean NIS of an observation: 2 is expected. Log score of an observation: higher is better."}};
  for (const std::string& name : t.tuning.coordinates) table.columns.push_back({tuned_name(name)});
  for (const LeftOutPart& part : t.left_out) {
    std::vector<TableCell> row{part.name,           part.observations,      {part.nis_before, 3},
                               {part.nis_after, 3}, {part.score_before, 4}, {part.score_after, 4}};
    for (const double value : part.values) row.emplace_back(value, 3);
    table.add(std::move(row));
  }
  return table;
}

ReportTable left_out_tests_table(const ReplayTuning& t) {
  ReportTable table{.title = "Innovations of all parts left out",
                    .columns = {{"p-value of", ColumnAlign::words}, {"present"}, {"tuned"}},
                    .notes = {"Adjusted for being four."}};
  static constexpr std::array<const char*, 4> kTests = {"mean NIS", "law of the NIS", "whiteness",
                                                        "mean innovation"};
  for (std::size_t i = 0; i < kTests.size(); ++i) {
    table.add(
        {kTests[i], p_value_text(t.before.adjusted_p_value[i]), p_value_text(t.after.adjusted_p_value[i])});
  }
  table.add({"verdict", verdict_cell(verdict_of(t.before, t.tuning.confidence)),
             verdict_cell(verdict_of(t.after, t.tuning.confidence))});
  return table;
}

std::string settings_text(const ReplayTuning& t) {
  std::string text;
  for (const TunedParameter& p : t.tuning.parameters) {
    if (p.identifiable) text += fmt::format(" --set {}={}", p.name, number_text(p.value, 4));
  }
  return text;
}

ReportAnswer replay_tune_answer(const ReplayTuning& t) {
  if (!t.tuning.anything_known()) return nothing_told(t.tuning);
  const Verdict verdict = left_out_verdict(t);
  const auto apart = std::ranges::count(t.left_out, true, &LeftOutPart::tuned_apart);
  const bool all = apart == std::ssize(t.left_out);
  const std::string parts = all ? "parts" : fmt::format("parts, {} of {} of them,", apart, t.left_out.size());
  return {verdict == Verdict::consistent && all && t.tuning.converged ? CellTone::good : CellTone::caution,
          fmt::format("{}; on {} that it was not tuned on the filter is {}, mean NIS {} where {} "
                      "is expected ({} before)",
                      asked_noise_text("The data of " + t.name, t.tuning), parts, to_string(verdict),
                      number_text(t.after.nis.mean, 3), number_text(t.after.nis.expected, 3),
                      number_text(t.before.nis.mean, 3))};
}

std::vector<std::string> replay_tune_sentences(const ReplayTuning& t) {
  std::vector<std::string> sentences = t.tuning.notes;
  if (t.left_out_by_gate > 0) {
    sentences.push_back(
        fmt::format("{} observations that the present gate rejects are left out whatever the noise, and "
                    "there is no gate: which observations count must not depend on what is tuned. The law of "
                    "those that are left is cut a little.",
                    t.left_out_by_gate));
  }
  for (const LeftOutPart& part : t.left_out) {
    if (part.tuned_apart) continue;
    sentences.push_back(
        fmt::format("{}: the others found no better noise than that of all data, of which it is a part; what "
                    "it shows is no proof.",
                    part.name));
  }
  if (!t.left_out.empty()) {
    sentences.push_back(fmt::format("To replay with it:{}", settings_text(t)));
  }
  return sentences;
}

std::string replay_tune_json(const ReplayTuning& t) {
  Json j;
  j["schema"] = kSchema;
  j["name"] = t.name;
  j["engine"] = kReplayEngine;
  j.update(tuning_json(t.tuning));
  j["left_out_by_gate"] = t.left_out_by_gate;
  j["held_out"] = left_out_json(t);
  j["notes"] = replay_tune_sentences(t);
  return text_of_json(j);
}

}  // namespace

Verdict left_out_verdict(const ReplayTuning& t) { return verdict_of(t.after, t.tuning.confidence); }

Document replay_tune_document(const ReplayTuning& t, const ReplayScore& score) {
  Document document("Tuning " + t.name, "The noise that the innovations ask for, by Credence");
  document.answer = replay_tune_answer(t);
  document.json = [t] { return replay_tune_json(t); };

  ReportTable forecast = tune_forecast_table(t.tuning.forecast);
  forecast.notes.emplace_back(
      "A step is an observation. From how the scores of stretches vary with the present noise: too hopeful "
      "where that is far off.");
  std::vector<ReportTable> noise{tuned_noise_table(t.name, kReplayEngine, t.tuning),
                                 score_gain_table(t.tuning)};
  if (!t.left_out.empty()) {
    noise.back().notes.push_back(likelihood_ratio_text(t.tuning));
    noise.push_back(left_out_table(t));
    noise.push_back(left_out_tests_table(t));
  }
  const std::vector<std::string> sentences = replay_tune_sentences(t);
  document.show_answer();
  document.show_apart({forecast});
  document.show_apart(noise);
  document.show(sentences);

  document.section("Noise");
  for (const ReportTable& table : noise) document.table(table);
  document.bullets(sentences);
  document.section("What could be known");
  document.table(forecast);
  if (t.tuning.anything_known()) {
    document.section("Figures");
    document.figure("profiles", [tuning = t.tuning, &score] {
      return tune_profile_figure(score, tuning,
                                 [](const std::string& key) { return ScenarioScore::Key{key}; });
    });
  }
  return document;
}

}  // namespace credence::internal
