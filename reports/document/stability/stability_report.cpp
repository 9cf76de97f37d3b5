#include "reports/document/stability/stability_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>
#include <vector>

#include "analysis/stability/boundedness.h"
#include "core/append_item.h"
#include "core/number_text.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/registry.h"
#include "reports/document/verdict_text.h"

namespace credence::internal {

Json rank_json(const RankDecision& decision) {
  Json j;
  j["rank"] = decision.rank;
  j["gap"] = decision.gap;
  if (std::isinf(decision.gap)) {
    j["gap_null_reason"] = "infinite: no other singular value than zero was left out";
  }
  if (decision.doubtful) j["doubt"] = kRankDoubt;
  j["singular_values"] = json_vector(decision.singular_values);
  return j;
}

TableCell long_run_cell(const TraceGrowth& growth) {
  return {std::string(to_string(growth.verdict)),
          growth.verdict == LongRun::bounded ? CellTone::good : CellTone::alarm};
}

void add_stability_page(Document& document, const Scenario& scenario, Index state_dim,
                        const ReportTable& verdicts, const char* over_time, const Figure& figure,
                        const ReportTable& ranks) {
  document.show_answer();
  document.show_apart({verdicts, ranks});
  document.section("Verdict");
  document.facts({{"world", world_text(scenario)},
                  {"inflation", filter_text(scenario.filter)},
                  {"state", fmt::format("{} dimensions", state_dim)}});
  document.table(verdicts);
  if (!figure.panels.empty()) {
    document.section(over_time);
    document.figure(figure);
  }
  document.section("Ranks");
  document.table(ranks);
  document.section("Settings");
  document.folded("The scenario", [&] { document.verbatim(canonical_toml(scenario)); });
}

Json eigenvalues_json(const Eigen::VectorXcd& values) {
  return json_list(values, [](const std::complex<double>& z) -> Json { return {z.real(), z.imag()}; });
}

namespace {

std::string joined(const std::vector<std::string>& words) {
  return words.empty() ? "none" : fmt::format("{}", fmt::join(words, ", "));
}

std::string complex_text(const std::complex<double>& z) {
  if (std::abs(z.imag()) <= 1e-12 * std::abs(z)) return number_text(z.real(), 6);
  return fmt::format("{} {} {} i", number_text(z.real(), 6), z.imag() < 0.0 ? "−" : "+",
                     number_text(std::abs(z.imag()), 6));
}

/// "residual 1.2e−9"; nothing of what is not known.
void add_known(std::string& text, std::string_view what, double value, int digits,
               std::string_view unit = "") {
  if (!std::isnan(value))
    append_item(text, fmt::format("{} {}{}", what, number_text(value, digits), unit), "; ");
}

std::string eigenvalue_text(const StabilityAnalysis& a) {
  constexpr Index kShown = 12;
  std::vector<std::string> words;
  const Index n = a.closed_loop_eigenvalues.size();
  if (n == 0 && a.steps == 0) return "not known, as no step succeeds";
  if (n == 0) return "not computed: the iteration did not converge";
  for (Index i = 0; i < std::min(n, kShown); ++i) words.push_back(complex_text(a.closed_loop_eigenvalues[i]));
  if (n > kShown) words.push_back(fmt::format("and {} more", n - kShown));
  return joined(words);
}

/// Largest gain of every state, at most a dozen.
std::string gain_text(const Matrix& K) {
  constexpr Index kShown = 12;
  if (K.hasNaN()) return "not known";
  std::vector<std::string> words;
  for (Index i = 0; i < std::min(K.rows(), kShown); ++i) {
    words.push_back(number_text(K.row(i).cwiseAbs().maxCoeff(), 4));
  }
  if (K.rows() > kShown) words.push_back(fmt::format("and {} more", K.rows() - kShown));
  return joined(words);
}

TableCell bounded_cell(bool bounded) {
  return bounded ? TableCell("bounded", CellTone::good) : TableCell("unbounded", CellTone::alarm);
}

/// Why the exact condition came out as it did.
std::string_view condition_text(std::string_view reason) {
  if (reason == to_string(BoundednessReason::paired)) {
    return "combinations of states that no noise touches fix every unobservable direction";
  }
  if (reason == to_string(BoundednessReason::unpaired))
    return "noise, or a direction that stays, drives an unobservable one";
  if (reason == to_string(BoundednessReason::nothing_unobserved)) return "nothing is unobservable";
  if (reason == to_string(BoundednessReason::unstable)) return "an unobservable direction is unstable";
  return reason;
}

TableCell riccati_cell(const RiccatiSolution& r) {
  if (r.kind == RiccatiKind::undecided && !r.stays_bounded) return {"undecided", CellTone::caution};
  return bounded_cell(r.stays_bounded);
}

std::string initial_text(const StabilityAnalysis& a) {
  if (std::isnan(a.initial_covariance_effect)) return "no limit to compare";
  return fmt::format("two P0 lead to limits that differ by {} of their norm",
                     number_text(a.initial_covariance_effect, 3));
}

/// What becomes of the initial error of one run under the gain of one step.
TableCell error_cell(double spectral_radius) {
  constexpr double kOnTheCircle = 1e-9;
  if (std::isnan(spectral_radius)) return {"not known", CellTone::caution};
  if (spectral_radius < 1.0 - kOnTheCircle) return {"forgotten", CellTone::good};
  if (spectral_radius <= 1.0 + kOnTheCircle) return {"part of it never decays", CellTone::caution};
  return {"not forgotten", CellTone::alarm};
}

/// Behind the trace of a covariance.
std::string unit_of_trace(const StabilityAnalysis& a) { return a.in_metres ? " m²" : ""; }

/// What is known of the solution of the Riccati equation.
std::string riccati_text(const StabilityAnalysis& a) {
  const RiccatiSolution& r = a.riccati;
  std::string text = fmt::format("solution: {}", to_string(r.kind));
  add_known(
      text, "trace of the prior", r.P.trace(), 6,
      unit_of_trace(a) + (r.has_limit() ? "" : fmt::format(" after {} steps", number_text(r.steps, 3))));
  add_known(text, "growth exponent", r.growth_exponent, 3);
  add_known(text, "residual", r.residual, 2);
  if (!r.reason.empty()) append_item(text, r.reason, "; ");
  return text;
}

std::string long_run_text(const StabilityAnalysis& a) {
  const LongHorizon& h = a.long_horizon;
  if (std::isnan(h.growth.exponent)) return h.failure;
  const std::string unit = unit_of_trace(a);
  return fmt::format("{}{}prior {}{} at step {}; {}{} a step over the last half, exponent {}", h.failure,
                     h.failure.empty() ? "" : "; ", number_text(h.trace_prior.back(), 5), unit,
                     h.trace_prior.size(), number_text(h.growth.per_sample, 4), unit,
                     number_text(h.growth.exponent, 3));
}

/// What the kind of a solution means.
std::string_view kind_sentence(RiccatiKind kind) {
  switch (kind) {
    case RiccatiKind::stabilising:
      return "Solution stabilising: P tends to the same limit from every P0, and errors of the start are "
             "forgotten.";
    case RiccatiKind::strong:
      return "Solution strong: P tends to the same limit from every P0, but as 1/k in directions that no "
             "noise touches, which are learnt perfectly.";
    case RiccatiKind::depends_on_initial:
      return "Solution psd depending on P0: P tends to a limit that is another one for another P0, since "
             "there are directions that never decay and of which no measurement, or not this P0, tells "
             "anything.";
    case RiccatiKind::oscillating:
      return "Solution oscillating: P stays bounded and has no limit, since directions that no measurement "
             "sees turn or change sign for ever, each at a rate of its own.";
    case RiccatiKind::unbounded: return "Solution none: P grows in directions that no measurement sees.";
    case RiccatiKind::undecided: break;
  }
  return "Solution undecided: no limit of P was found that its recursion confirms.";
}

/// Whether the filter fails right after the step of K and ΔP.
bool is_last(const StabilityAnalysis& a) {
  return !a.long_horizon.failure.empty() && a.steps == std::ssize(a.long_horizon.trace);
}

std::vector<std::string> notes(const StabilityAnalysis& a) {
  std::vector<std::string> all = {"K is the filter gain P Hᵀ (H P Hᵀ + R)⁻¹; the predictor's gain is F K. " +
                                  (a.steps > 0
                                       ? fmt::format("K and ΔP of F − F K H and Q_t are those of step {}{}.",
                                                     a.steps, is_last(a) ? ", the last that succeeds" : "")
                                       : "No step succeeds: K is not known, and Q_t is without a ΔP.")};
  all.emplace_back(kind_sentence(a.riccati.kind));
  if (a.sequential) {
    all.push_back(
        "A sequential rule inflates within the update: ΔP before it is zero, so that ranks and the verdicts "
        "on a constant Q_t leave it out; the long run contains it.");
  } else if (a.inflation_varies) {
    all.push_back(
        "ΔP varies with P along a run, so that its value at one step decides nothing; the long run shows "
        "what happens.");
  }
  if (!a.long_horizon.converged) {
    all.push_back(
        "An exact minimal trace did not reach its tolerance at some step; that imitates slow growth.");
  }
  return all;
}

/// What is proved of P where F = I: a bound on its trace, or how fast it grows at least, and along what.
std::string noise_condition_text(const StabilityAnalysis& a) {
  const NoiseCondition& c = *a.noise_condition;
  const std::string unit = unit_of_trace(a);
  if (c.bounded()) {
    return fmt::format("proved: tr P after an update never exceeds {}{}", number_text(c.trace_bound(), 6),
                       unit);
  }
  return fmt::format(
      "proved: the variance along {2}, which no measurement sees, grows by at least {0}{1} per step; tr P by "
      "{3}{4} per step in the limit",
      number_text(c.rate, 4), unit, a.growth_direction, number_text(c.growth_per_step(), 4), unit);
}

/// The object `noise_condition`; null where F is not the identity.
Json noise_condition_json(const StabilityAnalysis& a) {
  if (!a.noise_condition) return nullptr;
  const NoiseCondition& c = *a.noise_condition;
  Json j;
  j["bounded"] = c.bounded();
  j["trace_bound"] = c.bounded() ? Json(c.trace_bound()) : Json(nullptr);
  if (!c.bounded()) j["null_reason"] = "P grows";
  j["offset"] = c.trace_bound();
  j["rate"] = c.rate;
  j["growth_per_step"] = c.growth_per_step();
  j["direction"] = json_vector(c.direction);
  j["direction_name"] = a.growth_direction;
  j["seen"] = rank_json(c.seen);
  return j;
}

Json riccati_json(const RiccatiSolution& r) {
  Json j;
  j["bounded"] = r.stays_bounded || r.kind == RiccatiKind::unbounded ? Json(r.stays_bounded) : Json(nullptr);
  j["growth_exponent"] = r.growth_exponent;
  j["exponential"] = r.exponential;
  j["trace"] = r.P.trace();
  j["residual"] = r.residual;
  j["kind"] = to_string(r.kind);
  if (!r.reason.empty()) j["reason"] = r.reason;
  j["steps"] = r.steps;
  j["gain"] = json_matrix(r.K);
  j["closed_loop_eigenvalues"] = eigenvalues_json(r.closed_loop_eigenvalues);
  return j;
}

Json long_horizon_json(const LongHorizon& h) {
  Json j;
  j["steps"] = h.trace.size();
  j["verdict"] = to_string(h.growth.verdict);
  j["growth_per_step"] = h.growth.per_sample;
  j["growth_exponent"] = h.growth.exponent;
  j["converged"] = h.converged;
  if (!h.failure.empty()) j["failure"] = h.failure;
  Json step = Json::array(), prior = Json::array(), posterior = Json::array();
  for (std::size_t k = 1; k <= h.trace.size(); k *= 2) {
    step.push_back(k);
    prior.push_back(h.trace_prior[k - 1]);
    posterior.push_back(h.trace[k - 1]);
  }
  j["step"] = step;
  j["trace_prior"] = prior;
  j["trace"] = posterior;
  return j;
}

Panel trace_panel(const StabilityAnalysis& a) {
  const LongHorizon& h = a.long_horizon;
  const FigureData steps = index_axis(static_cast<Index>(h.trace.size()));
  Panel panel{.title = "Covariance of the filter",
              .x_label = "step",
              .y_label = a.in_metres ? "trace of P (m²)" : "trace of P",
              .log_x = true,
              .log_y = true};
  panel.series.push_back(line_series("before the update", ColourRole::first, steps, h.trace_prior));
  panel.series.push_back(line_series("after the update", ColourRole::second, steps, h.trace));
  panel.series.push_back(
      upright_series("last step of the study", ColourRole::neutral, static_cast<double>(a.steps)));
  return panel;
}

Panel eigenvalue_panel(const StabilityAnalysis& a) {
  Panel panel{.title = "Eigenvalues of F − F K H",
              .x_label = "real part",
              .y_label = "imaginary part",
              .equal_aspect = true};
  PlanarCurve circle;
  for (int i = 0; i <= 120; ++i) {
    const double angle_rad = 2.0 * std::numbers::pi * i / 120.0;
    circle.x.push_back(std::cos(angle_rad));
    circle.y.push_back(std::sin(angle_rad));
  }
  panel.series.push_back(line_series("unit circle", ColourRole::neutral, circle.x, circle.y));
  const auto add = [&](const char* label, ColourRole role, const Eigen::VectorXcd& values) {
    if (values.size() == 0) return;
    panel.series.push_back(point_series(label, role, FigureData(values.real()), FigureData(values.imag())));
    if (role == ColourRole::first) panel.series.back().weight = 2.5;  // both are seen where they coincide
  };
  add("at the last step of the study", ColourRole::first, a.closed_loop_eigenvalues);
  if (a.riccati.has_limit()) add("at the limit", ColourRole::second, a.riccati.closed_loop_eigenvalues);
  return panel;
}

Figure stability_figure(const StabilityAnalysis& a) {
  return {.name = "stability",
          .caption =
              "First: the covariance over a long horizon, both axes logarithmic. A curve that levels off is "
              "bounded; a slope of one is linear growth. Second: what lies inside the unit circle is "
              "forgotten, what lies on it stays.",
          .rows = 1,
          .cols = 2,
          .panels = {trace_panel(a), eigenvalue_panel(a)},
          .row_height = 24.0};
}

/// The exact condition is one on every P0; this one may leave out what grows.
bool bounded_from_this_start_alone(const StabilityAnalysis& a) {
  return !a.inflation_varies && !a.predicted_bounded && a.riccati.stays_bounded &&
         a.riccati.kind != RiccatiKind::undecided;
}

ReportAnswer stability_answer(const StabilityAnalysis& a) {
  const LongRun seen = a.long_horizon.growth.verdict;
  const std::size_t steps = a.long_horizon.trace.size();
  if (seen == LongRun::failed) return {CellTone::alarm, "The filter breaks down: " + a.long_horizon.failure};
  const bool bounded = seen == LongRun::bounded;
  if (bounded_from_this_start_alone(a)) {
    return {CellTone::caution,
            fmt::format("P stays bounded from this P0, {} {} steps; not from every P0, as the "
                        "exact condition says",
                        bounded ? "measured over" : "but is still growing after", steps)};
  }
  if (bounded != a.predicted_bounded && !a.inflation_varies) {
    // The condition is then about this very recursion, which may be slow.
    return a.predicted_bounded
               ? ReportAnswer{CellTone::good,
                              fmt::format("P stays bounded, as the exact condition says, but is still "
                                          "growing after {} steps",
                                          steps)}
               : ReportAnswer{CellTone::alarm,
                              fmt::format("P grows without bound, as the exact condition says, so "
                                          "slowly that {} steps do not show it",
                                          steps)};
  }
  std::string text = bounded ? fmt::format("P stays bounded, measured over {} steps", steps)
                             : fmt::format("P grows without bound, measured over {} steps", steps);
  text += bounded == a.predicted_bounded
              ? " and as the exact condition says"
              : "; with the Q_t of the last step held constant theory says otherwise";
  if (bounded && !std::isnan(a.initial_covariance_effect)) {
    text += a.depends_on_initial ? "; its limit depends on P0" : "; its limit does not depend on P0";
  }
  return {bounded ? CellTone::good : CellTone::alarm, text};
}

ReportTable stability_rank_table(const StabilityAnalysis& a) {
  ReportTable table{
      .title = "Ranks",
      .columns = {
          {"matrix", ColumnAlign::words}, {"rank"}, {"of"}, {"gap"}, {"meaning", ColumnAlign::words}}};
  const auto add = [&](const char* name, const RankDecision& r, std::string meaning) {
    table.add({name, r.rank, a.state_dim, TableCell(r.gap, 3), std::move(meaning)});
  };
  add("controllability C", a.controllability, "states that process noise moves");
  add("observability O", a.observability,
      a.unobservable.empty() ? "everything is observable" : "not observable: " + joined(a.unobservable));
  add("inflation ΔP", a.inflation, fmt::format("at step {}", a.steps));
  add("noise Q_t = G Q Gᵀ + ΔP", a.noise_total, "what enters at every step");
  table.notes.push_back(
      "gap: the smallest singular value counted as nonzero over the largest not counted; ∞ where all others "
      "are zero.");
  for (const auto& [name, rank] : {std::pair{"C", &a.controllability}, {"O", &a.observability}}) {
    if (rank->doubtful) table.notes.push_back(fmt::format("rank {}: {}.", name, kRankDoubt));
  }
  return table;
}

ReportTable stability_verdict_table(const StabilityAnalysis& a) {
  ReportTable table{.title = "Stability",
                    .columns = {{"question", ColumnAlign::words},
                                {"answer", ColumnAlign::words},
                                {"numbers", ColumnAlign::words}},
                    .notes = notes(a)};
  std::string modes;
  add_known(modes, "spectral radius", a.spectral_radius, 8);
  append_item(modes, "eigenvalues " + eigenvalue_text(a), "; ");
  table.add({"error of a single run: F − F K H", error_cell(a.spectral_radius), std::move(modes)});
  const RiccatiSolution& r = a.riccati;
  table.add({"P for constant Q_t, by the Riccati equation", riccati_cell(r), riccati_text(a)});
  table.add({"P for constant Q_t, by the exact condition", bounded_cell(a.predicted_bounded),
             std::string(condition_text(a.prediction_reason))});
  if (a.noise_condition) {
    table.add({"P for constant Q_t, bound or growth", bounded_cell(a.noise_condition->bounded()),
               noise_condition_text(a)});
  }
  // The paper's condition is one on inflated filters of a static map.
  if (a.noise_condition) {
    const bool agrees = a.paper_condition_holds == a.predicted_bounded;
    table.add(
        {"P for constant Q_t, by eq. (22) of the paper",
         {a.paper_condition_holds ? "bounded" : "unbounded", agrees ? CellTone::plain : CellTone::caution},
         fmt::format("rank ΔP = {} {} rank O = {}{}", a.inflation.rank, a.paper_condition_holds ? "≤" : ">",
                     a.observability.rank, agrees ? "" : "; the exact condition says otherwise")});
  }
  const bool plain = r.has_limit() || r.K.hasNaN();
  table.add({"largest gains at the limit", r.has_limit() ? "constant" : "no limit",
             plain ? gain_text(r.K)
                   : fmt::format("after {} steps they are {}", number_text(r.steps, 3), gain_text(r.K))});
  const bool no_limit = std::isnan(a.initial_covariance_effect);
  table.add({"does the limit depend on P0",
             no_limit               ? "no limit"
             : a.depends_on_initial ? "yes"
                                    : "no",
             initial_text(a)});
  table.add({fmt::format("P of the filter itself, {} steps", a.long_horizon.trace.size()),
             long_run_cell(a.long_horizon.growth), long_run_text(a)});
  return table;
}

std::string stability_json(const Scenario& scenario, const StabilityAnalysis& a) {
  Json j;
  j["schema"] = kSchema;
  j["scenario"] = Json::parse(scenario_to_json(scenario));
  j["state_dim"] = a.state_dim;
  j["steps"] = a.steps;
  j["rank"] = {{"controllability", a.controllability.rank},
               {"observability", a.observability.rank},
               {"inflation", a.inflation.rank},
               {"noise_total", a.noise_total.rank}};
  j["rank_details"] = {{"controllability", rank_json(a.controllability)},
                       {"observability", rank_json(a.observability)},
                       {"inflation", rank_json(a.inflation)},
                       {"noise_total", rank_json(a.noise_total)}};
  j["unobservable"] = a.unobservable;
  j["gain"] = json_matrix(a.K);
  j["closed_loop_eigenvalues"] = eigenvalues_json(a.closed_loop_eigenvalues);
  j["spectral_radius"] = a.spectral_radius;
  j["riccati"] = riccati_json(a.riccati);
  j["predicted_bounded"] = a.predicted_bounded;
  j["prediction_reason"] = a.prediction_reason;
  j["noise_condition"] = noise_condition_json(a);
  if (!a.noise_condition) j["noise_condition_null_reason"] = "F is not the identity";
  j["paper_condition_holds"] = a.paper_condition_holds;
  Json initial;
  initial["depends"] = std::isnan(a.initial_covariance_effect) ? Json(nullptr) : Json(a.depends_on_initial);
  initial["effect"] = a.initial_covariance_effect;
  if (std::isnan(a.initial_covariance_effect)) initial["null_reason"] = "no limit to compare";
  initial["other_trace"] = a.riccati_other.P.trace();
  j["initial_covariance"] = initial;
  j["long_horizon"] = long_horizon_json(a.long_horizon);
  j["notes"] = notes(a);
  return text_of_json(j, 2);
}

}  // namespace

Document stability_document(const Scenario& scenario, const StabilityAnalysis& a, Index period) {
  Document document("Stability of " + scenario.name, "Ranks, Riccati equation and boundedness");
  document.answer = stability_answer(a);
  if (period > 1) {
    document.answer.text += fmt::format("; a step is here a whole period of {}, with P at its end", period);
  }
  document.json = [scenario, a] { return stability_json(scenario, a); };

  add_stability_page(document, scenario, a.state_dim, stability_verdict_table(a), "Covariance over time",
                     a.long_horizon.trace.empty() ? Figure{} : stability_figure(a), stability_rank_table(a));
  return document;
}

}  // namespace credence::internal
