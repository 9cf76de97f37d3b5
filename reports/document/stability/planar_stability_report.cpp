#include "reports/document/stability/planar_stability_report.h"

#include <fmt/format.h>

#include <cmath>

#include "core/append_item.h"
#include "core/inflation/inflation_rule.h"
#include "core/nan.h"
#include "core/number_text.h"
#include "montecarlo/scenario/scenario_text.h"
#include "reports/document/stability/stability_report.h"
#include "reports/document/verdict_text.h"
#include "reports/render/json_numbers.h"

namespace credence::internal {
namespace {

const char* place_text(Linearisation at) {
  return at == Linearisation::truth ? "the truth" : "the estimate (EKF)";
}

std::string unobservable_text(const PlanarRanks& ranks) {
  return ranks.unobservable.empty() ? "nothing" : fmt::format("{}", fmt::join(ranks.unobservable, ", "));
}

/// What P is, or since when it is no more.
std::string growth_text(const PlanarFollowed& f) {
  if (f.failed_at > 0) return fmt::format("lost at step {} (the filter fails there)", f.failed_at);
  return std::string(to_string(f.growth.verdict));
}

TableCell prediction_of(const PlanarFollowed& f) {
  if (!f.exact.has_value()) return {"–", CellTone::muted};
  return f.exact->bounded() ? "bounded" : "unbounded";
}

std::string solution_text(const Scenario& scenario, InflationSolution solution) {
  if (scenario.filter.inflation == FilterInflation::none) return "no inflation";
  const std::string name(to_string(solution));
  return map_bound(solution).has_value() ? name + ", O(N)" : name;
}

TableCell number_or_none(double value) {
  return std::isnan(value) ? TableCell("–", CellTone::muted) : TableCell(value, 3);
}

/// Mean of tr P over loop `number`, from 1 on.
TableCell trace_cell(const PlanarFollowed& f, std::size_t number) {
  if (number < 1 || number > f.traces.size()) return {"–", CellTone::muted};
  return f.traces[number - 1];
}

Json ranks_json(const PlanarRanks& ranks) {
  Json j = rank_json(ranks.observability.decision);
  j["unobservable"] = ranks.unobservable;
  return j;
}

/// Null where nothing is added before an update, or the filter failed.
Json inflation_rank_json(const PlanarFollowed& f) {
  return f.exact.has_value() ? Json(f.inflation_rank) : Json(nullptr);
}

Json followed_json(const PlanarFollowed& f) {
  Json j;
  j["jacobians_at"] = to_string(f.at);
  j["solution"] = to_string(f.solution);
  j["verdict"] = to_string(f.growth.verdict);
  if (f.failed_at > 0) j["failed_at_step"] = f.failed_at;
  j["growth_exponent"] = f.growth.exponent;
  j["growth_per_loop"] = f.growth.per_sample;
  j["trace"] = f.traces;
  j["inflation_rank"] = inflation_rank_json(f);
  j["steps_above_duality_gap"] = f.not_converged;
  if (f.exact.has_value()) {
    j["predicted_bounded"] = f.exact->bounded();
    j["prediction_reason"] = to_string(f.exact->reason);
    j["accumulated_noise_rank"] = f.exact->noise.rank;
    j["accumulated_noise_singular_values"] = rank_json(f.exact->noise)["singular_values"];
  } else {
    j["predicted_bounded"] = nullptr;
    j["prediction_reason"] = f.failed_at > 0 ? "the filter fails before the last loop has ended"
                                             : "a sequential rule inflates within the update";
  }
  if (f.at == Linearisation::truth) {
    j["initial_covariance_effect"] = f.initial_effect;
  } else {
    j["pose_nees_ratio"] = f.pose_nees;
  }
  j["spectral_radius_of_a_loop"] = f.spectral_radius;
  return j;
}

/// Without panels where nothing was followed to the end of a loop.
Figure planar_growth_figure(const Scenario& scenario, const PlanarStability& a) {
  Figure figure{
      .name = "planar-growth",
      .caption =
          "Mean trace of the filter's covariance over each loop. First with Jacobians at the truth; "
          "second in an EKF with noise, whose own estimates add information that is not there.",
      .rows = 1,
      .cols = 2};
  for (const Linearisation at : {Linearisation::truth, Linearisation::estimate}) {
    Panel panel{.title = std::string("Jacobians at ") + place_text(at),
                .x_label = "loop",
                .y_label = "trace of P (m² + rad²)",
                .log_y = true};
    Index i = 0;
    for (const PlanarFollowed& f : a.followed) {
      if (f.at != at || f.traces.empty()) continue;
      panel.series.push_back(line_series(solution_text(scenario, f.solution), numbered_role(i++),
                                         index_axis(static_cast<Index>(f.traces.size())), f.traces));
    }
    if (!panel.series.empty()) figure.panels.push_back(std::move(panel));
  }
  return figure;
}

/// What P of the other solutions does at the truth, in brackets; nothing without others.
std::string others_text(const Scenario& scenario, const PlanarStability& a) {
  std::string text;
  for (const PlanarFollowed& f : a.followed) {
    if (f.at != Linearisation::truth || f.solution == scenario.filter.solution) continue;
    append_item(text, fmt::format("{} {}", to_string(f.solution), to_string(f.growth.verdict)));
  }
  return text.empty() ? text : " (" + text + ")";
}

ReportAnswer planar_stability_answer(const Scenario& scenario, const PlanarStability& a) {
  const PlanarFollowed& truth = a.own(scenario.filter.solution);
  const bool bounded = truth.growth.verdict == LongRun::bounded;
  std::string text =
      fmt::format("Over {} loops with Jacobians at the truth P is {}", a.loops, growth_text(truth));
  if (const std::string others = others_text(scenario, a); !others.empty()) {
    text += fmt::format(" with the solution {}{}", to_string(scenario.filter.solution), others);
  }
  double pose_nees = kNaN;
  bool lost = false;
  for (const PlanarFollowed& f : a.followed) {
    if (f.at != Linearisation::estimate || f.solution != scenario.filter.solution) continue;
    pose_nees = f.pose_nees;
    text += "; in a noisy run of the EKF it is " + growth_text(f);
    lost = f.failed_at > 0;
    if (lost) continue;
    text +=
        fmt::format(", with a NEES of the pose of {} times its expected value", number_text(f.pose_nees, 3));
  }
  if (pose_nees > 2.0) return {CellTone::alarm, text + ": it is optimistic"};
  return {bounded && !lost ? CellTone::good : CellTone::alarm, text};
}

ReportTable planar_rank_table(const PlanarStability& a) {
  ReportTable table{.title = "Observability over one loop",
                    .columns = {{"Jacobians at", ColumnAlign::words},
                                {"rank O"},
                                {"of"},
                                {"gap"},
                                {"not observable", ColumnAlign::words}}};
  for (const Linearisation at : {Linearisation::truth, Linearisation::estimate}) {
    const PlanarRanks& ranks = at == Linearisation::truth ? a.truth : a.estimate;
    const RankDecision& d = ranks.observability.decision;
    table.add({place_text(at), d.rank, a.state_dim, TableCell(d.gap, 3), unobservable_text(ranks)});
  }
  table.notes = {
      "The stack of H_k Φ_k over the last loop. At the estimates a rank above that at the truth is spurious "
      "information: the EKF sees more than there is to see."};
  return table;
}

ReportTable planar_growth_table(const Scenario& scenario, const PlanarStability& a) {
  const auto middle = static_cast<std::size_t>(std::max<Index>(1, (a.loops + 1) / 2));
  ReportTable table{.title = fmt::format("Covariance over {} loops of {} steps", a.loops, a.steps_per_loop),
                    .columns = {{"solution", ColumnAlign::words},
                                {"Jacobians at", ColumnAlign::words},
                                {"tr P", ColumnAlign::words},
                                {"loop 1"},
                                {fmt::format("loop {}", middle)},
                                {"last"},
                                {"exponent"},
                                {"growth a loop"},
                                {"by the noise", ColumnAlign::words},
                                {"rank ΔP"},
                                {"above gap"},
                                {"P0 × 100"},
                                {"pose NEES / 3"}}};
  for (const PlanarFollowed& f : a.followed) {
    const std::string effect = fmt::format("× {}", number_text(f.initial_effect, 3));
    table.add({solution_text(scenario, f.solution), place_text(f.at), long_run_cell(f.growth),
               trace_cell(f, 1), trace_cell(f, middle), trace_cell(f, f.traces.size()),
               number_or_none(f.growth.exponent), number_or_none(f.growth.per_sample), prediction_of(f),
               f.exact ? TableCell(f.inflation_rank) : TableCell("–"), f.not_converged,
               TableCell(std::isnan(f.initial_effect) ? "–" : effect), number_or_none(f.pose_nees)});
  }
  table.notes = {
      fmt::format("growing: the last half of the loops adds more than {} of tr P and does not slow down. "
                  "exponent: log2 of tr P at the end over that at half the loops; 0 bounded, 1 linear.",
                  kPlanarResolution),
      ("by the noise: the condition on the accumulated noise of the last loop, proved for noise that is the "
       "same in every loop; it asks for a kernel that no step ever touches."),
      ("loop 1, half of them, last: mean of tr P over the loop, in m² + rad², as is the growth a loop. O(N): "
       "followed with the arrow covariance itself. rank ΔP: of what is added before the update; sequential "
       "rules add within it."),
      ("above gap: steps where the exact minimal trace missed its duality gap of 1e−9; an inexact solution "
       "imitates slow growth."),
      "pose NEES / 3: mean over the last half of one noisy run; 1 is consistent, above is optimistic."};
  const auto disagrees = [](const PlanarFollowed& f) {
    return f.exact && f.exact->bounded() != (f.growth.verdict == LongRun::bounded);
  };
  if (std::ranges::any_of(a.followed, disagrees)) {
    table.notes.emplace_back(
        "Where tr P and the noise disagree the loops are too few to see a slow growth, or the noise of the "
        "last loop is not yet that of all that follow.");
  }
  return table;
}

}  // namespace

std::string planar_stability_json(const Scenario& scenario, const PlanarStability& a) {
  const PlanarFollowed& own = a.own(scenario.filter.solution);
  Json j;
  j["schema"] = kSchema;
  j["scenario"] = Json::parse(scenario_to_json(scenario));
  j["state_dim"] = a.state_dim;
  j["loops"] = a.loops;
  j["steps_per_loop"] = a.steps_per_loop;
  j["rank"] = {{"controllability", a.process_rank},
               {"observability", a.truth.observability.decision.rank},
               {"observability_at_estimate", a.estimate.observability.decision.rank},
               {"inflation", inflation_rank_json(own)},
               {"noise_total", own.exact.has_value() ? Json(own.exact->noise.rank) : Json(nullptr)}};
  j["rank_details"] = {{"observability", ranks_json(a.truth)},
                       {"observability_at_estimate", ranks_json(a.estimate)}};
  j["unobservable"] = a.truth.unobservable;
  j["closed_loop_eigenvalues"] = eigenvalues_json(own.closed_loop_eigenvalues);
  j["spectral_radius"] = own.spectral_radius;
  j["riccati"] = {{"bounded", own.growth.verdict == LongRun::bounded},
                  {"growth_exponent", own.growth.exponent},
                  {"trace", own.traces.empty() ? Json(nullptr) : Json(own.traces.back())},
                  {"residual", nullptr},
                  {"kind", nullptr},
                  {"null_reason", "the model varies along the path: there is no constant solution"}};
  j["predicted_bounded"] = own.exact.has_value() ? Json(own.exact->bounded()) : Json(nullptr);
  j["paper_condition_holds"] =
      own.exact.has_value() ? Json(own.inflation_rank <= a.truth.observability.decision.rank) : Json(nullptr);
  j["filters"] = json_list(a.followed, followed_json);
  return text_of_json(j, 2);
}

Document planar_stability_document(const Scenario& scenario, const PlanarStability& a) {
  Document document("Stability of " + scenario.name, "Observability and boundedness along the path");
  document.answer = planar_stability_answer(scenario, a);
  document.json = [scenario, a] { return planar_stability_json(scenario, a); };

  add_stability_page(document, scenario, a.state_dim, planar_growth_table(scenario, a), "Growth of P",
                     planar_growth_figure(scenario, a), planar_rank_table(a));
  return document;
}

}  // namespace credence::internal
