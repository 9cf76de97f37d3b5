#include "reports/document/sweep/sweep_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "core/append_item.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/registry.h"
#include "reports/document/study/study_json.h"
#include "reports/document/sweep/rank_map_report.h"
#include "reports/document/sweep/sweep_figures.h"
#include "reports/document/sweep/swept_values.h"
#include "reports/document/verdict_text.h"
#include "reports/render/csv.h"

namespace credence::internal {
namespace {

bool has_vehicle_nees(const StudyAnalysis& a) { return a.vehicle_nees.has_value(); }

void write_sweep_csv(const std::filesystem::path& target, const SweepAnalysis& sweep) {
  std::vector<std::string> columns = {"configuration"};
  for (const SweepAxis& axis : sweep.plan.axes) columns.push_back(axis.path);
  for (const char* name : {"runs", "failed", "nees_mean", "nees_expected", "nees_lower", "nees_upper",
                           "nees_p_value", "nees_verdict", "nis_mean", "nis_expected", "nis_lower",
                           "nis_upper", "nis_p_value", "nis_verdict", "trace_last"}) {
    columns.emplace_back(name);
  }
  if (!sweep.rank_map.empty()) {
    for (const char* name : {"rank_inflation", "rank_observability", "measured_bounded", "growth_exponent",
                             "growth_per_step", "predicted_bounded", "paper_condition_holds"}) {
      columns.emplace_back(name);
    }
  }
  const bool has_pose = std::ranges::any_of(sweep.studies, has_vehicle_nees);
  if (has_pose) {
    for (const char* name : {"pose_nees_mean", "pose_nees_expected", "pose_nees_verdict"})
      columns.emplace_back(name);
  }
  for (const char* name : {"verdict", "sweep_p_value"}) columns.emplace_back(name);
  CsvWriter csv(target, columns);
  const auto number = [](double v) { return std::isfinite(v) ? CsvField(v) : CsvField(""); };
  for (std::size_t i = 0; i < sweep.studies.size(); ++i) {
    const StudyAnalysis& a = sweep.studies[i];
    const SweepPoint& point = sweep.point(i);
    std::vector<CsvField> row = {point.id};
    for (const ScalarValue& value : point.values) row.emplace_back(swept_text(value));
    row.emplace_back(a.statistics.runs);
    row.emplace_back(a.statistics.failures.size());
    for (const ConsistencyVerdict* v : {&a.nees, &a.nis}) {
      for (const double x : {v->mean, v->expected, v->bounds.lower, v->bounds.upper, v->p_value}) {
        row.push_back(number(x));
      }
      row.emplace_back(std::string(to_string(v->verdict)));
    }
    row.push_back(a.covariance.trace.empty() ? CsvField("") : number(a.covariance.trace.back()));
    if (!sweep.rank_map.empty()) {
      const RankMapCell& c = sweep.rank_map[i];
      row.insert(row.end(), {c.inflation_rank, c.observability_rank, c.bounded ? 1 : 0, c.growth_exponent,
                             c.growth_per_step, c.predicted ? 1 : 0, c.paper ? 1 : 0});
    }
    if (has_pose && a.vehicle_nees) {
      row.insert(row.end(), {number(a.vehicle_nees->mean), number(a.vehicle_nees->expected),
                             std::string(to_string(a.vehicle_nees->verdict))});
    } else if (has_pose) {
      row.insert(row.end(), {CsvField(""), CsvField(""), CsvField("")});
    }
    row.emplace_back(std::string(to_string(overall_verdict(a))));
    row.push_back(number(sweep.p_values[i]));
    csv.add(row);
  }
  csv.commit();
}

std::string family_note(const SweepAnalysis& sweep) {
  std::size_t alone = 0, together = 0;
  for (std::size_t i = 0; i < sweep.studies.size(); ++i) {
    alone += is_inconsistent(overall_verdict(sweep.studies[i])) ? 1 : 0;
    together += sweep.stands(i) ? 1 : 0;
  }
  return fmt::format(
      "stands: inconsistent also when all configurations are judged together. {} of {} {} inconsistent "
      "alone, {} {}; at most {:g} % of those that stand are expected to be false (Benjamini-Yekutieli).",
      alone, sweep.studies.size(), alone == 1 ? "is" : "are", together, together == 1 ? "stands" : "stand",
      100.0 * (1.0 - sweep.confidence()));
}

/// "world.landmarks = 3, filter.inflation = map".
std::string point_words(const SweepAnalysis& sweep, std::size_t study) {
  std::string text;
  const std::vector<ScalarValue>& values = sweep.point(study).values;
  for (std::size_t i = 0; i < values.size(); ++i) {
    append_item(text, fmt::format("{} = {}", sweep.plan.axes[i].path, swept_text(values[i])));
  }
  return text;
}

/// In which configurations an iteration of the filter ended before it had settled; empty where in none.
std::string unsettled_note(const SweepAnalysis& sweep) {
  constexpr std::size_t kNamed = 5;
  std::string where;
  std::size_t configurations = 0;
  for (std::size_t i = 0; i < sweep.studies.size(); ++i) {
    const StudyStatistics& s = sweep.studies[i].statistics;
    if (s.not_converged.empty() || ++configurations > kNamed) continue;
    append_item(where,
                fmt::format("{} (in {} of {})", point_words(sweep, i), s.not_converged.size(),
                            counted(s.runs, "run")),
                "; ");
  }
  if (configurations == 0) return {};
  return fmt::format(
      "The filter's iteration stopped before it had converged in {} of {} configurations; its last iterate "
      "is used there: {}{}.",
      configurations, sweep.studies.size(), where, configurations > kNamed ? "; …" : "");
}

/// How far a configuration is from consistent: of NEES and NIS the larger of |log(mean / expected)|.
double distance(const StudyAnalysis& a) {
  return std::max(std::abs(std::log(a.nees.mean / a.nees.expected)),
                  std::abs(std::log(a.nis.mean / a.nis.expected)));
}

/// The consistent configuration without a failed run whose NEES and NIS are nearest to what they must be;
/// size() if there is none.
std::size_t best_study(const SweepAnalysis& sweep) {
  std::size_t best = sweep.studies.size();
  for (std::size_t i = 0; i < sweep.studies.size(); ++i) {
    const StudyAnalysis& a = sweep.studies[i];
    const bool good = overall_verdict(a) == Verdict::consistent && std::isfinite(distance(a)) &&
                      a.statistics.failures.empty();
    if (good && (best == sweep.studies.size() || distance(a) < distance(sweep.studies[best]))) best = i;
  }
  return best;
}

/// Of a scenario that varies nothing, or by one value: no counts.
ReportAnswer one_configuration(Verdict verdict, std::size_t unsafe, std::size_t failing) {
  const std::string failed = failing > 0 ? "; runs of it failed" : "";
  if (unsafe > 0) return {CellTone::alarm, "The only configuration cannot be trusted" + failed};
  return {failing > 0 ? CellTone::caution : verdict_cell(verdict).tone,
          fmt::format("The only configuration is {}{}", to_string(verdict), failed)};
}

/// Of each configuration of a sweep what it is; together all of them.
struct SweepCounts {
  std::size_t unsafe = 0, pessimistic = 0, consistent = 0, not_gaussian = 0, undecided = 0;
  std::size_t alone = 0;  ///< inconsistent by themselves, but not when all are taken together

