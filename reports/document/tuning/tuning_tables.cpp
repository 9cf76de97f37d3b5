#include "reports/document/tuning/tuning_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/append_item.h"
#include "core/number_text.h"
#include "montecarlo/scenario/scenario_schema.h"
#include "reports/document/shown_unit.h"

namespace credence::internal {
namespace {

/// Whole steps, or a dash; of noise that hardly has an effect their order.
TableCell steps_cell(double steps) {
  constexpr double kCountable = 1e7;
  if (std::isnan(steps)) return "–";
  return steps < kCountable ? TableCell(std::llround(steps)) : TableCell(steps, 3);
}

/// The standard error of a logarithm, in percent; beyond that it tells no more than that nothing is known.
std::string error_text(double relative) {
  if (std::isnan(relative)) return "–";
  return relative > 1.0 ? "> 100 %" : number_text(100.0 * relative, 3) + " %";
}

/// What the names of coordinates "L_Q[2,1]" mean.
std::vector<std::string> root_notes(const TuningForecast& forecast) {
  std::vector<std::string> notes;
  for (const char* const matrix : {"Q", "R"}) {
    const std::string root = fmt::format("L_{}[", matrix);
    const auto is_of_root = [&](const TuningForecast::Parameter& p) { return p.name.starts_with(root); };
    if (std::ranges::any_of(forecast.parameters, is_of_root))
      notes.push_back(
          fmt::format("L_{0}: the lower triangle L of {0} = L Lᵀ, which is searched over.", matrix));
  }
  return notes;
}

Json tuned_parameter_json(const TunedParameter& p) {
  Json j{{"name", p.name},
         {"value", p.value},
         {"lower", p.lower},
         {"upper", p.upper},
         {"identifiable", p.identifiable},
         {"by_likelihood_ratio", p.by_likelihood_ratio},
         {"steps_for_10_percent", p.steps_for_10_percent},
         {"before", p.before},
         {"bootstrap", {{"lower", p.bootstrap_lower}, {"upper", p.bootstrap_upper}}}};
  if (!p.identifiable) j["null_reason"] = p.reason;
  return j;
}

Json tune_forecast_json(const TuningForecast& forecast) {
  return json_list(forecast.parameters, [](const TuningForecast::Parameter& p) {
    Json j{{"name", p.name},
           {"identifiable", p.identifiable},
           {"relative_error", p.relative_error},
           {"steps_for_10_percent", p.steps_for_10_percent}};
    if (!p.identifiable) j["null_reason"] = p.reason;
    return j;
  });
}

}  // namespace

std::string tuned_name(const std::string& name) {
  const std::size_t point = name.find('.');
  if (point == std::string::npos) return name;
  const ScenarioKey* const key = find_scenario_key(name.substr(0, point), name.substr(point + 1));
  if (key == nullptr) return name;
  return name + unit_in_brackets(key->unit == "deg" ? "°" : key->unit);
}

std::string tuned_interval_text(double lower, double upper) {
  if (std::isnan(lower)) return "–";
  return fmt::format("{} … {}", number_text(lower, 4), number_text(upper, 4));
}

std::string or_dash(double value, int significant) {
  return std::isnan(value) ? "–" : number_text(value, significant);
}

ReportTable tune_forecast_table(const TuningForecast& forecast) {
  ReportTable table{.title = "What these data can tell, if the present filter is right",
                    .columns = {{"parameter", ColumnAlign::words},
                                {"known to ±", ColumnAlign::numbers},
                                {"steps for ±10 %, if so", ColumnAlign::numbers}},
                    .notes = {fmt::format("{}. ±: one standard error of the logarithm.",
                                          counted(std::llround(forecast.steps), "step"))}};
  const bool any_held = !std::ranges::all_of(forecast.parameters, &TuningForecast::Parameter::identifiable);
  if (any_held) table.columns.push_back({"held, because", ColumnAlign::words});
  for (const TuningForecast::Parameter& p : forecast.parameters) {
    std::vector<TableCell> row{tuned_name(p.name), error_text(p.relative_error),
                               steps_cell(p.steps_for_10_percent)};
    if (any_held) row.push_back(p.identifiable ? TableCell("") : TableCell(p.reason, CellTone::caution));
    table.add(std::move(row));
  }
  for (std::string& note : root_notes(forecast)) table.notes.push_back(std::move(note));
  return table;
}

ReportTable tuned_noise_table(const std::string& name, const std::string& engine, const Tuning& t) {
  ReportTable table{
      .title = fmt::format("{}: the noise that the data ask for", name),
      .columns = {{"parameter", ColumnAlign::words},
                  {"present"},
                  {"tuned"},
                  {fmt::format("{:g} % interval", 100.0 * t.confidence), ColumnAlign::words},
                  {"by resampling", ColumnAlign::words},
                  {"steps for ±10 %"}},
      .notes = {fmt::format(
          "{}. Interval: {}{}. By resampling: {} of data drawn with replacement, one Newton step each.",
          engine, t.by_sandwich ? "the sandwich of observed information and scores" : "observed information",
          std::ranges::any_of(t.parameters, &TunedParameter::by_likelihood_ratio)
              ? ", of what is known weakly the likelihood ratio"
              : "",
          counted(t.units, "unit"))}};
  if (!t.converged)
    table.notes.emplace_back(
        "The search did not converge: values and intervals are those of its best trial, and need not hold.");
  for (const TunedParameter& p : t.parameters) {
    const std::string limits =
        std::isnan(p.lower) ? p.reason : "only within " + tuned_interval_text(p.lower, p.upper);
    table.add({tuned_name(p.name), TableCell(p.before),
               p.identifiable ? TableCell(p.value) : TableCell("not identifiable", CellTone::caution),
               p.identifiable ? tuned_interval_text(p.lower, p.upper) : limits,
               tuned_interval_text(p.bootstrap_lower, p.bootstrap_upper),
               steps_cell(p.steps_for_10_percent)});
  }
  for (std::string& note : root_notes(t.forecast)) table.notes.push_back(std::move(note));
  return table;
}

ReportTable score_gain_table(const Tuning& g) {
  ReportTable table{
      .title = "Before and after",
      .columns = {{"", ColumnAlign::words}, {"present", ColumnAlign::words}, {"tuned", ColumnAlign::words}}};
  table.add({"log score of the innovations, a step", or_dash(g.score_before, 6), or_dash(g.score_after, 6)});
  table.add(
      {"mean NIS (expected " + number_text(g.dof, 4) + ")", or_dash(g.nis_before), or_dash(g.nis_after)});
  table.add(
      {"lag-one correlation of the innovations", or_dash(g.lag_one_before, 2), or_dash(g.lag_one_after, 2)});
  return table;
}

std::string likelihood_ratio_text(const Tuning& g) {
  return fmt::format(
      "Likelihood ratio {} with {} dof{}, p {}{}.", number_text(g.likelihood_ratio, 4),
      g.likelihood_ratio_dof, g.by_sandwich ? ", divided by how much more the scores vary" : "",
      g.likelihood_ratio_p_value < 1e-12 ? "" : "= ", p_value_text(g.likelihood_ratio_p_value));
}

std::string asked_noise_text(const std::string& of_what, const Tuning& tuning) {
  const std::string data =
      tuning.converged
          ? of_what
          : "The search did not converge, and what follows is no more than its best trial. " + of_what;
  const bool any = std::ranges::any_of(tuning.parameters, &TunedParameter::contradicts_present);
  const bool together = !any && tuning.likelihood_ratio_p_value < 1.0 - tuning.confidence;
  std::string asked, kept;
  for (const TunedParameter& p : tuning.parameters) {
    if (!p.identifiable) {
      if (p.contradicts_present()) {
        append_item(asked, p.before > p.upper
                               ? fmt::format("{} of at most {}", p.name, number_text(p.upper, 3))
                               : fmt::format("{} of at least {}", p.name, number_text(p.lower, 3)));
      }
      continue;
    }
    append_item(
        together || p.contradicts_present() ? asked : kept,
        fmt::format("{} = {} ({})", p.name, number_text(p.value, 4), tuned_interval_text(p.lower, p.upper)));
  }
  if (kept.empty()) return fmt::format("{} ask for {}", data, asked);
  if (asked.empty()) return fmt::format("{} agree with the present noise; most likely is {}", data, kept);
  return fmt::format("{} ask for {} and agree with the present value in {}", data, asked, kept);
}

ReportAnswer nothing_told(const Tuning& tuning) {
  std::string why = tuning.notes.empty() ? "Nothing could be told" : tuning.notes.back();
  if (why.ends_with('.')) why.pop_back();
  return {CellTone::caution, why};
}

Json tuning_json(const Tuning& g) {
  Json j;
  j["confidence"] = g.confidence;
  j["forecast"] = tune_forecast_json(g.forecast);
  j["parameters"] = json_list(g.parameters, tuned_parameter_json);
  j["coordinates"] = g.coordinates;
  j["correlation"] = json_matrix(g.correlation);
  j["log_score"] = {{"before", g.score_before},
                    {"after", g.score_after},
                    {"likelihood_ratio", g.likelihood_ratio},
                    {"likelihood_ratio_p_value", g.likelihood_ratio_p_value}};
  j["innovations"] = {{"nis", {{"before", g.nis_before}, {"after", g.nis_after}, {"expected", g.dof}}},
                      {"lag_one_correlation", {{"before", g.lag_one_before}, {"after", g.lag_one_after}}}};
  j["intervals"] = g.by_sandwich ? "sandwich" : "observed information";
  j["information_ratio"] = g.information_ratio;
  return j;
}

}  // namespace credence::internal
