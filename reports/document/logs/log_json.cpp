#include "reports/document/logs/log_json.h"

#include <cmath>

#include "core/nan.h"
#include "reports/document/logs/log_gate.h"
#include "reports/document/study/calibration_report.h"
#include "reports/document/study/judgement_json.h"

namespace credence::internal {
namespace {

Json whiteness_json(const WhitenessTest& w) {
  return with_reason({{"p_value", w.p_value},
                      {"white", w.reason.empty() ? Json(w.white) : Json(nullptr)},
                      {"statistic", w.statistic},
                      {"dof", w.dof},
                      {"autocorrelation", w.autocorrelation},
                      {"band", w.band},
                      {"values", w.values}},
                     w.reason);
}

Json fit_json(const GoodnessOfFit& fit) {
  return with_reason({{"kolmogorov_p_value", fit.kolmogorov_p_value},
                      {"anderson_p_value", fit.anderson_p_value},
                      {"values", fit.count}},
                     fit.reason);
}

Json sensor_json(const SensorJudgement& s, const SensorSums& sums) {
  Json dimensions = json_list(sums.by_dimension, [](const auto& of) -> Json {
    return {{"dimension", of.first}, {"mean", of.second.value.mean}, {"count", of.second.value.count}};
  });
  return {
      {"name", s.name},
      {"nis", verdict_json(s.nis)},
      {"dimensions", std::move(dimensions)},
      {"of_sum", s.of_sum},
      {"fit", fit_json(s.fit)},
      {"whiteness", whiteness_json(s.whiteness)},
      {"components",
       json_list(s.components.components,
                 [](const ComponentVariance& c) -> Json {
                   return {{"factor", c.mean}, {"lower", c.lower}, {"upper", c.upper}, {"count", c.count}};
                 })},
      {"innovation_mean", with_reason({{"p_value", s.mean.p_value}}, s.mean.reason)}};
}

/// `reason` is of the p-value: a run that is long enough has none where its errors stay, last or oscillate.
Json single_run_json(const SingleRunJudgement& s, const SettlingRuns& settle) {
  std::string_view reason = s.time_average.average.reason;
  if (reason.empty() && std::isnan(s.time_average.p_value)) {
    reason = "an error that is not forgotten within a tenth of the run";
  }
  Json j = {{"correlation_time_rows", s.sample.correlation_time},
            {"effective_rows", s.sample.size},
            {"p_value", s.time_average.p_value},
            {"reason", text_or_null(reason)},
            {"runs_to_settle", settle.runs > 0 ? Json(settle.runs) : Json(nullptr)}};
  if (settle.runs == 0) j["runs_to_settle_reason"] = settle.reason;
  return j;
}

/// Of NIS that there are none of.
GoodnessOfFit no_fit() {
  return {.kolmogorov_p_value = kNaN, .anderson_p_value = kNaN, .reason = "no innovations"};
}

Json log_outcomes_json(const CheckedLogs& logs) {
  const StudyStatistics& s = logs.analysis.evidence.study;
  Json j = outcome_counts_json(s);
  j["failures"] = json_list(s.failures, [&](const RunFailure& f) {
    Json failure = failure_json(f);
    const auto run = static_cast<std::size_t>(f.run);
    if (run < logs.run_names.size()) failure["name"] = logs.run_names[run];
    if (const auto said = logs.failures_said.find(f.run); said != logs.failures_said.end()) {
      failure["says"] = said->second;
    }
    return failure;
  });
  return j;
}

/// Of every file with poses: its charts, and the time between estimate and truth.
Json poses_json(const std::vector<LogPoses>& logs) {
  return json_list(logs, [](const LogPoses& log) {
    Json charts = json_list(log.charts.charts, [](const ChartNees& nees) -> Json {
      return {{"chart", nees.chart},
              {"mean_nees_if_written_so", nees.as_written},
              {"p_value", nees.p_value},
              {"mean_nees_carried_over", nees.carried}};
    });
    Json j = {{"file", log.file.string()},
              {"chart", log.charts.declared},
              {"rows", log.charts.rows},
              {"charts", std::move(charts)},
              {"time_offset", nullptr}};
    if (const auto& offset = log.time_offset) {
      j["time_offset"] = with_reason({{"seconds", offset->value_s},
                                      {"lower", offset->lower_s},
                                      {"upper", offset->upper_s},
                                      {"confidence", offset->confidence},
                                      {"estimated", offset->estimated},
                                      {"used", !std::isnan(offset->value_s)},
                                      {"rows", offset->rows},
                                      {"files", offset->files},
                                      {"most_taken_from_nees", offset->taken},
                                      {"p_value_of_one_offset", offset->p_agreement}},
                                     offset->reason);
    }
    return j;
  });
}

Json rows_json(const std::map<std::string, CountedRows>& rows, const char* of_what) {
  return json_list(rows, [of_what](const auto& of) -> Json {
    return {{of_what, of.first}, {"count", of.second.count}, {"first", of.second.first}};
  });
}

}  // namespace

std::string log_json(const CheckedLogs& logs) {
  const LogAnalysis& logged = logs.analysis;
  const Judgement& a = logged.judgement;
  const Evidence& s = logged.evidence;
  Json j;
  j["schema"] = kSchema;
  j["files"] = logs.files;
  j["rows"] = s.rows;
  j["rejected_rows"] = s.rejected_rows();
  j["rejected"] = rows_json(s.rejected, "reason");
  j["wrongly_certain"] = rows_json(s.wrongly_certain, "state");
  j["unmatched_rows"] = logs.unmatched_rows;
  j["format"] = logs.format;
  j["remarks"] = logs.mistakes;
  for (std::string& remark : logs.all_remarks()) j["remarks"].push_back(std::move(remark));
  j["poses"] = poses_json(logs.poses);
  if (logs.gate) j["baseline"] = gate_json(*logs.gate);
  j["calibration"] = logs.calibration.unit_count == 0 && logs.units.names.empty()
                         ? Json(nullptr)
                         : calibration_json(logs.calibration, logs.units, s.layout.states);
  j["runs"] = s.study.runs;
  j["steps"] = s.study.steps.size();
  j["step_stride"] = s.step_stride;
  j["state_dim"] = s.state_dim;
  j["complete"] = logged.complete;
  j["verdict"] = to_string(a.word.verdict);
  j["word"] = word_json(a.word);
  j["nees"] = verdict_json(a.nees);
  j["nis"] = verdict_json(a.nis);
  if (a.vehicle_nees) j["vehicle_nees"] = verdict_json(*a.vehicle_nees);
  Json blocks = Json::object();
  for (const BlockVerdict& block : a.blocks) blocks[block.name] = verdict_json(block.verdict);
  j["blocks"] = std::move(blocks);
  j["responsible_block"] = responsible_block_json(a);
  Json sensors = Json::array();
  for (std::size_t i = 0; i < a.sensors.size(); ++i) {
    sensors.push_back(sensor_json(a.sensors[i], s.sensors[i]));
  }
  j["sensors"] = std::move(sensors);
  j["nis_fit"] = fit_json(a.sensors.empty() ? no_fit() : a.sensors.front().fit);
  j["single_run"] = a.single ? single_run_json(*a.single, a.settle_nees) : Json(nullptr);
  if (a.sensitivity) {
    j["sensitivity"] = {{"rule", "values beyond the upper 1e-6 quantile of their chi-square law left out"},
                        {"nees_outliers", a.sensitivity->nees_outliers},
                        {"nis_outliers", a.sensitivity->nis_outliers},
                        {"nees", verdict_json(a.sensitivity->nees)},
                        {"nis", verdict_json(a.sensitivity->nis)}};
  }
  j["covariance"] = covariance_json(logged.covariance);
  j["covariance"]["trace_prior"] = nullptr;
  j["rmse"] = errors_json(logged.errors);
  j["battery"] = judgement_json(a);
  j["outcomes"] = log_outcomes_json(logs);
  j["null_reason"] = "null: no row contributes to this number, or a log cannot know it";
  return text_of_json(j);
}

}  // namespace credence::internal
