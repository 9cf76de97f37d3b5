#include "reports/document/sweep/planar_table_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "core/append_item.h"
#include "core/number_text.h"
#include "reports/document/stability/planar_stability_report.h"
#include "reports/document/sweep/swept_values.h"
#include "reports/render/json_numbers.h"

namespace credence::internal {
namespace {

/// "n − 2", as the theory writes it.
std::string rank_words(const PlanarRanks& ranks, Index n) {
  const Index missing = n - ranks.observability.decision.rank;
  return missing == 0 ? "n" : fmt::format("n − {}", missing);
}

/// One noisy run fluctuates: an exponent within this of none tells neither growth nor a bound.
constexpr double kLeastNoisyExponent = 0.1;

/// The word with its exponent; of a noisy run only where the two agree, so that noise has no colour.
TableCell growth_cell(const PlanarFollowed& f) {
  const LongRun verdict = f.growth.verdict;
  if (verdict == LongRun::failed) return {"beyond all bounds", CellTone::alarm};
  const std::string exponent = fixed_text(f.growth.exponent, 2);
  const bool contradicts = verdict == LongRun::growing ? f.growth.exponent < kLeastNoisyExponent
                                                       : f.growth.exponent > kLeastNoisyExponent;
  if (f.at == Linearisation::estimate && contradicts) {
    return {fmt::format("not clear ({})", exponent), CellTone::muted};
  }
  const CellTone tone = verdict == LongRun::bounded   ? CellTone::good
                        : verdict == LongRun::growing ? CellTone::alarm
                                                      : CellTone::caution;
  return {fmt::format("{} ({})", to_string(verdict), exponent), tone};
}

const PlanarFollowed* find(const PlanarStability& a, Linearisation at, InflationSolution solution) {
  for (const PlanarFollowed& f : a.followed) {
    if (f.at == at && f.solution == solution) return &f;
  }
  return nullptr;
}

ReportAnswer planar_table_answer(std::span<const PlanarStability> analyses) {
  int bounded = 0, lost = 0, all = 0;
  for (const PlanarStability& a : analyses) {
    for (const PlanarFollowed& f : a.followed) {
      if (f.at != Linearisation::truth) continue;
      ++all;
      bounded += f.growth.verdict == LongRun::bounded ? 1 : 0;
      lost += f.growth.verdict == LongRun::failed ? 1 : 0;
    }
  }
  const int grows = all - bounded - lost;
  std::string where = bounded == all ? all == 1 ? "the one filter" : fmt::format("all {} filters", all)
                      : bounded == 0 ? "none of " + counted(all, "filter")
                                     : fmt::format("{} of {}", bounded, counted(all, "filter"));
  if (lost > 0) {
    where += fmt::format(", {}and leaves all bounds in {}",
                         grows > 0 ? fmt::format("grows in {} ", grows) : "", lost);
  } else if (grows > 0 && bounded > 0) {
    where += ", and grows in the others";
  }
  return {bounded == all ? CellTone::good : CellTone::caution,
          "With Jacobians at the truth P stays bounded in " + where};
}

/// Whether an exact minimal trace missed its duality gap at any step; a column for it is then worth its room.
bool misses_gap(std::span<const PlanarStability> analyses) {
  return std::ranges::any_of(analyses, [](const PlanarStability& a) {
    return std::ranges::any_of(a.followed, [](const PlanarFollowed& f) {
      return f.at == Linearisation::truth && f.not_converged > 0;
    });
  });
}

ReportTable planar_stability_table(const SweepPlan& plan, std::span<const PlanarStability> analyses) {
  using enum ColumnAlign;
  const Index loops = analyses.empty() ? 0 : analyses.front().loops;
  ReportTable table{.title = fmt::format("Does P stay bounded over {} loops?", loops)};
  for (const SweepAxis& axis : plan.axes) table.columns.push_back({axis.path, words});
  for (const char* title : {"rank O, truth", "rank O, EKF", "solution", "at the truth", "in the EKF"}) {
    table.columns.push_back({title, words});
  }
  const bool gap = misses_gap(analyses);
  for (const char* title : {"pose NEES / 3", "P0 × 100"}) table.columns.push_back({title});
  if (gap) table.columns.push_back({"above the gap"});
  for (std::size_t i = 0; i < analyses.size(); ++i) {
    const PlanarStability& a = analyses[i];
    for (const PlanarFollowed& truth : a.followed) {
      if (truth.at != Linearisation::truth) continue;
      const PlanarFollowed* ekf = find(a, Linearisation::estimate, truth.solution);
      std::vector<TableCell> row;
      for (const ScalarValue& value : plan.points[i].values) row.emplace_back(swept_text(value));
      const bool none = plan.points[i].scenario.filter.inflation == FilterInflation::none;
      row.insert(
          row.end(),
          {rank_words(a.truth, a.state_dim), rank_words(a.estimate, a.state_dim),
           none ? std::string("–") : std::string(to_string(truth.solution)), growth_cell(truth),
           ekf == nullptr ? TableCell("–") : growth_cell(*ekf),
           ekf == nullptr || ekf->growth.verdict == LongRun::failed ? TableCell("–")
                                                                    : TableCell(ekf->pose_nees, 3),
           truth.growth.verdict == LongRun::failed ? TableCell("–") : TableCell(truth.initial_effect, 3)});
      if (gap) row.emplace_back(truth.not_converged);
      table.add(std::move(row));
    }
  }
  table.notes = {
      "n: dimension of the state. In brackets: log2 of the last tr P over that at half the loops.",
      "At the truth: Jacobians along the nominal path. In the EKF: of one noisy run, whose P fluctuates.",
      "not clear: one noisy run grows with an exponent below 0.1, or is bounded with one above.",
      "rank O in the EKF: beyond that at the truth it is spurious. pose NEES / 3: above 1 is optimistic.",
      "beyond all bounds: the run ended before, as S could no longer be factorised.",
      "P0 × 100: what a hundredfold initial variance multiplies the last trace by; 1 is independent of P0."};
  if (gap) {
    table.notes.emplace_back(
        "above the gap: steps at the truth whose exact minimal trace missed its duality gap of 1e−9.");
  }
  return table;
}

std::string planar_stability_table_json(const SweepPlan& plan, std::span<const PlanarStability> analyses) {
  Json configurations = Json::array();
  for (std::size_t i = 0; i < analyses.size(); ++i) {
    Json j = Json::parse(planar_stability_json(plan.points[i].scenario, analyses[i]));
    j["swept"] = swept_json(plan, plan.points[i]);
    configurations.push_back(std::move(j));
  }
  return text_of_json(
      {{"schema", kSchema}, {"name", plan.name}, {"configurations", std::move(configurations)}});
}

}  // namespace

Document planar_table_document(const SweepPlan& plan, const std::vector<PlanarStability>& analyses) {
  Document document(plan.name, "Stability of planar EKF-SLAM under inflation");
  document.answer = planar_table_answer(analyses);
  document.json = [plan, analyses] { return planar_stability_table_json(plan, analyses); };

  const ReportTable table = planar_stability_table(plan, analyses);
  document.show_answer();
  document.brief.emplace_back(table);

  document.section("Boundedness");
  document.table(table);
  document.section("Settings");
  document.folded("The scenario with its sweep", [&] { document.verbatim(canonical_toml(plan)); });
  return document;
}

}  // namespace credence::internal
