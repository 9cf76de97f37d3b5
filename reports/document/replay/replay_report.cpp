#include "reports/document/replay/replay_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "core/nan.h"
#include "reports/document/study/judgement_json.h"
#include "reports/document/verdict_text.h"
#include "reports/figures/replay_figures.h"
#include "reports/render/json_numbers.h"
#include "reports/render/number_text.h"

namespace credence::internal {
namespace {

bool has_true_heading(const ReplayResult& r) {
  return !r.references.empty() && r.references.front().dof == 3;
}

std::string mean_text(const ReplayMean& mean) {
  return mean.count > 0 ? number_text(mean.mean()) : std::string("none");
}

std::string unused_rows(const ReplayResult& r) {
  return fmt::format("{} of other robots, {} of unknown barcodes, {} before the start", r.rows_of_robots,
                     r.rows_of_unknown_barcodes, r.rows_before_start);
}

void add_counts(ReportTable& table, const ReplayResult& r) {
  table.add({"observations", r.observations, "", fmt::format("{} times", r.scans_with_observations)});
  table.add({"associated", r.associated, "",
             r.settings.filter.association == ReplayAssociation::survey
                 ? std::string("by the survey")
                 : fmt::format("by the survey; the filter chose another for {}", r.mismatched)});
  table.add({"used", r.updated, "", fmt::format("{} more began a landmark", r.initialised)});
  table.add({"rejected by the gate", r.rejected, "",
             r.settings.filter.gate > 0.0
                 ? fmt::format("gate of {} %", number_text(100.0 * r.settings.filter.gate, 4))
                 : std::string("no gate")});
  if (r.settings.filter.gate > 0.0)
    table.add({"ambiguous", r.ambiguous, "", "within the gate of several landmarks"});
  if (r.dataset == "mrclam")
    table.add({"rows not used", r.rows_of_robots + r.rows_of_unknown_barcodes + r.rows_before_start, "",
               unused_rows(r)});
}

TableCell says(double p_value, double confidence, const char* accepted, const char* rejected) {
  if (!std::isfinite(p_value)) return {"not tested", CellTone::muted};
  return p_value > 1.0 - confidence ? TableCell(accepted, CellTone::good)
                                    : TableCell(rejected, CellTone::caution);
}

TableCell map_verdict(const NormalisedError& error, double p_value, double confidence) {
  if (!error.ok) return verdict_cell(Verdict::undecided);
  if (p_value > 1.0 - confidence) return verdict_cell(Verdict::consistent);
  return verdict_cell(error.value > static_cast<double>(error.dof) ? Verdict::optimistic
                                                                   : Verdict::pessimistic);
}

void add_map(ReportTable& table, const char* what, const NormalisedError& error, double p_value,
             const std::string& run, double confidence) {
  table.add(
      {what, error.ok ? TableCell(error.value) : TableCell("–"), TableCell(error.dof), p_value_text(p_value),
       map_verdict(error, p_value, confidence),
       error.ok ? fmt::format("{}one vector of {} dof", run, error.dof) : run + std::string(error.reason)});
}

std::string noise_words(const NoiseScale& scale) {
  if (!scale.reason.empty()) return fmt::format("no interval: {}", scale.reason);
  return fmt::format("{} … {} by {} stretches; deviations × {}", number_text(scale.lower, 3),
                     number_text(scale.upper, 3), scale.stretches, number_text(std::sqrt(scale.scale), 3));
}

TableCell noise_says(const NoiseScale& scale) {
  if (!scale.reason.empty()) return verdict_cell(Verdict::undecided);
  if (scale.upper < 1.0) return verdict_cell(Verdict::pessimistic);
  return verdict_cell(scale.lower > 1.0 ? Verdict::optimistic : Verdict::consistent);
}

ReportTable replay_table(const ReportedReplay& replay) {
  using enum ColumnAlign;
  const ReplayResult& r = replay.result;
  ReportTable table{.title = fmt::format("{}, {} s", replay_name(r), number_text(r.duration_s, 4)),
                    .columns = {{"", words}, {"value"}, {"expected"}, {"from", words}}};
  add_counts(table, r);
  const bool heading = has_true_heading(r);
  const char* reference = heading ? "against motion capture" : "against GPS";
  table.add({"mean NIS of an observation", mean_text(r.nis), number_text(r.nis.expected),
             fmt::format("{} observations", r.nis.count)});
  table.add({heading ? "mean NEES of the pose" : "mean NEES of the position", mean_text(r.vehicle_nees),
             number_text(r.vehicle_nees.expected), fmt::format("{} references", r.vehicle_nees.count)});
  table.add({"mean NEES of a landmark", mean_text(r.landmark_nees), number_text(r.landmark_nees.expected),
             fmt::format("{} landmarks", r.landmark_nees.count)});
  if (replay.ideal) {
    table.add({"NEES of the pose, ideal", mean_text(replay.ideal->vehicle_nees),
               number_text(replay.ideal->vehicle_nees.expected), "Jacobians at the truth"});
    table.add({"NEES of a landmark, ideal", mean_text(replay.ideal->landmark_nees),
               number_text(replay.ideal->landmark_nees.expected), "Jacobians at the truth"});
  }
  table.add({"vehicle RMSE (m)", r.vehicle_rmse, "", reference});
  if (heading) table.add({"heading RMSE (°)", r.heading_rmse_deg, "", reference});
  table.add({"landmark RMS (m)", r.landmark_rms, "", "against the survey"});
  table.add(
      {"landmark RMS, aligned (m)", r.landmark_rms_aligned, "", "the survey moved rigidly onto the map"});
  table.add({"largest tr P of the position (m²)", r.covariance.vehicle_max, "", ""});
  table.add({"final tr P of the landmarks (m²)", r.covariance.landmarks_final, "",
             fmt::format("{} landmarks", r.map.size())});
  if (r.not_converged > 0)
    table.notes.push_back(fmt::format(
        "{} updates in which an iteration of the filter ended before it had settled.", r.not_converged));
  return table;
}

ReportTable replays_table(std::span<const ReportedReplay> replays) {
  using enum ColumnAlign;
  ReportTable table{.title = "Runs",
                    .columns = {{"run", words},
                                {"observations"},
                                {"rejected"},
                                {"not used"},
                                {"NIS"},
                                {"NEES"},
                                {"ideal"},
                                {"NEES of a landmark"},
                                {"ideal"},
                                {"RMSE (m)"},
                                {"heading (°)"},
                                {"map (m)"},
                                {"aligned (m)"}},
                    .notes = {"NEES of the pose; ideal: with Jacobians at the truth. Not used: rows of other "
                              "robots, of unknown barcodes and before the start."}};
  for (const ReportedReplay& replay : replays) {
    const ReplayResult& r = replay.result;
    table.add({replay_name(r), r.observations, r.rejected,
               r.rows_of_robots + r.rows_of_unknown_barcodes + r.rows_before_start, mean_text(r.nis),
               mean_text(r.vehicle_nees), replay.ideal ? mean_text(replay.ideal->vehicle_nees) : "–",
               mean_text(r.landmark_nees), replay.ideal ? mean_text(replay.ideal->landmark_nees) : "–",
               r.vehicle_rmse, r.heading_rmse_deg, r.landmark_rms, r.landmark_rms_aligned});
  }
  return table;
}

// The worst of both: innovations that contradict S are never behind a green word for the error.
ReportAnswer replay_answer(std::span<const ReportedReplay> replays, const ReplayJudgement& judgement) {
  const ConsistencyVerdict& nees = judgement.nees.verdict;
  const NoiseScale& noise = judgement.innovations.noise_scale;
  const char* what = has_true_heading(replays.front().result) ? "pose" : "position";
  const std::string name = replays.size() == 1
                               ? replay_name(replays.front().result)
                               : fmt::format("{} runs of {}", replays.size(), replays.front().result.dataset);
  ReportAnswer answer{verdict_cell(nees.verdict).tone, ""};
  answer.text =
      nees.verdict == Verdict::undecided
          ? fmt::format("{}: undecided, {}", name, nees.reason)
          : fmt::format("EKF-SLAM on {} is {} in {}: NEES {} where {} is expected", name,
                        to_string(nees.verdict), what, number_text(nees.mean), number_text(nees.expected));
  const TableCell innovations = noise_says(noise);
  if (innovations.tone == CellTone::good || !noise.reason.empty()) return answer;
  answer.tone = std::max(answer.tone, innovations.tone);
  answer.text +=
      fmt::format("; {} in its innovations: all variances × {} ({} … {}) would suit them", innovations.text,
                  number_text(noise.scale, 3), number_text(noise.lower, 3), number_text(noise.upper, 3));
  return answer;
}

ReportTable judgement_table(std::span<const ReportedReplay> replays, const ReplayJudgement& judgement) {
  using enum ColumnAlign;
  ReportTable table{
      .title = replays.size() == 1 ? "What this run supports" : "What these runs support together",
      .columns = {{"test", words}, {"value"}, {"expected"}, {"p"}, {"says", words}, {"from", words}},
      .notes = judgement.limits};
  const ConsistencyVerdict& nees = judgement.nees.verdict;
  const double confidence = nees.confidence;
  table.add({has_true_heading(replays.front().result) ? "NEES of the pose" : "NEES of the position",
             nees.mean, nees.expected, p_value_text(nees.p_value), verdict_cell(nees.verdict),
             fmt::format("{} seconds of {} run{}; accepted {} … {}", nees.steps_tested, replays.size(),
                         replays.size() == 1 ? "" : "s", number_text(nees.bounds.lower, 3),
                         number_text(nees.bounds.upper, 3))});
  const InnovationTests& t = judgement.innovations;
  const std::vector<double>& p = t.adjusted_p_value;
  table.add({"mean NIS", t.nis.mean, t.nis.expected, p_value_text(p[0]), verdict_cell(t.nis.verdict),
             fmt::format("{} values; accepted {} … {}", t.nis.count, number_text(t.nis.bounds.lower, 4),
                         number_text(t.nis.bounds.upper, 4))});
  table.add({"NIS against its law", t.fit.kolmogorov, "", p_value_text(p[1]),
             says(p[1], confidence, "fits", "does not fit"),
             "Kolmogorov's D; p with Anderson and Darling's A²"});
  double largest = 0.0;
  for (const double rho : t.whiteness.autocorrelation)
    if (std::abs(rho) > std::abs(largest)) largest = rho;
  table.add({"whiteness", largest, 0.0, p_value_text(p[2]), says(p[2], confidence, "white", "not white"),
             t.whiteness.reason.empty()
                 ? std::string("largest autocorrelation of lags 1 to 10; Hosking's test")
                 : std::string(t.whiteness.reason)});
  table.add({"mean innovation (σ)", t.mean.size() > 0 ? TableCell(t.mean(0)) : TableCell("–"), 0.0,
             p_value_text(p[3]), says(p[3], confidence, "no bias seen", "biased"),
             t.mean.size() < 2
                 ? std::string("range")
                 : fmt::format("range; bearing {}{}", number_text(t.mean(1), 3),
                               t.mean_reason.empty() ? "" : "; " + std::string(t.mean_reason))});
  table.add({"noise scale of variances", t.noise_scale.scale, 1.0, "", noise_says(t.noise_scale),
             noise_words(t.noise_scale)});
  for (std::size_t i = 0; i < judgement.maps.size(); ++i) {
    const std::string run = replays.size() > 1 ? replays[i].result.run + ": " : "";
    const MapConsistency& map = judgement.maps[i];
    add_map(table, "NEES of the map as it lies", map.placed, map.placed_p_value, run, confidence);
    add_map(table, "NEES of its shape", map.shape, map.shape_p_value, run, confidence);
  }
  return table;
}

// ---- JSON

Json mean_json(const ReplayMean& mean) {
  return {{"mean", mean.count > 0 ? Json(mean.mean()) : Json(nullptr)},
          {"expected", mean.expected},
          {"count", mean.count}};
}

Json counts_json(const ReplayResult& r) {
  return {{"observations", r.observations},
          {"scans_with_observations", r.scans_with_observations},
          {"associated", r.associated},
          {"updated", r.updated},
          {"initialised", r.initialised},
          {"rejected", r.rejected},
          {"unassociated", r.unassociated},
          {"failed", r.failed},
          {"ambiguous", r.ambiguous},
          {"mismatched", r.mismatched},
          {"not_converged", r.not_converged},
          {"times_without_truth", r.times_without_truth},
          {"unused_rows",
           {{"of_robots", r.rows_of_robots},
            {"of_unknown_barcodes", r.rows_of_unknown_barcodes},
            {"before_start", r.rows_before_start}}}};
}

void add_errors(Json& j, const ReplayResult& r) {
  const bool pose = has_true_heading(r);
  j["nis"] = mean_json(r.nis);
  j[pose ? "pose_nees" : "gps_nees"] = mean_json(r.vehicle_nees);
  j["landmark_nees"] = mean_json(r.landmark_nees);
  j["vehicle_rmse"] = r.vehicle_rmse;
  if (pose) j["heading_rmse_deg"] = r.heading_rmse_deg;
  j["landmark_rms"] = r.landmark_rms;
  j["landmark_rms_aligned"] = r.landmark_rms_aligned;
}

Json run_json(const ReportedReplay& replay) {
  const ReplayResult& r = replay.result;
  Json j, settings;
  for (const ReplaySettingText& s : replay_settings_text(r.settings)) settings[s.key] = s.value;
  j["dataset"] = r.dataset;
  if (!r.run.empty()) j["run"] = r.run;
  j["settings"] = std::move(settings);
  j["duration_s"] = r.duration_s;
  j.update(counts_json(r));
  add_errors(j, r);
  j["covariance"] = {{"vehicle_max", r.covariance.vehicle_max},
                     {"vehicle_final", r.covariance.vehicle_final},
                     {"landmarks_max", r.covariance.landmarks_max},
                     {"landmarks_final", r.covariance.landmarks_final}};
  if (replay.ideal) {
    Json ideal;
    ideal["rejected"] = replay.ideal->rejected;
    add_errors(ideal, *replay.ideal);
    j["jacobians_at_truth"] = std::move(ideal);
  }
  return j;
}

Json innovations_json(const InnovationTests& t) {
  Json j;
  j["nis"] = verdict_json(t.nis);
  j["goodness_of_fit"] = {{"kolmogorov", t.fit.kolmogorov},
                          {"kolmogorov_p_value", t.fit.kolmogorov_p_value},
                          {"anderson", t.fit.anderson},
                          {"anderson_p_value", t.fit.anderson_p_value},
                          {"reason", text_or_null(t.fit.reason)}};
  j["whiteness"] = {{"autocorrelation", t.whiteness.autocorrelation},
                    {"band", t.whiteness.band},
                    {"p_value", t.whiteness.p_value},
                    {"white", t.whiteness.white},
                    {"reason", text_or_null(t.whiteness.reason)}};
  j["mean"] = {
      {"value", json_vector(t.mean)}, {"p_value", t.mean_p_value}, {"reason", text_or_null(t.mean_reason)}};
  j["noise_scale"] = {{"value", t.noise_scale.scale},
                      {"lower", t.noise_scale.lower},
                      {"upper", t.noise_scale.upper},
                      {"stretches", t.noise_scale.stretches},
                      {"reason", text_or_null(t.noise_scale.reason)}};
  j["adjusted_p_value"] = t.adjusted_p_value;
  return j;
}

Json error_json(const NormalisedError& error, double p_value) {
  return {{"nees", error.ok ? Json(error.value) : Json(nullptr)},
          {"dof", error.dof},
          {"p_value", p_value},
          {"reason", text_or_null(error.reason)}};
}

Json replay_judgement_json(const ReplayJudgement& judgement) {
  Json j;
  j["nees"] = verdict_json(judgement.nees.verdict);
  j["nees"]["run_means"] = judgement.nees.run_mean;
  j["innovations"] = innovations_json(judgement.innovations);
  j["maps"] = json_list(judgement.maps, [](const MapConsistency& map) -> Json {
    return {{"placed", error_json(map.placed, map.placed_p_value)},
            {"shape", error_json(map.shape, map.shape_p_value)}};
  });
  j["limits"] = judgement.limits;
  return j;
}

std::string replay_json(std::span<const ReportedReplay> replays, const ReplayJudgement& judgement) {
  Json j;
  j["schema"] = kSchema;
  if (replays.size() == 1) {
    j.update(run_json(replays.front()));
  } else {
    j["dataset"] = replays.front().result.dataset;
    j["runs"] = json_list(replays, run_json);
  }
  j["judgement"] = replay_judgement_json(judgement);
  j["null_reason"] = "null: no value contributes to this number, or the reason beside it";
  return text_of_json(j);
}

// ---- Figures

/// NEES of every run over time, and their average with the bounds of its verdict.
Figure nees_figure(std::span<const ReportedReplay> replays, const RecordedNeesVerdict& nees) {
  Panel panel{.title = "NEES over time", .x_label = "time (s)", .y_label = "NEES", .log_y = true};
  for (std::size_t i = 0; i < replays.size(); ++i) {
    FigureData t, value;
    for (const ReplayReference& reference : replays[i].result.references) {
      t.push_back(reference.time_s);
      value.push_back(reference.nees > 0.0 ? reference.nees : kNaN);
    }
    panel.series.push_back(
        line_series(replay_name(replays[i].result), numbered_role(static_cast<Index>(i)), t, value));
  }
  FigureData t, upper;
  for (std::size_t k = 0; k < nees.time_s.size(); ++k) {
    const StepTest& step = nees.verdict.steps[k];
    t.push_back(nees.time_s[k]);
    upper.push_back(step.count > 0 ? step.simultaneous_upper : kNaN);
  }
  panel.series.push_back(
      line_series("a consistent filter's average stays below", ColourRole::bound, t, upper));
  panel.series.push_back(level_series("expected", ColourRole::truth, nees.verdict.expected));
  panel.series.back().stroke = StrokeStyle::dotted;
  return {.name = "nees",
          .caption =
              "NEES of each run against its reference; the bound holds for the average of the runs at "
              "all seconds together.",
          .panels = {panel},
          .row_height = 18.0};
}

std::string file_name(const ReplayResult& result) {
  std::string name = result.dataset;
  for (const char c : result.run) name += (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') ? c : '-';
  return name;
}

}  // namespace

Document replay_document(const std::vector<ReportedReplay>& replays, const ReplayJudgement& judgement) {
  const bool alone = replays.size() == 1;
  const ReplayResult& first = replays.front().result;
  Document document(fmt::format("EKF-SLAM on {}", alone ? replay_name(first) : first.dataset),
                    "Real data replayed");
  document.answer = replay_answer(replays, judgement);
  document.json = [replays, judgement] { return replay_json(replays, judgement); };

  const ReportTable judged = judgement_table(replays, judgement);
  document.show_answer();
  document.show_apart({alone ? replay_table(replays.front()) : replays_table(replays)});
  document.brief.emplace_back(judged);

  document.section("What can be said");
  document.table(judged);
  document.figure(nees_figure(replays, judgement.nees));
  if (!alone) document.table(replays_table(replays));
  for (std::size_t i = 0; i < replays.size(); ++i) {
    const ReplayResult& result = replays[i].result;
    document.section(replay_name(result));
    document.table(replay_table(replays[i]));
    const std::string number = alone ? "" : fmt::format("{}-", i + 1);
    document.figures(replay_figures(number + file_name(result), result));
    std::vector<std::pair<std::string, std::string>> facts;
    for (const ReplaySettingText& s : replay_settings_text(result.settings))
      facts.emplace_back(s.key, s.value);
    document.folded("Settings", [&] { document.facts(facts); });
  }
  return document;
}

}  // namespace credence::internal
