#include "reports/document/study_table.h"

#include <fmt/format.h>

#include <algorithm>

#include "reports/render/number_text.h"

namespace credence {
namespace {

std::string against(const ConsistencyVerdict& v) {
  return fmt::format("{} … {}", number_text(v.bounds.lower), number_text(v.bounds.upper));
}

TableCell failures_cell(const StudyStatistics& s) {
  if (s.failures.empty()) return {0};
  return {fmt::format("{} ({} diverged, {} not positive definite)", s.failures.size(),
                      s.count(Outcome::diverged), s.count(Outcome::not_positive_definite)),
          CellTone::alarm};
}

}  // namespace

std::string filter_text(const FilterSettings& filter) {
  std::string text(to_string(filter.inflation));
  if (filter.inflation == FilterInflation::full || filter.inflation == FilterInflation::map) {
    text += fmt::format(", {}", to_string(filter.solution));
  }
  if (filter.inflation == FilterInflation::rank) {
    text += fmt::format(" {} ({})", filter.inflation_rank, to_string(filter.inflation_range));
  }
  if (filter.process_scale != 1.0) text += fmt::format(", Q × {:g}", filter.process_scale);
  if (filter.measurement_scale != 1.0) text += fmt::format(", R × {:g}", filter.measurement_scale);
  return text;
}

std::string world_text(const Scenario& scenario) {
  const WorldSettings& world = scenario.world;
  const std::string anchors = world.anchors == 0
                                  ? "partially observable"
                                  : fmt::format("{} anchor{}", world.anchors, world.anchors == 1 ? "" : "s");
  const double seen = scenario.noise.detection_probability;
  return fmt::format("{}, {} landmark{}, {}{}", to_string(world.model), world.landmarks,
                     world.landmarks == 1 ? "" : "s", anchors,
                     seen < 1.0 ? fmt::format(", each measured with probability {:g}", seen) : "");
}

TableCell verdict_cell(Verdict verdict) {
  const CellTone tone = verdict == Verdict::consistent   ? CellTone::good
                        : verdict == Verdict::optimistic ? CellTone::alarm
                                                         : CellTone::caution;
  return {std::string(to_string(verdict)), tone};
}

ReportTable verdict_table(std::span<const StudyAnalysis> analyses) {
  using enum ColumnAlign;
  ReportTable table{.title = "Can these covariances be trusted?",
                    .columns = {{"study", words},
                                {"inflation", words},
                                {"runs"},
                                {"mean NEES"},
                                {"expected"},
                                {"trusted if within", words},
                                {"NEES says", words},
                                {"mean NIS"},
                                {"expected"},
                                {"NIS says", words},
                                {"failed runs"}},
                    .rows = {},
                    .notes = {}};
  for (const StudyAnalysis& a : analyses) {
    table.add({fmt::format("{}{}", a.scenario.name, a.complete ? "" : " (interrupted)"),
               filter_text(a.scenario.filter), a.statistics.runs, a.nees.mean, a.nees.expected,
               against(a.nees), verdict_cell(a.nees.verdict), a.nis.mean, a.nis.expected,
               verdict_cell(a.nis.verdict), failures_cell(a.statistics)});
  }
  const double confidence = analyses.empty() ? 0.95 : analyses.front().scenario.study.confidence;
  table.notes = {
      "NEES: squared error of the state in units of its covariance P; NIS: of the innovation in units of S.",
      "consistent: P can be trusted. optimistic: errors are larger than P says. pessimistic: smaller.",
      fmt::format(
          "Each verdict is wrong with at most {:g} % probability on a consistent filter, over all its steps "
          "together.",
          100.0 * (1.0 - confidence))};
  if (std::ranges::any_of(analyses, [](const StudyAnalysis& a) { return a.stop.has_value(); })) {
    table.notes.push_back(
        "That holds for a number of runs fixed in advance: of a study with a stop rule the verdict of the "
        "rule "
        "counts, and not these.");
  }
  return table;
}

}  // namespace credence
