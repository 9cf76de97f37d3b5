#include "reports/document/replay/replay_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <span>

#include "analysis/evidence/verdicts/judgement_tests.h"
#include "core/nan.h"
#include "core/number_text.h"
#include "reports/document/study/judgement_json.h"
#include "reports/document/verdict_text.h"
#include "reports/figures/replay_figures.h"
#include "reports/render/json_numbers.h"

namespace credence::internal {
namespace {

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

TableCell map_verdict(const NormalisedError& error, double p_value, double confidence) {
  if (!error.ok) return verdict_cell(Verdict::undecided);
  if (p_value > 1.0 - confidence) return verdict_cell(Verdict::consistent);
  return verdict_cell(error.value > static_cast<double>(error.dof) ? Verdict::optimistic
                                                                   : Verdict::pessimistic);
}

ReportTable map_table(std::span<const ReportedReplay> replays, const ReplayJudgement& judgement) {
  using enum ColumnAlign;
  ReportTable table{.title = "The final map against the survey, one vector of all its landmarks",
                    .columns = {{"NEES", words}, {"value"}, {"dof"}, {"p"}, {"verdict", words}}};
  const double confidence = judgement.logs.analysis.judgement.confidence;
  for (std::size_t i = 0; i < judgement.maps.size(); ++i) {
    const std::string run = replays.size() > 1 ? replays[i].result.run + ": " : "";
    const auto add = [&](const char* what, const NormalisedError& error, double p_value) {
      table.add({run + what, error.ok ? TableCell(error.value) : TableCell("–"), TableCell(error.dof),
                 p_value_text(p_value), map_verdict(error, p_value, confidence)});
      if (!error.ok) table.notes.push_back(fmt::format("{}{}: {}.", run, what, error.reason));
    };
    const MapConsistency& map = judgement.maps[i];
    add("the map as it lies", map.placed, map.placed_p_value);
    add("its shape", map.shape, map.shape_p_value);
  }
  return table;
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
             fmt::format("{} observations, each by itself", r.nis.count)});
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

/// Adjusted for all tests of the battery; of several the smallest.
double adjusted_p_value(const Judgement& j, std::initializer_list<const char*> names) {
  double smallest = kNaN;
  for (const char* name : names) {
    const auto test = std::ranges::find(j.tests, name, &NamedTest::name);
    if (test != j.tests.end()) smallest = std::fmin(smallest, test->adjusted);
  }
  return smallest;
}

Json innovations_json(const Judgement& judgement, const NoiseScale& noise) {
  const SensorJudgement s = judgement.sensors.empty() ? SensorJudgement{} : judgement.sensors.front();
  Json j;
  j["nis"] = verdict_json(judgement.nis);
  j["goodness_of_fit"] = {{"kolmogorov", s.fit.kolmogorov},
                          {"kolmogorov_p_value", s.fit.kolmogorov_p_value},
                          {"anderson", s.fit.anderson},
                          {"anderson_p_value", s.fit.anderson_p_value},
                          {"reason", text_or_null(s.fit.reason)}};
  j["whiteness"] = {{"autocorrelation", s.whiteness.autocorrelation},
                    {"band", s.whiteness.band},
                    {"p_value", s.whiteness.p_value},
                    {"white", s.whiteness.reason.empty() ? Json(s.whiteness.white) : Json(nullptr)},
                    {"reason", text_or_null(s.whiteness.reason)}};
  j["mean"] = {{"value", json_vector(s.mean.mean)},
               {"p_value", s.mean.p_value},
               {"reason", text_or_null(s.mean.reason)}};
  j["noise_scale"] = {{"value", noise.scale},
                      {"lower", noise.lower},
                      {"upper", noise.upper},
                      {"stretches", noise.stretches},
                      {"reason", text_or_null(noise.reason)}};
  j["adjusted_p_value"] = {
      adjusted_p_value(judgement, {"NIS"}), adjusted_p_value(judgement, {kNisBody, kNisTails}),
      adjusted_p_value(judgement, {kWhiteness}), adjusted_p_value(judgement, {kInnovationMean})};
  return j;
}

Json error_json(const NormalisedError& error, double p_value) {
  return {{"nees", error.ok ? Json(error.value) : Json(nullptr)},
          {"dof", error.dof},
          {"p_value", p_value},
          {"reason", text_or_null(error.reason)}};
}

Json replay_judgement_json(std::span<const ReportedReplay> replays, const ReplayJudgement& judgement) {
  const Judgement& all = judgement.logs.analysis.judgement;
  Json j;
  j["verdict"] = to_string(all.word.verdict);
  j["word"] = word_json(all.word);
  j["nees"] = verdict_json(all.nees);
  j["nees"]["run_means"] = json_list(
      replays, [](const ReportedReplay& replay) { return mean_json(replay.result.vehicle_nees)["mean"]; });
  j["innovations"] = innovations_json(all, judgement.noise_scale);
  j["battery"] = judgement_json(all);
  j["maps"] = json_list(judgement.maps, [](const MapConsistency& map) -> Json {
    return {{"placed", error_json(map.placed, map.placed_p_value)},
            {"shape", error_json(map.shape, map.shape_p_value)}};
  });
  j["limits"] = judgement.logs.remarks;
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
  j["judgement"] = replay_judgement_json(replays, judgement);
  j["null_reason"] = "null: no value contributes to this number, or the reason beside it";
  return text_of_json(j);
}

std::string file_name(const ReplayResult& result) {
  std::string name = result.dataset;
  for (const char c : result.run) name += (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') ? c : '-';
  return name;
}

}  // namespace

Document replay_document(const std::vector<ReportedReplay>& replays, const ReplayJudgement& judgement) {
  const bool alone = replays.size() == 1;
  Document document = log_document(judgement.logs);
  document.subtitle = "Real data replayed";
  document.json = [replays, judgement] { return replay_json(replays, judgement); };

  const ReportTable runs = alone ? replay_table(replays.front()) : replays_table(replays);
  const ReportTable map = map_table(replays, judgement);
  document.show({""});
  document.show_apart({map, runs});

  document.section("Map");
  document.table(map);
  if (!alone) document.table(runs);
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
