#include "reports/document/sweep/sweep_comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "core/append_item.h"
#include "core/number_text.h"
#include "reports/document/sweep/swept_values.h"
#include "reports/document/verdict_text.h"

namespace credence::internal {
namespace {

/// A configuration beside that of the first sweep.
struct ComparedCell {
  const ComparedStudy* before = nullptr;
  const ComparedStudy* after = nullptr;
  std::string difference;  ///< with its interval
  double adjusted = 1.0;   ///< p-value
  Nearness nearness = Nearness::open;
};

std::vector<ComparedCell> compared_cells(const std::vector<ComparedStudy>& studies, double confidence) {
  const auto differences = differences_from_first(studies, confidence);
  const auto changes = changes_from_first(studies, confidence);
  std::vector<ComparedCell> cells;
  for (std::size_t i = 0; i < studies.size(); ++i) {
    ComparedCell cell{.before = reference_of(studies, i), .after = &studies[i], .difference = {}};
    if (cell.before == nullptr) continue;
    if (const std::optional<RunDifference>& d = differences[i]) {
      cell.difference =
          fmt::format("by {}", interval_text(d->interval.mean, d->interval.lower, d->interval.upper));
      cell.adjusted = d->adjusted;
      cell.nearness = nearness_of(*d, 1.0 - confidence);
    } else if (!changes[i].empty()) {
      const FactorChange& change = changes[i].front();
      const MeanInterval& ratio = change.ratio;
      cell.difference = fmt::format("times {}", interval_text(ratio.mean, ratio.lower, ratio.upper));
      cell.adjusted = change.adjusted;
      cell.nearness = nearness_of(change, 1.0 - confidence);
    } else {
      continue;
    }
    cells.push_back(std::move(cell));
  }
  return cells;
}

ReportAnswer answer_of(const std::vector<ComparedCell>& cells, double confidence) {
  if (cells.empty())
    return {CellTone::caution,
            "Nothing can be compared: no configuration of one has the swept values of another"};
  constexpr std::size_t kNamed = 3;
  std::size_t nearer = 0, farther = 0, open = 0;
  std::string where;
  for (const ComparedCell& cell : cells) {
    if (cell.adjusted > 1.0 - confidence) continue;
    nearer += cell.nearness == Nearness::nearer ? 1 : 0;
    open += cell.nearness == Nearness::open ? 1 : 0;
    if (cell.nearness == Nearness::farther && ++farther <= kNamed) append_item(where, cell.after->cell, "; ");
  }
  const std::size_t differ = nearer + farther + open;
  if (differ == 0) {
    return {CellTone::good,
            fmt::format("Of {} none differs by more than chance", counted(cells.size(), "configuration"))};
  }
  return {farther + open > 0 ? CellTone::caution : CellTone::good,
          fmt::format("Of {} {} differ{} by more than chance: {} nearer to right, {}{} farther{}{}",
                      counted(cells.size(), "configuration"), differ, differ == 1 ? "s" : "", nearer,
                      open > 0 ? fmt::format("{} of which that is not told, ", open) : "", farther,
                      where.empty() ? "" : ": " + where,
                      farther > kNamed ? fmt::format(" and {} more", farther - kNamed) : "")};
}

/// Of the configurations of all sweeps but the first those beside which nothing stands.
std::string not_compared(const std::vector<ComparedStudy>& studies, std::size_t told) {
  const auto others = static_cast<std::size_t>(std::ranges::count_if(
      studies, [&](const ComparedStudy& study) { return study.of_sweep != studies.front().of_sweep; }));
  if (others <= told) return {};
  return fmt::format(
      "{} cannot be compared: the first sweep has none with the same swept values, or too few runs.",
      counted(others - told, "configuration"));
}

ReportTable cells_table(const std::vector<ComparedStudy>& studies, const std::vector<ComparedCell>& cells,
                        double confidence) {
  using enum ColumnAlign;
  ReportTable table{.title = "Each configuration, and what it differs by from the first sweep",
                    .columns = {{"configuration", words},
                                {"sweep", words},
                                {"verdict before", words},
                                {"verdict", words},
                                {"factor on P before", words},
                                {"factor on P", words},
                                {"differs", words},
                                {"p", words}}};
  for (const ComparedCell& cell : cells) {
    const bool differs = cell.adjusted <= 1.0 - confidence;
    table.add({cell.after->cell, cell.after->name,
               TableCell(cell.before->verdict, verdict_tone(cell.before->verdict)),
               TableCell(cell.after->verdict, verdict_tone(cell.after->verdict)),
               mean_interval_text(cell.before->factor), mean_interval_text(cell.after->factor),
               cell.difference,
               TableCell(p_value_text(cell.adjusted), differs ? CellTone::caution : CellTone::muted)});
  }
  table.notes.push_back(
      fmt::format("differs: NEES over dof, this one minus that of the first sweep, run by run under the same "
                  "noise (by), or the factor on P over that of the first (times), with its interval at {:g} "
                  "%; p: of no difference, Holm over all configurations.",
                  100.0 * confidence));
  if (std::string note = not_compared(studies, cells.size()); !note.empty())
    table.notes.push_back(std::move(note));
  return table;
}

}  // namespace

std::vector<ComparedStudy> compared(const SweepAnalysis& sweep) {
  std::vector<ComparedStudy> studies;
  studies.reserve(sweep.studies.size());
  for (std::size_t i = 0; i < sweep.studies.size(); ++i) {
    ComparedStudy& study = studies.emplace_back(compared(sweep.studies[i]));
    study.name = sweep.plan.name;
    study.cell = cell_name(swept_json(sweep.plan, sweep.point(i)));
    study.nees_of_steps.clear();
    study.nis_of_steps.clear();
  }
  return studies;
}

bool are_of_sweeps(const std::vector<ComparedStudy>& studies) {
  return std::ranges::any_of(studies, [](const ComparedStudy& study) { return !study.cell.empty(); });
}

Document sweep_comparison_document(const std::vector<ComparedStudy>& studies, double confidence) {
  const std::vector<ComparedCell> cells = compared_cells(studies, confidence);
  Document document("Sweeps side by side",
                    fmt::format("{} configurations, compared by Credence", cells.size()));
  document.answer = answer_of(cells, confidence);
  document.json = [studies, confidence] { return comparison_json(studies, confidence); };
  document.show_answer();
  document.section("Configuration by configuration");
  if (cells.empty()) {  // a table would have a heading and nothing below
    const std::string note = not_compared(studies, 0);
    document.brief.emplace_back(note);
    document.paragraph(note);
    return document;
  }
  ReportTable table = cells_table(studies, cells, confidence);
  document.brief.emplace_back(table);
  document.table(std::move(table));
  return document;
}

}  // namespace credence::internal