  /// "3 cannot be trusted, 1 is consistent, 2 are undecided": those that there are.
  std::string text() const {
    std::string list;
    if (unsafe > 0) list = fmt::format("{} cannot be trusted", unsafe);
    for (const auto& [count, words] :
         {std::pair{pessimistic, "pessimistic"}, std::pair{consistent, "consistent"},
          std::pair{not_gaussian, "not Gaussian"}, std::pair{undecided, "undecided"},
          std::pair{alone, "inconsistent alone but not among so many"}}) {
      if (count > 0) append_item(list, fmt::format("{} {} {}", count, count == 1 ? "is" : "are", words));
    }
    return list;
  }
};

SweepCounts counts_of(const SweepAnalysis& sweep) {
  SweepCounts counts;
  for (std::size_t i = 0; i < sweep.studies.size(); ++i) {
    const Verdict verdict = overall_verdict(sweep.studies[i]);
    std::size_t& count = verdict == Verdict::consistent     ? counts.consistent
                         : verdict == Verdict::not_gaussian ? counts.not_gaussian
                         : verdict == Verdict::undecided    ? counts.undecided
                         : !sweep.stands(i)                 ? counts.alone
                         : is_unsafe(verdict)               ? counts.unsafe
                                                            : counts.pessimistic;
    ++count;
  }
  return counts;
}

ReportAnswer sweep_answer(const SweepAnalysis& sweep) {
  const SweepCounts counts = counts_of(sweep);
  const auto failing = static_cast<std::size_t>(std::ranges::count_if(
      sweep.studies, [](const StudyAnalysis& a) { return !a.statistics.failures.empty(); }));
  const std::size_t n = sweep.studies.size(), best = best_study(sweep);
  if (n == 0) return {CellTone::caution, "No configuration has results yet"};
  const std::size_t asked = sweep.plan.points.size();
  if (n == 1 && asked == 1)
    return one_configuration(overall_verdict(sweep.studies[0]), counts.unsafe, failing);
  std::string text =
      fmt::format("{} {}",
                  n < asked ? fmt::format("Of the {} of {} configurations that have results so far", n, asked)
                            : fmt::format("Of {} configurations", n),
                  counts.text());
  if (failing > 0) text += fmt::format("; runs failed in {} of them", failing);
  if (best < n) text += fmt::format("; nearest to right: {}", point_words(sweep, best));
  const bool good = counts.consistent == n && failing == 0;
  return {counts.unsafe > 0 || failing == n ? CellTone::alarm
          : good                            ? CellTone::good
                                            : CellTone::caution,
          text};
}

/// " (m² + rad²)": that of a trace of P, where all configurations have the same; empty where it has none.
std::string unit_of_traces(const SweepPlan& plan) {
  const RunFigure first = world_of(plan.points.front().scenario).figure;
  const auto is_other = [&](const SweepPoint& p) { return world_of(p.scenario).figure != first; };
  if (std::ranges::any_of(plan.points, is_other)) return {};
  return first == RunFigure::line_slam ? " (m²)" : first == RunFigure::plane_slam ? " (m² + rad²)" : "";
}

/// "4.495 of 3.000 (optimistic)"
TableCell part_cell(const ConsistencyVerdict& v) {
  const TableCell verdict = verdict_cell(v.verdict);
  return {fmt::format("{} ({})", against_expected(v), verdict.text), verdict.tone};
}

/// Configurations without a result, and points that are none.
void add_missing_notes(const SweepAnalysis& sweep, std::vector<std::string>& notes) {
  const SweepPlan& plan = sweep.plan;
  if (std::string note = unsettled_note(sweep); !note.empty()) notes.push_back(std::move(note));
  const std::size_t results = sweep.rank_map.empty() ? sweep.studies.size() : sweep.rank_map.size();
  if (results < plan.points.size())
    notes.push_back(
        fmt::format("{} of {} have results", results, counted(plan.points.size(), "configuration")));
  if (plan.skipped > 0) notes.push_back(counted(plan.skipped, "impossible configuration") + " left out");
}

ReportTable configuration_table(const SweepAnalysis& sweep) {
  using enum ColumnAlign;
  const SweepPlan& plan = sweep.plan;
  ReportTable table{.title = sweep_answer(sweep).text};
  const bool has_pose = std::ranges::any_of(sweep.studies, has_vehicle_nees);
  for (const SweepAxis& axis : plan.axes) {
    table.columns.push_back({axis.path, std::isnan(swept_number(axis.values.front())) ? words : numbers});
  }
  table.columns.insert(table.columns.end(), {{"verdict", words}, {"together", words}, {"NEES", words}});
  if (has_pose) table.columns.push_back({"of the pose", words});
  table.columns.insert(table.columns.end(),
                       {{"NIS", words}, {"last tr P" + unit_of_traces(plan)}, {"runs"}, {"failed"}});
  for (std::size_t i = 0; i < sweep.studies.size(); ++i) {
    const StudyAnalysis& a = sweep.studies[i];
    std::vector<TableCell> row;
    for (const ScalarValue& value : sweep.point(i).values) row.emplace_back(swept_text(value));
    row.insert(row.end(),
               {verdict_cell(overall_verdict(a)),
                sweep.stands(i) ? TableCell("stands") : TableCell("–", CellTone::muted), part_cell(a.nees)});
    if (has_pose) row.push_back(a.vehicle_nees ? part_cell(*a.vehicle_nees) : TableCell("–"));
    row.insert(row.end(),
               {part_cell(a.nis), a.covariance.trace.empty() ? std::nan("") : a.covariance.trace.back(),
                a.statistics.runs, a.statistics.failures.size()});
    table.add(std::move(row));
  }
  if (!sweep.studies.empty()) {
    table.notes.emplace_back("NEES, NIS: mean of expected, with the verdict of that part alone.");
    table.notes.push_back(family_note(sweep));
  }
  add_missing_notes(sweep, table.notes);
  return table;
}

std::string sweep_json(const SweepAnalysis& sweep) {
  const SweepPlan& plan = sweep.plan;
  Json document;
  document["schema"] = kSchema;
  document["name"] = plan.name;
  document["points"] = plan.points.size();
  document["skipped_impossible"] = plan.skipped;
  if (!sweep.rank_map.empty()) {
    document["rank_map"] = rank_map_json(sweep.rank_map, sweep.confidence());
    return text_of_json(document);
  }
  Json configurations = Json::array();
  for (std::size_t n = 0; n < sweep.studies.size(); ++n) {
    Json j = study_json(sweep.studies[n]);
    j["swept"] = swept_json(plan, sweep.point(n));
    j["sweep_p_value"] = sweep.p_values[n];
    configurations.push_back(std::move(j));
  }
  document["configurations"] = std::move(configurations);
  return text_of_json(document);
}

}  // namespace

Document sweep_document(SweepAnalysis given) {
  const auto shared = std::make_shared<const SweepAnalysis>(std::move(given));
  const SweepAnalysis& sweep = *shared;
  const bool map = !sweep.rank_map.empty();
  Document document(sweep.plan.name, fmt::format("A sweep of {} configurations", sweep.plan.points.size()));
  document.answer = map ? rank_map_answer(sweep.rank_map) : sweep_answer(sweep);
  document.json = [shared] { return sweep_json(*shared); };
  std::vector<ReportTable> tables = {configuration_table(sweep)};
  if (map) {
    tables = {rank_map_table(sweep.rank_map, sweep.confidence())};
    add_missing_notes(sweep, tables.front().notes);
    if (ReportTable disagreements = rank_map_disagreements(sweep.rank_map); !disagreements.rows.empty())
      tables.push_back(std::move(disagreements));
    document.show_answer();
  }
  document.brief.insert(document.brief.end(), tables.begin(), tables.end());

  std::vector<Figure> figures = map ? std::vector{rank_map_figure(sweep.rank_map)} : sweep_figures(sweep);
  if (!figures.empty()) document.section(map ? "The map of ranks" : "Over the settings");
  document.figures(std::move(figures));
  document.section(map ? "Counts" : "All configurations");
  if (!map) tables.front().title = "One row for each configuration";
  for (ReportTable& table : tables) document.table(std::move(table));
  document.link("every configuration as CSV", "sweep.csv");
  document.file("sweep.csv", [shared](const auto& target) { write_sweep_csv(target, *shared); });
  document.section("Settings");
  document.folded("The scenario with its sweep", [&] { document.verbatim(canonical_toml(shared->plan)); });
  return document;
}

}  // namespace credence::internal
