#include "reports/document/study/plan_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "core/append_item.h"
#include "core/number_text.h"
#include "reports/render/json_numbers.h"

namespace credence::internal {
namespace {

Json verdict_plan_json(const VerdictPlan& plan) {
  Json json{{"steps", plan.design.steps}, {"dof_per_step", plan.design.dof_per_step}};
  json["detect"] = json_list(plan.detections, [](const DetectionPlan& detection) -> Json {
    return {{"factor", detection.factor},
            {"runs", detection.needed.runs},
            {"power", detection.needed.power},
            {"word_runs", detection.word.runs},
            {"seconds", detection.seconds}};
  });
  json["detectable"] = {{"below", plan.detectable.below}, {"above", plan.detectable.above}};
  return json;
}

Json study_plan_json(const StudyPlan& plan) {
  Json json{{"confidence", plan.scenario.study.confidence}, {"runs_in_scenario", plan.scenario.study.runs}};
  json["nees"] = verdict_plan_json(plan.nees);
  json["nees"]["effective_steps"] = plan.nees.design.effective_steps;
  json["nees"]["effective_steps_from"] = to_string(plan.correlation);
  json["nis"] = verdict_plan_json(plan.nis);
  json["precision"] = {{"relative", plan.question.precision},
                       {"runs", plan.runs_for_precision},
                       {"seconds", plan.pilot.seconds_for(plan.runs_for_precision)}};
  json["runs"] = plan.runs_for_all;
  json["seconds"] = plan.pilot.seconds_for(plan.runs_for_all);
  json["pilot"] = {{"runs", plan.pilot.runs},
                   {"seconds", plan.pilot.seconds},
                   {"threads", plan.pilot.threads},
                   {"seconds_per_run", plan.pilot.seconds_per_run},
                   {"evidence_runs", plan.pilot.evidence_runs},
                   {"evidence_seconds_per_run", plan.pilot.evidence_seconds_per_run}};
  return json;
}

/// A factor near 1 with the digits that tell it from 1.
std::string factor_text(double factor) {
  constexpr int kFewest = 3, kMost = 12;
  const double off = std::abs(factor - 1.0);
  const int decimals = off > 0.0 ? -static_cast<int>(std::floor(std::log10(off) + 1e-9)) : 0;
  return number_text(factor, std::clamp(factor < 1.0 ? decimals : decimals + 1, kFewest, kMost));
}

void add_detections(const char* name, const VerdictPlan& plan, ReportTable& table) {
  for (const DetectionPlan& detection : plan.detections) {
    table.add({fmt::format("{} verdict {} a factor {}", name,
                           detection.factor > 1.0 ? "optimistic at" : "pessimistic at",
                           factor_text(detection.factor)),
               detection.needed.runs, TableCell(100.0 * detection.needed.power, 3),
               duration_text(detection.seconds, 2), detection.word.runs});
  }
}

std::string pilot_note(const PilotTiming& pilot) {
  std::string note =
      fmt::format("Times are expected ones, from a pilot of {} in {} on {}", counted(pilot.runs, "run"),
                  duration_text(pilot.seconds, 2), counted(pilot.threads, "thread"));
  if (pilot.evidence_runs > 0 && pilot.evidence_seconds_per_run > 0.0) {
    note += fmt::format(
        "; the first {} of a study are looked at step by step as well, which takes {} more for each",
        counted(pilot.evidence_runs, "run"), duration_text(pilot.evidence_seconds_per_run, 2));
  }
  return note + ".";
}

std::string design_note(const StudyPlan& plan) {
  return fmt::format(
      "{} steps of {} dof (NEES) and {} dof (NIS). NEES is correlated in time: its steps are worth {} "
      "independent ones ({}). Confidence {:g} %.",
      plan.nees.design.steps, number_text(plan.nees.design.dof_per_step, 4),
      number_text(plan.nis.design.dof_per_step, 4), number_text(plan.nees.design.effective_steps, 3),
      to_string(plan.correlation), 100.0 * plan.scenario.study.confidence);
}

std::string detectable_note(const char* name, const VerdictPlan& plan, const StudyPlan& study) {
  return fmt::format(
      "The {} runs of the scenario show in {} a factor below {} or above {} with {:g} % power.",
      study.scenario.study.runs, name, number_text(plan.detectable.below, 4),
      number_text(plan.detectable.above, 4), 100.0 * study.question.power);
}

constexpr std::int64_t kManyCores = 10'000;

Json cost_json(const JobCost& cost) {
  return {{"chunks", cost.chunks},
          {"chunk_core_seconds", cost.chunk_seconds},
          {"core_seconds", cost.core_seconds()},
          {"disk_bytes", cost.disk_bytes},
          {"memory_bytes", cost.memory_bytes},
          {"seconds_on_10000_cores", cost.seconds_on(kManyCores)}};
}

std::string cost_note(const JobCost& cost) {
  const std::int64_t busy = std::min(cost.chunks, kManyCores);
  return fmt::format(
      "The runs of the scenario are {} chunks of {} of one core each: {} core hours, {} MB of disk, at least "
      "{} MB of memory in each process. On {} cores {} would have work, for {} (docs/scale.md).",
      cost.chunks, duration_text(cost.chunk_seconds, 2), number_text(cost.core_seconds() / 3600.0, 2),
      number_text(cost.disk_bytes / 1e6, 2), number_text(cost.memory_bytes / 1e6, 2), kManyCores, busy,
      duration_text(cost.seconds_on(kManyCores), 2));
}

std::string plan_json(const SweepPlan& sweep, const std::vector<StudyPlan>& plans) {
  const PlanQuestion& question = plans.front().question;
  Json j{
      {"schema", kSchema}, {"scenario", sweep.name}, {"factor", question.factor}, {"power", question.power}};
  j["cost"] = cost_json(job_cost(plans, sweep.points.size()));
  if (sweep.points.size() == 1) {
    j.update(study_plan_json(plans.front()));
    return text_of_json(j);
  }
  const SweepCost cost = sweep_cost(plans, sweep.points.size());
  j["sweep"] = {{"configurations", cost.configurations},
                {"planned", cost.planned},
                {"runs", cost.runs},
                {"seconds", cost.seconds},
                {"runs_in_scenario", cost.scenario_runs},
                {"seconds_in_scenario", cost.scenario_seconds}};
  j["configurations"] = json_list(plans, study_plan_json);
  return text_of_json(j);
}

ReportTable plan_table(const StudyPlan& plan) {
  using enum ColumnAlign;
  ReportTable table{
      .title = fmt::format("{}: runs needed", plan.scenario.name),
      .columns = {{"to find", words}, {"runs"}, {"power %"}, {"time", words}, {"for the word"}}};
  add_detections("NEES", plan.nees, table);
  add_detections("NIS", plan.nis, table);
  table.add({fmt::format("mean NEES to ±{:g} %", 100.0 * plan.question.precision), plan.runs_for_precision,
             "", duration_text(plan.pilot.seconds_for(plan.runs_for_precision), 2), ""});
  table.notes = {
      "factor: true covariance / claimed, P for NEES and S for NIS, at every step. Power: of the verdict.",
      "for the word: so many let it be found by the share that this verdict alone has in the word.",
      detectable_note("NEES", plan.nees, plan),
      detectable_note("NIS", plan.nis, plan),
      design_note(plan),
      pilot_note(plan.pilot),
      cost_note(job_cost(std::span(&plan, 1), 1))};
  return table;
}

ReportTable plan_table(const SweepPlan& sweep, const std::vector<StudyPlan>& plans) {
  using enum ColumnAlign;
  const PlanQuestion& question = plans.front().question;
  ReportTable table{
      .title = fmt::format("{}: runs needed", sweep.name),
      .columns = {{"configuration", words}, {"NEES"}, {"NIS"}, {"precision"}, {"time of the most", words}}};
  const auto most = [](const VerdictPlan& plan) {
    std::int64_t runs = 0;
    for (const DetectionPlan& detection : plan.detections) runs = std::max(runs, detection.word.runs);
    return runs;
  };
  for (const StudyPlan& plan : plans) {
    const auto point = std::ranges::find(sweep.points, plan.scenario, &SweepPoint::scenario);
    table.add({point == sweep.points.end() ? plan.scenario.name : point_text(sweep, *point), most(plan.nees),
               most(plan.nis), plan.runs_for_precision,
               duration_text(plan.pilot.seconds_for(plan.runs_for_all), 2)});
  }
  const SweepCost cost = sweep_cost(plans, sweep.points.size());
  table.notes = {
      fmt::format("NEES, NIS: runs whose word finds a factor {} or {} on P or S by it with {:g} % power; "
                  "precision: mean NEES to ±{:g} %.",
                  factor_text(question.factor), factor_text(1.0 / question.factor), 100.0 * question.power,
                  100.0 * question.precision),
      fmt::format(
          "The sweep of {} configurations with {} runs each: {}. With the {} runs of the scenario: {}.",
          cost.configurations, cost.runs, duration_text(cost.seconds, 2), cost.scenario_runs,
          duration_text(cost.scenario_seconds, 2)),
      fmt::format("Times are expected ones, from short pilots of {} of the configurations.", cost.planned),
      cost_note(job_cost(plans, sweep.points.size()))};
  return table;
}

}  // namespace

Document plan_document(const SweepPlan& sweep, const std::vector<StudyPlan>& plans) {
  Document document;
  document.json = [sweep, plans] { return plan_json(sweep, plans); };
  document.brief.emplace_back(sweep.points.size() == 1 ? plan_table(plans.front())
                                                       : plan_table(sweep, plans));
  return document;
}

}  // namespace credence::internal
