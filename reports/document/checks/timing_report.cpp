#include "reports/document/checks/timing_report.h"

#include <fmt/format.h>

#include <cmath>

#include "core/append_item.h"
#include "core/number_text.h"
#include "reports/render/atomic_file.h"
#include "reports/render/json_numbers.h"

namespace credence::internal {
namespace {

using enum ColumnAlign;

const char* words_of(TimedFilter filter) {
  switch (filter) {
    case TimedFilter::full: return "full";
    case TimedFilter::naive: return "full, textbook";
    case TimedFilter::map: return "O(N), map blocks";
    case TimedFilter::batch: return "O(N), by batches";
  }
  return "";
}

std::string between(const MeasuredTime& time) {
  return fmt::format("{} … {}", duration_text(time.lower), duration_text(time.upper));
}

std::string bytes_text(const std::optional<double>& bytes) {
  if (!bytes) return "not told";
  if (*bytes < 1e6) return number_text(*bytes / 1e3, 3) + " kB";
  return number_text(*bytes / 1e6, 3) + " MB";
}

// ---- JSON
// ------------------------------------------------------------------------------------------------

void put_time(Json& json, const char* key, const MeasuredTime& time) {
  json[key] = time.median;
  json["lower"] = time.lower;
  json["upper"] = time.upper;
}

Json filter_json(const FilterTime& time) {
  Json json{{"filter", to_string(time.filter)}, {"landmarks", time.landmarks}, {"observed", time.observed}};
  put_time(json, "seconds_per_step", time.step);
  json["bytes"] = time.bytes ? Json(*time.bytes) : Json(nullptr);
  return json;
}

Json growth_json(const GrowthFit& fit) {
  return {{"value", fit.law.exponent}, {"lower", fit.law.lower},
          {"upper", fit.law.upper},    {"filter", to_string(fit.filter)},
          {"observed", fit.observed},  {"from_landmarks", fit.from},
          {"points", fit.points}};
}

/// By filter, for the first number observed; null with a reason where too few sizes were timed.
Json slopes_json(const TimingResult& result) {
  Json slopes;
  for (const TimedFilter filter : kTimedFilters) {
    const auto name = std::string(to_string(filter));
    for (const GrowthFit& fit : result.growth) {
      if (fit.filter == filter && !slopes.contains(name)) slopes[name] = growth_json(fit);
    }
    if (slopes.contains(name)) continue;
    slopes[name] = {{"value", nullptr},
                    {"lower", nullptr},
                    {"upper", nullptr},
                    {"reason", "fewer than three sizes of the map in the fitted range"}};
  }
  return slopes;
}

Json rate(const MeasuredTime& time) { return 1.0 / time.median; }

// ---- Tables
// ----------------------------------------------------------------------------------------------

ReportTable step_table(const TimingResult& result) {
  ReportTable table{.title = "One step: predict, and update with the landmarks observed",
                    .columns = {{"filter", words},
                                {"observed"},
                                {"landmarks"},
                                {"median", words},
                                {"median within (95 %)", words},
                                {"memory", words}}};
  for (const FilterTime& time : result.filters) {
    table.add({words_of(time.filter), time.observed, time.landmarks, duration_text(time.step.median),
               between(time.step), bytes_text(time.bytes)});
  }
  table.notes = {
      fmt::format(
          "{} repetitions of at least {}, all filters in turn in random order; time of the computing thread.",
          result.plan.repetitions, duration_text(result.plan.seconds)),
      "full: each element of one triangle of P touched once an update. full, textbook: dense P in "
      "Joseph form, Eigen. O(N), map blocks: vehicle, its correlations, and one block a landmark, "
      "decorrelated after each scalar measurement, or by batches of them.",
      fmt::format("Sizes beyond {} (full) and {} (textbook) landmarks are not timed for these.",
                  largest_map(TimedFilter::full), largest_map(TimedFilter::naive))};
  return table;
}

ReportTable growth_table(const TimingResult& result) {
  ReportTable table{.title = "How the time of a step grows with the map: seconds ~ N^slope",
                    .columns = {{"filter", words},
                                {"observed"},
                                {"slope"},
                                {"slope within (95 %)", words},
                                {"fitted from N"},
                                {"sizes"}}};
  for (const GrowthFit& fit : result.growth) {
    table.add({words_of(fit.filter), fit.observed, TableCell(fit.law.exponent, 3),
               fmt::format("{} … {}", number_text(fit.law.lower, 3), number_text(fit.law.upper, 3)), fit.from,
               fit.points});
  }
  if (table.rows.empty()) {
    table.columns.clear();
    table.notes.emplace_back("No slope is fitted to so few sizes.");
  }
  for (const Crossover& crossover : result.crossovers) {
    const char* seen = crossover.observed == 1 ? "landmark" : "landmarks";
    if (crossover.landmarks) {
      table.notes.push_back(fmt::format("With {} {} observed the O(N) filter is the faster one from {} on.",
                                        crossover.observed, seen, number_text(*crossover.landmarks, 2)));
    } else {
      table.notes.push_back(
          fmt::format("With {} {} observed the {} filter is the faster one at every size timed for both.",
                      crossover.observed, seen, words_of(crossover.faster_below)));
    }
  }
  return table;
}

ReportTable monte_carlo_table(const TimingResult& result) {
  ReportTable table{
      .title = "Monte Carlo on one thread",
      .columns = {{"what", words}, {"time", words}, {"within (95 %)", words}, {"million a second"}}};
  const auto add = [&](const char* what, const MeasuredTime& time) {
    table.add({what, duration_text(time.median), between(time), TableCell(1e-6 / time.median, 3)});
  };
  const MonteCarloTimes& times = result.monte_carlo;
  add("one normal", times.normal);
  add("one step of one run of the monobot, N = 1, NEES and NIS", times.step);
  add("the same by a plain loop with the standard library's normals", times.reference_step);
  table.notes = {fmt::format("{} × the plain loop. Engine and accumulators included.",
                             number_text(times.reference_step.median / times.step.median, 3))};
  return table;
}

ReportTable scaling_table(const TimingResult& result) {
  ReportTable table{.title = "Runs of the planar world, N = 10, over threads",
                    .columns = {{"threads"}, {"time of a run", words}, {"runs a second"}, {"× one thread"}}};
  for (const ThreadScaling& scaling : result.scaling) {
    table.add({scaling.threads, duration_text(scaling.run.median), TableCell(1.0 / scaling.run.median, 3),
               TableCell(result.scaling.front().run.median / scaling.run.median, 3)});
  }
  return table;
}

// ---- Figure
// ----------------------------------------------------------------------------------------------

ColourRole role_of(TimedFilter filter) {
  switch (filter) {
    case TimedFilter::full: return ColourRole::estimate;
    case TimedFilter::naive: return ColourRole::neutral;
    case TimedFilter::map: return ColourRole::truth;
    case TimedFilter::batch: return ColourRole::third;
  }
  return ColourRole::estimate;
}

Panel step_panel(const TimingResult& result, Index observed) {
  Panel panel{.title = counted(observed, "landmark") + " observed",
              .x_label = "landmarks N",
              .y_label = "time of a step (µs)",
              .log_x = true,
              .log_y = true};
  for (const TimedFilter filter : kTimedFilters) {
    FigureData n, median, lower, upper;
    for (const FilterTime& time : result.filters) {
      if (time.filter != filter || time.observed != observed) continue;
      n.push_back(static_cast<double>(time.landmarks));
      median.push_back(1e6 * time.step.median);
      lower.push_back(1e6 * time.step.lower);
      upper.push_back(1e6 * time.step.upper);
    }
    if (n.empty()) continue;
    std::string label = words_of(filter);
    for (const GrowthFit& fit : result.growth) {
      if (fit.filter != filter || fit.observed != observed) continue;
      label += fmt::format(", slope {}", number_text(fit.law.exponent, 3));
    }
    panel.series.push_back(line_series("", role_of(filter), n, median));
    panel.series.push_back(error_bar_series(label, role_of(filter), n, median, lower, upper));
  }
  return panel;
}

Figure step_figure(const TimingResult& result) {
  Figure figure{.name = "steps", .caption = "Medians with their 95 % intervals.", .panels = {}};
  if (!result.growth.empty())
    figure.caption += " Slopes are fitted in log-log scales over the sizes that the table names.";
  std::vector<Index> observed;
  for (const FilterTime& time : result.filters) {
    if (std::ranges::find(observed, time.observed) == observed.end()) {
      observed.push_back(time.observed);
    }
  }
  for (const Index each : observed) figure.panels.push_back(step_panel(result, each));
  arrange(figure);
  return figure;
}

std::vector<std::pair<std::string, std::string>> machine_facts(const MachineDescription& machine) {
  return {{"processor", fmt::format("{}, {} threads", machine.processor, machine.processors)},
          {"kernels", machine.instruction_set},
          {"compiler", machine.compiler},
          {"load before", std::isfinite(machine.load) ? number_text(machine.load, 2) : "not told"}};
}

ReportAnswer timing_answer(const TimingResult& result) {
  std::string slopes;
  for (const TimedFilter filter : {TimedFilter::map, TimedFilter::full}) {
    for (const GrowthFit& fit : result.growth) {
      if (fit.filter != filter) continue;
      slopes += fmt::format("{} the {} filter takes time that grows like N^{}",
                            slopes.empty() ? "A step of" : ", of", words_of(filter),
                            number_text(fit.law.exponent, 3));
      break;
    }
  }
  if (slopes.empty()) slopes = "Too few sizes of the map were timed for a law of growth";
  for (const Crossover& crossover : result.crossovers) {
    if (!crossover.landmarks) continue;
    slopes += fmt::format("; the O(N) filter is the faster one from {} landmarks on ({} observed)",
                          number_text(*crossover.landmarks, 2), crossover.observed);
    break;
  }
  const double load = result.machine.load;
  constexpr double kIdle = 0.5;  // tasks that still leave every thread to the measurement
  if (std::isfinite(load) && load > kIdle) {
    return {CellTone::caution,
            fmt::format(
                "{}. The machine was busy (load {}): times are too long, and threads scale worse than they "
                "would",
                slopes, number_text(load, 2))};
  }
  return {CellTone::good, slopes};
}

std::string timing_json(const TimingResult& result) {
  const MachineDescription& machine = result.machine;
  Json j{{"schema", kSchema}, {"complete", result.complete}};
  j["machine"] = {{"processor", machine.processor},
                  {"processors", machine.processors},
                  {"instruction_set", machine.instruction_set},
                  {"compiler", machine.compiler},
                  {"load", machine.load}};
  j["repetitions"] = result.plan.repetitions;
  j["rows"] = json_list(result.filters, filter_json);
  j["slopes"] = slopes_json(result);
  j["growth"] = json_list(result.growth, growth_json);
  j["crossovers"] = Json::array();
  for (const Crossover& crossover : result.crossovers) {
    Json row{{"observed", crossover.observed}};
    row["landmarks"] = crossover.landmarks ? Json(*crossover.landmarks) : Json(nullptr);
    if (!crossover.landmarks) {
      row["reason"] =
          fmt::format("{} is the faster one at every size timed for both", to_string(crossover.faster_below));
    }
    j["crossovers"].push_back(std::move(row));
  }
  const MonteCarloTimes& times = result.monte_carlo;
  j["monte_carlo"] = {{"steps_per_second", rate(times.step)},
                      {"normals_per_second", rate(times.normal)},
                      {"reference_steps_per_second", rate(times.reference_step)}};
  j["threads"] = json_list(result.scaling, [](const ThreadScaling& scaling) -> Json {
    return {{"threads", scaling.threads}, {"runs_per_second", rate(scaling.run)}};
  });
  return text_of_json(j);
}

}  // namespace

Document timing_document(const TimingResult& result) {
  Document document("What does a step cost?",
                    "Time against the size of the map, and the speed of Monte Carlo");
  document.answer = timing_answer(result);
  document.json = [result] { return timing_json(result); };

  const ReportTable growth = growth_table(result), steps = step_table(result);
  const ReportTable monte_carlo = monte_carlo_table(result), scaling = scaling_table(result);
  document.show_answer();
  document.show(
      {fmt::format("{}, {} kernels", result.machine.processor, result.machine.instruction_set), ""});
  document.show_apart({growth, steps, monte_carlo, scaling});

  document.facts(machine_facts(result.machine));
  if (!result.complete) document.callout(CellTone::caution, "Interrupted: fewer repetitions than planned.");
  document.section("Filters");
  document.figure(step_figure(result));
  document.table(growth);
  document.folded("Every size", [&] { document.table(steps); });
  document.section("Monte Carlo");
  document.table(monte_carlo);
  document.table(scaling);
  document.link("all of it as JSON", "timing.json");
  document.file("timing.json", [result](const std::filesystem::path& target) {
    write_file(target, timing_json(result) + "\n");
  });
  return document;
}

}  // namespace credence::internal
