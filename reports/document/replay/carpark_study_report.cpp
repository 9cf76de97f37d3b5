#include "reports/document/replay/carpark_study_report.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/append_item.h"
#include "core/number_text.h"
#include "datasets/replay/carpark_findings.h"
#include "reports/figures/replay_figures.h"
#include "reports/render/json_numbers.h"

namespace credence::internal {
namespace {

using enum ColumnAlign;
constexpr auto kPairwise = InflationSolution::pairwise;
constexpr auto kExact = InflationSolution::min_trace;

std::string initial_words(const InitialDeviations& initial) {
  return fmt::format("{:g} m, {:g}°", initial.position_std, initial.heading_std_deg);
}

ReportTable findings_table(const std::vector<CarparkFinding>& findings) {
  ReportTable table{
      .title = "What was to be shown",
      .columns = {{"statement", words}, {"measured", words}, {"holds", words}, {"meaning", words}},
      .notes = {"Two numbers or triples: P0 of 0.05 m, 2° and of 0.316 m, 15°. Triples: Figures 5, 6, 7."}};
  for (const CarparkFinding& f : findings)
    table.add({f.statement, f.measured,
               f.holds ? TableCell("yes", CellTone::good) : TableCell("no", CellTone::alarm), f.meaning});
  return table;
}

ReportTable variants_table(const CarparkStudy& study) {
  ReportTable table{.title = "All variants",
                    .columns = {{"inflation", words},
                                {"observable", words},
                                {"paper", words},
                                {"P0", words},
                                {"max tr P vehicle"},
                                {"final tr P vehicle"},
                                {"final tr P landmarks"},
                                {"NIS"},
                                {"GPS NEES"},
                                {"map (m)"},
                                {"aligned (m)"}},
                    .notes = {"Traces in m², of the vehicle its position. Expected of NIS and of GPS NEES: "
                              "2. Map: RMS of the landmarks against the survey, as they lie and with the "
                              "survey moved rigidly onto them."}};
  std::int64_t observations = 0, rejected = 0;
  for (const CarparkVariant& variant : carpark_variants()) {
    for (const InitialDeviations& initial : carpark_initials()) {
      const ReplayResult& r = study.find(variant, initial);
      table.add({inflation_words(variant), anchor_words(variant), paper_figure(variant),
                 initial_words(initial), r.covariance.vehicle_max, r.covariance.vehicle_final,
                 r.covariance.landmarks_final, r.nis.mean(), r.vehicle_nees.mean(), r.landmark_rms,
                 r.landmark_rms_aligned});
      observations += r.observations;
      rejected += r.rejected;
    }
  }
  table.notes.push_back(fmt::format("{} in all runs together, {} rejected.",
                                    counted(observations, "observation"),
                                    rejected == 0 ? "none" : fmt::to_string(rejected)));
  return table;
}

/// The variants of the independence study.
std::vector<CarparkVariant> independence_variants() {
  std::vector<CarparkVariant> variants;
  for (const Index anchors : {1, 2})
    for (const auto& [inflation, solution] :
         {std::pair{Inflation::none, kPairwise}, std::pair{Inflation::map, kPairwise},
          std::pair{Inflation::map, kExact}})
      variants.push_back({inflation, solution, anchors});
  return variants;
}

ReportTable independence_table(const CarparkStudy& study) {
  ReportTable table{
      .title = "Does the map depend on P0?",
      .columns = {{"inflation", words}, {"observability", words}},
      .notes = {"Final tr P of the landmarks in m² for P0 of these deviations; the last column is the "
                "largest over the smallest. A second anchor makes the map independent of P0, one does not: "
                "the turn about a single beacon stays unobservable, so that the paper's independence of the "
                "initial covariance needs two beacons, or a known heading."}};
  for (const InitialDeviations& initial : independence_initials())
    table.columns.push_back({initial_words(initial)});
  table.columns.push_back({"ratio"});
  for (const CarparkVariant& variant : independence_variants()) {
    std::vector<TableCell> row{inflation_words(variant), anchor_words(variant)};
    for (const InitialDeviations& initial : independence_initials())
      row.emplace_back(study.find(variant, initial).covariance.landmarks_final);
    row.emplace_back(spread_over_initials(study, variant));
    table.add(row);
  }
  return table;
}

ReportTable horizon_table(const CarparkStudy& study) {
  ReportTable table{
      .title = fmt::format("Long horizon: the same way forth and back {} times", study.plan.loops),
      .columns = {{"inflation", words},
                  {"first loop"},
                  {"half way"},
                  {"last loop"},
                  {"fitted exponent"},
                  {"increments × a loop"},
                  {"growth", words}},
      .notes = {fmt::format(
          "tr P of the landmarks in m² after a loop; partial, P0 of 0.05 m and 2°; Jacobians along the "
          "reference, every {}scan. Exponent: slope of log trace over log loop in the second half; 0 "
          "bounded, 1 linear, exponential growth gives more with every loop. Increments: by what the growth "
          "of a loop exceeds that of the loop before, 1 for linear growth.",
          study.plan.scan_stride == 1 ? "" : ordinal(study.plan.scan_stride) + " ")}};
  for (const CarparkHorizonRun& run : study.horizon) {
    const std::vector<LongHorizonLoop>& loops = run.result.loops;
    if (loops.empty()) continue;
    table.add({inflation_words(run.variant), loops.front().landmarks, loops[(loops.size() - 1) / 2].landmarks,
               loops.back().landmarks, number_text(run.result.fitted_exponent(), 3),
               number_text(run.result.increment_ratio(), 4), growth_words(run.result)});
  }
  return table;
}

Figure independence_figure(const CarparkStudy& study) {
  Figure figure{.name = "carpark-independence",
                .caption =
                    "Final trace of the landmarks for five P0, from (0.05 m, 2°) to (2 m, 15°), over the "
                    "trace for the first: a flat curve is independent of P0.",
                .rows = 1,
                .cols = 2};
  for (const Index anchors : {1, 2}) {
    Panel panel{.title = anchors == 1 ? "One anchor" : "Two anchors",
                .x_label = "P0, in the order of the table",
                .y_label = "tr P over the first",
                .log_y = true};
    Index number = 0;
    for (const CarparkVariant& variant : independence_variants()) {
      if (variant.anchors != anchors) continue;
      const double first = study.find(variant, independence_initials().front()).covariance.landmarks_final;
      const FigureData ratio = figure_data(independence_initials(), [&](const InitialDeviations& initial) {
        return study.find(variant, initial).covariance.landmarks_final / first;
      });
      const FigureData x = index_axis(static_cast<Index>(ratio.size()));
      panel.series.push_back(line_series(inflation_words(variant), numbered_role(number), x, ratio));
      panel.series.push_back(point_series("", numbered_role(number++), x, ratio));
    }
    panel.x_range = AxisRange{0.0, 6.0};
    panel.y_range = AxisRange{0.5, 20.0};
    figure.panels.push_back(std::move(panel));
  }
  return figure;
}

Figure horizon_figure(const CarparkStudy& study) {
  Panel panel{.title = "Long horizon",
              .x_label = "loop",
              .y_label = "tr P of the landmarks (m²)",
              .log_x = true,
              .log_y = true};
  Index number = 0;
  for (const CarparkHorizonRun& run : study.horizon) {
    panel.series.push_back(line_series(inflation_words(run.variant), numbered_role(number++),
                                       index_axis(std::ssize(run.result.loops)),
                                       figure_data(run.result.loops, &LongHorizonLoop::landmarks)));
  }
  return {.name = "carpark-horizon",
          .caption =
              "Trace of the landmarks after each loop, forth and back along the recorded path; both axes "
              "logarithmic, so that linear growth has slope 1.",
          .panels = {panel},
          .row_height = 26.0};
}

/// Figures 5, 6, 7 and 8 with one bound.
std::vector<Figure> paper_figures(const CarparkStudy& study, InflationSolution solution) {
  const std::string bound = solution == kExact ? "exact minimal trace" : "pairwise bound";
  const std::string suffix = solution == kExact ? "exact" : "pairwise";
  const InitialDeviations initial = carpark_initials().front();
  std::vector<Figure> figures;
  Figure eight{
      .name = "carpark-figure8-" + suffix,
      .caption = fmt::format(
          "The paper's Figure 8, {}: path and map over GPS and survey, ellipses are 2σ of the final map.",
          bound),
      .rows = 2,
      .cols = 2};
  eight.panels.push_back(replay_map_panel("No inflation", study.find({}, initial)));
  const CarparkVariant variants[] = {
      {Inflation::full, solution, 0}, {Inflation::map, solution, 0}, {Inflation::map, solution, 1}};
  for (const CarparkVariant& variant : variants) {
    const ReplayResult& result = study.find(variant, initial);
    const std::string figure = paper_figure(variant);
    figures.push_back(replay_run_figure(fmt::format("carpark-figure{}-{}", figure.back(), suffix),
                                        fmt::format("The paper's {}: {}, {}. Errors against GPS with the "
                                                    "filter's 2σ, and of the landmarks against the "
                                                    "survey (thick where one is beyond its own 2σ) over the "
                                                    "band from the smallest to the largest 2σ of "
                                                    "all and their median; gains, traces, NIS.",
                                                    figure, inflation_words(variant), anchor_words(variant)),
                                        result));
    eight.panels.push_back(replay_map_panel(
        fmt::format("{}: {}, {}", figure, inflation_words(variant), anchor_words(variant)), result));
  }
  figures.push_back(std::move(eight));
  return figures;
}

Json variant_json(const CarparkVariant& variant) {
  return {{"inflation", inflation_words(variant)},
          {"anchors", variant.anchors},
          {"figure", paper_figure(variant)}};
}

ReportAnswer carpark_study_answer(const std::vector<CarparkFinding>& findings) {
  const auto held = std::ranges::count(findings, true, &CarparkFinding::holds);
  return {held == std::ssize(findings) ? CellTone::good : CellTone::caution,
          fmt::format("{} of the {} things that the replays were to show hold", held, findings.size())};
}

Json variant_run_json(const CarparkVariantRun& run) {
  const ReplayResult& r = run.result;
  Json row = variant_json(run.variant);
  row.update(
      {{"initial",
        {{"position_std", run.initial.position_std}, {"heading_std_deg", run.initial.heading_std_deg}}},
       {"observations", r.observations},
       {"rejected", r.rejected},
       {"not_converged", r.not_converged},
       {"nis", r.nis.mean()},
       {"gps_nees", r.vehicle_nees.mean()},
       {"landmark_rms", r.landmark_rms},
       {"landmark_rms_aligned", r.landmark_rms_aligned},
       {"covariance",
        {{"vehicle_max", r.covariance.vehicle_max},
         {"vehicle_final", r.covariance.vehicle_final},
         {"landmarks_max", r.covariance.landmarks_max},
         {"landmarks_final", r.covariance.landmarks_final}}}});
  return row;
}

Json horizon_json(const CarparkHorizonRun& run) {
  Json row = variant_json(run.variant);
  row.update({{"landmarks", json_list(run.result.loops, &LongHorizonLoop::landmarks)},
              {"fitted_exponent", run.result.fitted_exponent()},
              {"growth_per_loop", run.result.growth_per_loop()},
              {"increment_ratio", run.result.increment_ratio()},
              {"growth", growth_words(run.result)},
              {"updates", run.result.steps},
              {"not_converged", run.result.not_converged}});
  return row;
}

std::string carpark_study_json(const CarparkStudy& study) {
  Json j;
  j["schema"] = kSchema;
  j["dataset"] = "carpark";
  j["findings"] = json_list(carpark_findings(study), [](const CarparkFinding& f) -> Json {
    return {{"id", f.id},       {"source", f.source},  {"statement", f.statement}, {"measured", f.measured},
            {"holds", f.holds}, {"meaning", f.meaning}};
  });
  j["variants"] = json_list(study.runs, variant_run_json);
  j["long_horizon"] = json_list(study.horizon, horizon_json);
  j["null_reason"] = "null: the number is not finite";
  return text_of_json(j);
}

}  // namespace

Document carpark_study_document(const CarparkStudy& study) {
  const std::vector<CarparkFinding> findings = carpark_findings(study);
  Document document("The car park: Figures 5 to 8 and their neighbours", "Real data replayed");
  document.answer = carpark_study_answer(findings);
  document.json = [study] { return carpark_study_json(study); };

  const ReportTable held = findings_table(findings), variants = variants_table(study);
  const ReportTable independence = independence_table(study), horizon = horizon_table(study);
  document.show_answer();
  document.show_apart({held, variants, independence, horizon});

  document.section("What holds");
  document.table(held);
  document.section("All variants");
  document.table(variants);
  document.section("Independence of P0");
  document.table(independence);
  document.figure(independence_figure(study));
  document.section("Long horizon");
  document.table(horizon);
  document.figure(horizon_figure(study));
  document.folded_section("Figures 5 to 8 with the exact minimal trace", "", "", true,
                          [&] { document.figures(paper_figures(study, kExact)); });
  document.folded_section("Figures 5 to 8 with the pairwise bound", "", "", false,
                          [&] { document.figures(paper_figures(study, kPairwise)); });
  return document;
}

}  // namespace credence::internal
