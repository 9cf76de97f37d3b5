#include "reports/document/checks/selftest_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "core/append_item.h"
#include "core/nan.h"
#include "core/number_text.h"
#include "reports/render/json_numbers.h"

namespace credence::internal {
namespace {

/// Of what is below a hundredth of a percent no digit tells anything.
std::string percent(double share) {
  return share < 1e-4 ? fixed_text(100.0 * share, 2) : number_text(100.0 * share, 3);
}

std::string range(const StudyShare& share) {
  return fmt::format("{} … {}", percent(share.interval.lower), percent(share.interval.upper));
}

TableCell ok_cell(bool ok) {
  return ok ? TableCell("ok", CellTone::good) : TableCell("OUT OF CALIBRATION", CellTone::alarm);
}

Json with_share(Json object, const StudyShare& share) {
  object.update({{"measured", share.interval.value},
                 {"lower", share.interval.lower},
                 {"upper", share.interval.upper},
                 {"studies", share.count.total}});
  return object;
}
Json share_json(const StudyShare& share) { return with_share({}, share); }

Json wrong_filter_json(const WrongFilterResult& filter) {
  Json json{{"filter", filter.name}, {"ok", filter.ok}};
  json["caught"] = share_json(filter.caught);
  json["caught"]["wanted"] = filter.caught_wanted;
  if (filter.caught_most < 1.0) json["caught"]["most"] = filter.caught_most;
  if (filter.direction) {
    json["direction"] = share_json(filter.direction_right);
    json["direction"]["expected"] = to_string(*filter.direction);
  }
  json["cause"] = to_string(filter.expected);
  json["cause_named"] = share_json(filter.named);
  json["cause_named"]["wanted"] = filter.named_wanted;
  json["causes"] = json_list(filter.causes, [](const CauseShare& named) -> Json {
    return {{"cause", to_string(named.cause)}, {"share", named.share}};
  });
  json["power"] = json_list(filter.power, [](const PowerRow& row) {
    return with_share({{"name", row.test}}, row.measured);
  });
  return json;
}

// The nominal rates of the tests, the largest first.
std::set<double, std::greater<>> nominal_levels(const SelftestResult& result) {
  std::set<double, std::greater<>> levels;
  for (const CalibrationRow& row : result.calibration) levels.insert(row.nominal);
  return levels;
}

// Every test once, numbered as in the figures, with its rate at each nominal level.
ReportTable calibration_table(const SelftestResult& result) {
  using enum ColumnAlign;
  ReportTable table{.title = "False alarms on exact filters",
                    .columns = {{"no."}, {"test", words}, {"law", words}}};
  const std::set<double, std::greater<>> levels = nominal_levels(result);
  for (const double level : levels) {
    table.columns.push_back({fmt::format("% at {:g} %", 100.0 * level)});
    table.columns.push_back({"true rate within %", words});
  }
  table.columns.push_back({"", words});
  std::vector<std::string> names;
  for (const CalibrationRow& row : result.calibration) {
    if (std::ranges::find(names, row.name) == names.end()) names.push_back(row.name);
  }
  for (const std::string& name : names) {
    const CalibrationRow& test = *std::ranges::find(result.calibration, name, &CalibrationRow::name);
    std::vector<TableCell> cells{table.rows.size() + 1, name, std::string(to_string(test.exactness))};
    bool ok = true;
    for (const double level : levels) {
      const auto row = std::ranges::find_if(result.calibration, [&](const CalibrationRow& candidate) {
        return candidate.name == name && candidate.nominal == level;
      });
      if (row == result.calibration.end()) {
        cells.insert(cells.end(), 2, TableCell("–"));
        continue;
      }
      cells.emplace_back(100.0 * row->measured.interval.value, 3);
      cells.emplace_back(range(row->measured));
      ok = ok && row->ok;
    }
    cells.push_back(ok_cell(ok));
    table.rows.push_back(std::move(cells));
  }
  table.notes = {
      fmt::format(
          "{} studies of {} runs over {} steps. Intervals of Clopper and Pearson; all hold together with "
          "{:g} % confidence, so that calibrated tests fail here with at most {:g} % probability.",
          result.studies, result.runs, result.steps, 100.0 * (1.0 - result.family_level),
          100.0 * result.family_level),
      "conservative: at most nominal, by proof or, where whole runs are compared, to the "
      "precision of the law of their mean; often far below. approximate: a limit law or "
      "matched cumulants."};
  return table;
}

ReportTable naive_table(const SelftestResult& result) {
  using enum ColumnAlign;
  ReportTable table{.title = "What is often done instead, on the same filters: shown, not used",
                    .columns = {{"test", words}, {"nominal %"}, {"false alarms %"}, {"instead", words}}};
  for (const NaiveRow& row : result.naive) {
    table.add({row.name, TableCell(100.0 * row.nominal, 2), TableCell(100.0 * row.measured.interval.value, 3),
               row.instead});
  }
  return table;
}

ReportTable wrong_filter_table(const SelftestResult& result) {
  using enum ColumnAlign;
  ReportTable table{.title = "Filters that are wrong on purpose",
                    .columns = {{"filter", words},
                                {"caught %"},
                                {"right direction %"},
                                {"right cause %"},
                                {"cause the advice names", words},
                                {"", words}}};
  for (const WrongFilterResult& filter : result.wrong_filters) {
    std::string causes;
    for (const CauseShare& named : filter.causes) {
      if (named.share < 0.05) continue;
      append_item(causes, fmt::format("{} ({} %)", to_string(named.cause), percent(named.share)), "; ");
    }
    table.add(
        {filter.name, TableCell(100.0 * filter.caught.interval.value, 3),
         filter.direction ? TableCell(100.0 * filter.direction_right.interval.value, 3) : TableCell("–"),
         TableCell(100.0 * filter.named.interval.value, 3), causes,
         filter.ok ? TableCell("ok", CellTone::good) : TableCell("NOT FOUND", CellTone::alarm)});
  }
  std::string right;
  for (const WrongFilterResult& filter : result.wrong_filters) {
    if (filter.caught_most < 1.0) append_item(right, filter.name, "; ");
  }
  table.notes = {fmt::format(
      "caught: by the word at {:g} %, over everything together. {} studies of {} runs for each filter. ok "
      "unless the share is proved to be below {:g} % caught, {:g} % named or 99 % of those caught in the "
      "right direction{}.",
      100.0 * result.power_level, result.wrong_filter_studies, result.wrong_filter_runs,
      100.0 * result.wrong_filters.front().caught_wanted, 100.0 * result.wrong_filters.front().named_wanted,
      right.empty()
          ? ""
          : "; where P is right, and the cause alone is to be found (" + right + "), above 10 % caught")};
  return table;
}

ReportTable saving_table(const SelftestResult& result) {
  using enum ColumnAlign;
  ReportTable table{
      .title = "Stopping by verdict on clear cases",
      .columns = {{"filter", words}, {"fixed plan, runs"}, {"runs used"}, {"saved %"}, {"caught %"}}};
  for (const SavingResult& saving : result.savings) {
    const double planned = static_cast<double>(saving.max_runs);
    table.add({saving.name, saving.max_runs, saving.runs.mean,
               TableCell(100.0 * (1.0 - saving.runs.mean / planned), 3),
               TableCell(100.0 * saving.caught.interval.value, 3)});
  }
  return table;
}

// Every test is one row of the panel, from the top down in the order of the table.
Panel rate_panel(const SelftestResult& result, double nominal) {
  FigureData rate, row, lower, upper, failed_rate, failed_row;
  for (const CalibrationRow& test : result.calibration) {
    if (std::abs(test.nominal - nominal) > 1e-9) continue;
    const double number = static_cast<double>(row.size() + 1);
    rate.push_back(100.0 * test.measured.interval.value);
    lower.push_back(100.0 * test.measured.interval.lower);
    upper.push_back(100.0 * test.measured.interval.upper);
    row.push_back(number);
    if (test.ok) continue;
    failed_rate.push_back(rate.back());
    failed_row.push_back(number);
  }
  Panel panel{.title = fmt::format("Nominal {:g} %", 100.0 * nominal),
              .x_label = "number of the test in the table",
              .y_label = "false alarms (%)"};
  panel.series.push_back(level_series("nominal", ColourRole::truth, 100.0 * nominal));
  panel.series.push_back(error_bar_series("measured", ColourRole::estimate, row, rate, lower, upper));
  if (!failed_row.empty()) {
    panel.series.push_back(point_series("out of calibration", ColourRole::alarm, failed_row, failed_rate));
  }
  return panel;
}

/// The tests of the first filter; those of one with other sensors may be others.
Figure power_figure(const SelftestResult& result) {
  constexpr double kLeast = 15.0, kLine = 1.5;  // of a name
  const std::vector<WrongFilterResult>& filters = result.wrong_filters;
  const std::vector<PowerRow> tests = filters.empty() ? std::vector<PowerRow>() : filters.front().power;
  FigureData x = index_axis(std::ssize(tests)), y = index_axis(std::ssize(filters));
  std::vector<FigureText> names;
  Matrix cells = Matrix::Constant(std::ssize(filters), std::ssize(tests), kNaN);
  for (Index filter = 0; filter < cells.rows(); ++filter) {
    const WrongFilterResult& wrong = filters[static_cast<std::size_t>(filter)];
    names.emplace_back(wrong.name);
    for (Index test = 0; test < cells.cols(); ++test) {
      const auto row =
          std::ranges::find(wrong.power, tests[static_cast<std::size_t>(test)].test, &PowerRow::test);
      if (row != wrong.power.end()) cells(filter, test) = 100.0 * row->measured.interval.value;
    }
  }
  Figure figure{
      .name = "power",
      .caption =
          "Which test sees which wrong filter: share of studies rejected at 5 %. Tests are numbered as in "
          "the table of false alarms; grey: not made of this filter, which has sensors of its own.",
      .panels = {}};
  Panel panel{.title = "Power",
              .x_label = "number of the test",
              .y_label = "",
              .y_names = names,
              .colour_label = "rejected (%)",
              .colour_range = AxisRange{0.0, 100.0}};
  panel.series.push_back(heat_series(std::move(x), std::move(y), std::move(cells)));
  figure.panels = {panel};
  figure.row_height = std::max(kLeast, kLine * static_cast<double>(filters.size()));
  return figure;
}

Figure false_alarm_figure(const SelftestResult& result) {
  Figure figure{.name = "false-alarms",
                .caption =
                    "Measured false-alarm rate of every test with the interval that holds for all rows "
                    "together. Conservative tests may lie below the nominal rate, no test above.",
                .panels = {}};
  for (const double level : nominal_levels(result)) figure.panels.push_back(rate_panel(result, level));
  figure.rows = static_cast<int>(figure.panels.size());
  return figure;
}

ReportAnswer selftest_answer(const SelftestResult& result) {
  const std::size_t failures = selftest_failures(result).size();
  if (failures == 0) {
    return {CellTone::good,
            "No test is proved to exceed its false-alarm rate, and the fault of every wrong filter is found"};
  }
  return {CellTone::alarm,
          fmt::format("Do not trust the verdicts of this build: {} out of calibration or {} what is wrong",
                      failures == 1 ? "1 test is" : fmt::format("{} tests are", failures),
                      failures == 1 ? "misses" : "miss")};
}

std::string selftest_json(const SelftestResult& result) {
  Json j{{"schema", kSchema},
         {"ok", result.ok},
         {"seed", result.seed},
         {"studies", result.studies},
         {"runs", result.runs},
         {"steps", result.steps},
         {"family_level", result.family_level},
         {"interval_confidence", result.interval_confidence}};
  j["tests"] = json_list(result.calibration, [](const CalibrationRow& row) {
    Json test = with_share({{"name", row.name}, {"nominal", row.nominal}}, row.measured);
    test.update({{"law", to_string(row.exactness)}, {"ok", row.ok}});
    return test;
  });
  j["naive"] = json_list(result.naive, [](const NaiveRow& row) {
    Json naive = with_share({{"name", row.name}, {"nominal", row.nominal}}, row.measured);
    naive["instead"] = row.instead;
    return naive;
  });
  j["power_level"] = result.power_level;
  j["wrong_filters"] = json_list(result.wrong_filters, wrong_filter_json);
  j["stop_by_verdict"] = json_list(result.savings, [](const SavingResult& saving) -> Json {
    return {{"filter", saving.name},         {"max_runs", saving.max_runs},
            {"mean_runs", saving.runs.mean}, {"lower", saving.runs.lower},
            {"upper", saving.runs.upper},    {"caught", share_json(saving.caught)}};
  });
  return text_of_json(j);
}

}  // namespace

std::vector<std::string> selftest_failures(const SelftestResult& result) {
  std::vector<std::string> failures;
  for (const CalibrationRow& row : result.calibration) {
    if (row.ok) continue;
    failures.push_back(fmt::format(
        "\"{}\" is out of calibration: {} % false alarms at nominal {} %, true rate within {} %", row.name,
        percent(row.measured.interval.value), percent(row.nominal), range(row.measured)));
  }
  for (const WrongFilterResult& filter : result.wrong_filters) {
    if (filter.ok) continue;
    failures.push_back(fmt::format("\"{}\" is caught in {} % and its cause named in {} % of the studies",
                                   filter.name, percent(filter.caught.interval.value),
                                   percent(filter.named.interval.value)));
  }
  return failures;
}

Document selftest_document(const SelftestResult& result) {
  Document document("Can these tests be trusted?", "Calibration of Credence's statistical tests");
  document.answer = selftest_answer(result);
  document.json = [result] { return selftest_json(result); };

  const ReportTable calibration = calibration_table(result), naive = naive_table(result);
  const ReportTable wrong_filters = wrong_filter_table(result), savings = saving_table(result);
  document.show_answer();
  document.show_apart({calibration, naive, wrong_filters, savings});

  document.bullets(selftest_failures(result));
  document.section("False alarms");
  document.figure(false_alarm_figure(result));
  document.table(calibration);
  document.table(naive);
  document.section("Power");
  document.table(wrong_filters);
  document.figure(power_figure(result));
  document.table(savings);
  return document;
}

}  // namespace credence::internal
