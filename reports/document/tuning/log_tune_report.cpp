#include "reports/document/tuning/log_tune_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/number_text.h"
#include "reports/document/tuning/tuning_tables.h"
#include "reports/document/verdict_text.h"
#include "reports/render/json_numbers.h"

namespace credence::internal {
namespace {

std::string scale_name(const InnovationTuning& t) {
  return t.name.empty() ? "factor on S" : fmt::format("factor on S of {}", t.name);
}

bool identified(const InnovationTuning& t) { return t.scale.reason.empty(); }

Json sensor_scale_json(const InnovationTuning& t) {
  Json j{{"name", scale_name(t)},
         {"value", identified(t) ? Json(t.scale.scale) : Json(nullptr)},
         {"lower", t.scale.lower},
         {"upper", t.scale.upper},
         {"identifiable", identified(t)},
         {"steps_for_10_percent", t.steps_for_10_percent},
         {"before", 1.0}};
  if (!identified(t)) j["null_reason"] = t.scale.reason;
  return j;
}

Json tuned_sensor_json(const InnovationTuning& t) {
  Json j;
  j["name"] = t.name;
  j["values"] = t.values;
  j["left_out"] = t.left_out;
  j["dof"] = t.dof;
  j["lag_one_correlation"] = t.lag_one;
  j["lag_one_band"] = t.band;
  j["whiteness_p_value"] = t.whiteness_p_value;
  j["gain"] = to_string(t.gain);
  j["comes_first"] = text_or_null(t.comes_first);
  j["log_score"] = {{"before", t.score_before},
                    {"after", t.score_after},
                    {"likelihood_ratio_p_value", t.likelihood_ratio_p_value}};
  j["held_out"] = {{"verdict", to_string(t.left_out_parts.verdict)},
                   {"nis", {{"mean", t.left_out_parts.mean_nis}, {"expected", t.dof}}},
                   {"runs", t.left_out_parts.parts},
                   {"parts_are", t.left_out_parts.of_runs ? "runs" : "stretches"},
                   {"rejected", t.left_out_parts.tested ? Json(t.left_out_parts.rejected) : Json()}};
  return j;
}

std::string scale_text(const InnovationTuning& t) {
  return interval_text(t.scale.scale, t.scale.lower, t.scale.upper);
}
bool scale_agrees(const InnovationTuning& t) { return t.scale.lower <= 1.0 && t.scale.upper >= 1.0; }

/// "S should be 3.2 times what it is (2.9 … 3.5)", of each sensor.
ReportAnswer log_tune_answer(const std::vector<InnovationTuning>& sensors) {
  std::string answer;
  for (const InnovationTuning& t : sensors) {
    answer += answer.empty() ? "" : "; ";
    if (!t.name.empty()) answer += t.name + ": ";
    if (!t.comes_first.empty()) {
      answer +=
          t.comes_first + ", which comes first: until then neither a factor on S nor the gain can be told";
      continue;
    }
    answer +=
        !identified(t) ? "no factor on S can be told"
        : scale_agrees(t)
            ? fmt::format("S agrees with its innovations; most likely is {} times what it is", scale_text(t))
            : fmt::format("S should be {} times what it is", scale_text(t));
    if (t.gain != GainError::none_seen) {
      answer += t.gain == GainError::other ? ", and the innovations are correlated"
                                           : fmt::format(", and the gain is {}", to_string(t.gain));
    }
  }
  const bool all_fit = std::ranges::all_of(sensors, [](const InnovationTuning& t) {
    return t.comes_first.empty() && t.gain == GainError::none_seen && identified(t) && scale_agrees(t);
  });
  return {all_fit ? CellTone::good : CellTone::caution, answer};
}

TableCell gain_cell(const InnovationTuning& t) {
  if (!t.comes_first.empty()) return {"not to be trusted", CellTone::caution};
  return {std::string(to_string(t.gain)),
          t.gain == GainError::none_seen ? CellTone::plain : CellTone::caution};
}

ReportTable log_tune_table(const std::string& name, const std::vector<InnovationTuning>& sensors) {
  using enum ColumnAlign;
  ReportTable table{.title = fmt::format("{}: what innovations alone can tell", name),
                    .columns = {{"sensor", words},
                                {"innovations"},
                                {"factor on S", words},
                                {"lag-one correlation", words},
                                {"gain", words},
                                {"left out one by one", words}}};
  for (const InnovationTuning& t : sensors) {
    const LeftOut& parts = t.left_out_parts;
    table.add({t.name.empty() ? "–" : t.name, t.values, identified(t) ? scale_text(t) : "not identifiable",
               std::isnan(t.lag_one)
                   ? "–"
                   : fmt::format("{} (white: within ±{})", number_text(t.lag_one, 2), number_text(t.band, 2)),
               gain_cell(t),
               parts.tested ? fmt::format("{} of {} {} rejected", parts.rejected, parts.parts,
                                          parts.of_runs ? "runs" : "stretches")
                            : "not tested"});
  }
  table.notes.emplace_back(
      "Left out: the mean NIS of each part over that of the others, by the F law, with the variance that NIS "
      "has, adjusted by Holm, where "
      "the innovations look white.");
  return table;
}

std::vector<std::string> log_tune_sentences(const std::vector<InnovationTuning>& sensors) {
  std::vector<std::string> first, sentences;
  for (const InnovationTuning& t : sensors) {
    for (const std::string& note : t.notes) {
      const bool named = sensors.size() > 1 && &note != &t.notes.front();
      const std::string sentence = named ? fmt::format("{}: {}", t.name, note) : note;
      std::vector<std::string>& of = note.starts_with(kComesFirst) ? first : sentences;
      if (std::ranges::find(of, sentence) == of.end()) of.push_back(sentence);
    }
  }
  sentences.insert(sentences.begin(), first.begin(), first.end());
  const auto blocked =
      std::ranges::count_if(sensors, [](const InnovationTuning& t) { return !t.comes_first.empty(); });
  if (blocked > 0 && blocked < std::ssize(sensors)) {
    sentences.emplace_back(
        "What is wrong in one sensor reaches the others' innovations through the state: tune them once it is "
        "mended.");
  }
  return sentences;
}

std::string log_tune_json(const std::string& name, const std::vector<InnovationTuning>& sensors) {
  Json j;
  j["schema"] = kSchema;
  j["name"] = name;
  j["engine"] = "innovations and S alone";
  j["parameters"] = json_list(sensors, sensor_scale_json);
  j["sensors"] = json_list(sensors, tuned_sensor_json);
  j["correlation"] = Json::array();
  // Of one sensor the members of a scenario's document too.
  const bool one = sensors.size() == 1;
  j["log_score"] = one ? j["sensors"][0]["log_score"] : Json(nullptr);
  j["held_out"] = one ? j["sensors"][0]["held_out"] : Json(nullptr);
  j["notes"] = log_tune_sentences(sensors);
  return text_of_json(j);
}

}  // namespace

Document log_tune_document(const std::string& name, const std::vector<InnovationTuning>& sensors) {
  Document document("Tuning " + name, "What innovations alone can tell, by Credence");
  document.answer = log_tune_answer(sensors);
  document.json = [name, sensors] { return log_tune_json(name, sensors); };

  const ReportTable table = log_tune_table(name, sensors);
  const std::vector<std::string> sentences = log_tune_sentences(sensors);
  document.show_answer();
  document.brief.emplace_back(table);
  document.show(sentences);

  document.section("Sensors");
  document.table(table);
  document.bullets(sentences);
  return document;
}

}  // namespace credence::internal
