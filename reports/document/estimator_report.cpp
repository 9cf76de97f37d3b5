#include "reports/document/estimator_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/registry.h"
#include "reports/figures/estimator_figures.h"
#include "reports/render/interval_text.h"
#include "reports/render/json_numbers.h"
#include "reports/render/number_text.h"

namespace credence {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

const MeanInterval& nees_of(const EstimatorRow& row, EstimatorBlock block) {
  return row.nees[static_cast<std::size_t>(block)];
}

std::string with_interval(const MeanInterval& interval) {
  if (interval.count == 0) return "–";
  return interval_text(interval.mean, interval.lower, interval.upper, 4);
}

/// The same with a tone that says whether 1 lies in it.
TableCell nees_cell(const MeanInterval& nees) {
  if (nees.count == 0) return {"–", CellTone::muted};
  if (!nees.reason.empty()) return number_text(nees.mean, 3);
  const CellTone tone = nees.lower > 1.0   ? CellTone::alarm
                        : nees.upper < 1.0 ? CellTone::caution
                                           : CellTone::good;
  return {with_interval(nees), tone};
}

TableCell rmse_cell(const MeanInterval& rmse, double unit) {
  return rmse.count == 0 ? TableCell("–") : TableCell(unit * rmse.mean, 3);
}

TableCell failed_cell(const EstimatorRow& row) {
  const auto failed = static_cast<std::int64_t>(row.failures.size());
  if (failed == 0) return {"0", CellTone::plain};
  return {fmt::format("{}", failed), CellTone::alarm};
}

/// "Runs 12, 40, 77 … of fej failed; credence run … --only-run 12 shows one."
std::vector<std::string> failure_notes(const EstimatorStudy& study) {
  constexpr std::size_t kNamed = 5;
  std::vector<std::string> notes;
  for (const EstimatorRow& row : study.rows) {
    if (row.failures.empty()) continue;
    std::string runs;
    for (std::size_t i = 0; i < std::min(kNamed, row.failures.size()); ++i) {
      runs += fmt::format("{}{} ({} at step {})", i == 0 ? "" : ", ", row.failures[i].run,
                          to_string(row.failures[i].outcome), row.failures[i].step);
    }
    notes.push_back(
        fmt::format("{}: {} of {} runs failed and are in no average: {}{}. `credence run --set "
                    "filter.estimator={} --only-run {}` "
                    "shows one.",
                    row.name, row.failures.size(), study.runs, runs,
                    row.failures.size() > kNamed ? ", …" : "", row.name, row.failures.front().run));
  }
  return notes;
}

const EstimatorRow& yardstick(const EstimatorStudy& study) {
  const auto ideal = std::ranges::find(study.rows, "ideal", &EstimatorRow::name);
  return ideal == study.rows.end() ? study.rows.front() : *ideal;
}

Json nees_interval_json(const MeanInterval& interval) {
  return {{"mean", interval.count == 0 ? Json(nullptr) : json_number(interval.mean)},
          {"lower", json_number(interval.lower)},
          {"upper", json_number(interval.upper)}};
}

Json blocks_json(const EstimatorRow& row,
                 std::initializer_list<std::pair<const char*, EstimatorBlock>> blocks) {
  Json json;
  for (const auto& [name, block] : blocks) {
    json[name] = nees_interval_json(nees_of(row, block));
    const Band& band = row.bands[static_cast<std::size_t>(block)];
    json[name]["quantiles"] =
        nees_of(row, block).count > 0 ? json_numbers({band.begin(), band.end()}) : Json(nullptr);
  }
  return json;
}

Json row_json(const EstimatorRow& row) {
  using enum EstimatorBlock;
  Json json{{"estimator", row.name}, {"chart", row.profile.chart}};
  json["nees"] =
      blocks_json(row, {{"pose", pose}, {"heading", heading}, {"position", position}, {"map", map}});
  json["nees_other_chart"] = blocks_json(row, {{"pose", plane_pose}, {"position", chart_position}});
  const auto rmse = [](const MeanInterval& r) { return r.count == 0 ? Json(nullptr) : json_number(r.mean); };
  json["rmse"] = {{"heading_rad", rmse(row.heading_rmse_rad)},
                  {"position_m", rmse(row.position_rmse_m)},
                  {"heading_interval_rad",
                   {json_number(row.heading_rmse_rad.lower), json_number(row.heading_rmse_rad.upper)}},
                  {"position_interval_m",
                   {json_number(row.position_rmse_m.lower), json_number(row.position_rmse_m.upper)}}};
  json["efficiency"] = {{"heading", nees_interval_json(row.heading_efficiency)},
                        {"position", nees_interval_json(row.position_efficiency)}};
  json["claimed_rmse"] = {{"heading_rad", json_number(row.claimed_heading_rad)},
                          {"position_m", json_number(row.claimed_position_m)}};
  json["unobservable"] = row.unobservable;
  json["rank_gap"] = json_number(row.rank_gap);
  json["seconds_per_step"] = json_number(row.profile.seconds_per_step);
  json["runs"] = row.runs + std::ssize(row.failures);
  json["failed"] = row.failures.size();
  json["failures"] = Json::array();
  for (const RunFailure& failure : row.failures) {
    json["failures"].push_back(
        {{"run", failure.run}, {"step", failure.step}, {"outcome", to_string(failure.outcome)}});
  }
  json["pose_nees_over_time"] = json_numbers(row.pose_nees);
  Json bands = Json::array();
  for (const Band& band : row.pose_bands) bands.push_back(json_numbers({band.begin(), band.end()}));
  json["pose_nees_quantiles_over_time"] = std::move(bands);
  return json;
}

Json paired_json(const PairedDifference& paired) {
  return {{"first", paired.first},
          {"second", paired.second},
          {"of", paired.of_position ? "position_error_squared_m2" : "nees.pose"},
          {"difference", paired.difference.count == 0 ? Json(nullptr) : json_number(paired.difference.mean)},
          {"lower", json_number(paired.difference.lower)},
          {"upper", json_number(paired.difference.upper)},
          {"p_value", json_number(paired.p_value)},
          {"gain", json_number(paired.gain)},
          {"runs", paired.difference.count}};
}

std::string runs_text(const EstimatorStudy& study) {
  return fmt::format("{} runs of {} steps, the same odometry and measurements for all.", study.runs,
                     study.scenario.study.steps);
}

ReportTable estimator_table(const EstimatorStudy& study) {
  using enum EstimatorBlock;
  constexpr ColumnAlign words = ColumnAlign::words;
  ReportTable table{.title = fmt::format("Estimators in {}", study.scenario.name),
                    .columns = {{"estimator", words},
                                {"NEES of heading", words},
                                {"of position", words},
                                {"of pose", words},
                                {"of the map", words},
                                {"RMSE heading °"},
                                {"position m"},
                                {"unobservable"},
                                {"time a step", words},
                                {"failed runs"}},
                    .rows = {},
                    .notes = {}};
  for (const EstimatorRow& row : study.rows) {
    table.add({row.name, nees_cell(nees_of(row, heading)), nees_cell(nees_of(row, position)),
               nees_cell(nees_of(row, pose)), nees_cell(nees_of(row, map)),
               rmse_cell(row.heading_rmse_rad, kDegrees), rmse_cell(row.position_rmse_m, 1.0),
               row.unobservable, duration_text(row.profile.seconds_per_step, 2), failed_cell(row)});
  }
  table.notes = {
      fmt::format(
          "{} NEES over dof, averaged over all steps of a run; mean over the runs with its {:g} % interval. "
          "1 is consistent, above is optimistic.",
          runs_text(study), 100.0 * study.scenario.study.confidence),
      fmt::format(
          "Pose and map: the error in the chart of the filter's own P. Position: x̂ − x, P transported to "
          "first order at the estimate. The map at every {}th step.",
          study.map_stride),
      "unobservable: directions that the stack of H Φ at the filter's own Jacobians leaves open in run 0. "
      "time "
      "a step: predict and update, without statistics.",
      study.note};
  for (const EstimatorRow& row : study.rows) {
    if (row.profile.chart == "plane") continue;
    table.notes.push_back(fmt::format(
        "{}: its chart is {}. In the plane its pose NEES is {}; the position of its chart has {}.", row.name,
        row.profile.chart_text, nees_cell(nees_of(row, plane_pose)).text,
        nees_cell(nees_of(row, chart_position)).text));
  }
  const std::vector<std::string> failures = failure_notes(study);
  table.notes.insert(table.notes.end(), failures.begin(), failures.end());
  return table;
}

ReportTable estimator_bound_table(const EstimatorStudy& study) {
  constexpr ColumnAlign words = ColumnAlign::words;
  ReportTable table{.title = "Errors beside the posterior Cramér-Rao bound",
                    .columns = {{"estimator", words},
                                {"efficiency in heading", words},
                                {"in position", words},
                                {"P claims: heading °"},
                                {"position m"}},
                    .rows = {},
                    .notes = {}};
  for (const EstimatorRow& row : study.rows) {
    if (row.runs == 0) continue;
    table.add({row.name, with_interval(row.heading_efficiency), with_interval(row.position_efficiency),
               TableCell(kDegrees * row.claimed_heading_rad, 3), TableCell(row.claimed_position_m, 3)});
  }
  table.notes = {fmt::format(
      "No estimator without bias has an RMSE below {} ° and {} m ([Tichavsky 1998]: Jacobians along the true "
      "path). Efficiency: the bound over the mean squared error, with the interval of the latter.",
      number_text(kDegrees * std::sqrt(study.bound.heading_squared), 3),
      number_text(std::sqrt(study.bound.position_squared), 3))};
  return table;
}

ReportAnswer estimator_answer(const EstimatorStudy& study) {
  std::string consistent, optimistic;
  for (const EstimatorRow& row : study.rows) {
    const MeanInterval& pose = nees_of(row, EstimatorBlock::pose);
    if (row.runs == 0 || std::isnan(pose.lower)) continue;
    if (pose.lower > 1.0) {
      optimistic += fmt::format("{}{} ({} times the squared error that P claims)",
                                optimistic.empty() ? "" : ", ", row.name, number_text(pose.mean, 3));
    } else {
      consistent += (consistent.empty() ? "" : ", ") + row.name;
    }
  }
  if (optimistic.empty())
    return {CellTone::good, "Nothing says that the pose of any is optimistic: " + consistent};
  return {CellTone::caution,
          fmt::format("Optimistic in the pose: {}. {}", optimistic,
                      consistent.empty() ? "None is not" : "Nothing is seen against " + consistent)};
}

ReportTable estimator_difference_table(const EstimatorStudy& study) {
  const std::string& other = yardstick(study).name;
  ReportTable table{.title = fmt::format("Each estimator less {}, on the same noise", other),
                    .columns = {{"estimator", ColumnAlign::words},
                                {"of", ColumnAlign::words},
                                {"difference", ColumnAlign::words},
                                {"p"},
                                {"gain of pairing"},
                                {"runs"}},
                    .rows = {},
                    .notes = {}};
  for (const PairedDifference& paired : study.paired) {
    if (paired.first != other && paired.second != other) continue;
    const bool turned = paired.first == other;
    const MeanInterval& d = paired.difference;
    const double sign = turned ? -1.0 : 1.0;
    table.add({turned ? paired.second : paired.first,
               paired.of_position ? "squared position error, m²" : "pose NEES over dof",
               d.count == 0
                   ? std::string("–")
                   : interval_text(sign * d.mean, turned ? -d.upper : d.lower, turned ? -d.lower : d.upper),
               TableCell(paired.p_value, 2), TableCell(paired.gain, 3), d.count});
  }
  table.notes = {
      "Mean over the runs that both finished, with its interval (Student's t), and the p-value of no "
      "difference, not "
      "adjusted for the number of pairs.",
      "gain of pairing: as many times more runs would show the same difference as sharply with noise of "
      "their own."};
  return table;
}

}  // namespace

std::string estimator_json(const EstimatorStudy& study) {
  Json json;
  json["schema"] = kSchema;
  json["scenario"] = Json::parse(scenario_to_json(study.scenario));
  json["runs"] = study.runs;
  json["steps"] = study.scenario.study.steps;
  json["confidence"] = study.scenario.study.confidence;
  json["complete"] = study.complete;
  json["map_every_steps"] = study.map_stride;
  json["quantile_levels"] = json_numbers({kBandLevels.begin(), kBandLevels.end()});
  json["bound"] = {{"heading_rad", json_number(std::sqrt(study.bound.heading_squared))},
                   {"position_m", json_number(std::sqrt(study.bound.position_squared))}};
  json["window_ends"] = json_numbers(study.window_ends);
  json["rows"] = Json::array();
  for (const EstimatorRow& row : study.rows) json["rows"].push_back(row_json(row));
  json["paired"] = Json::array();
  for (const PairedDifference& paired : study.paired) json["paired"].push_back(paired_json(paired));
  json["null_reason"] = "no run that ended well, or no finite bound";
  return json.dump(1);
}

Document estimator_document(const EstimatorStudy& study) {
  Document document("Estimators in " + study.scenario.name, "Consistency, accuracy and cost, by Credence");
  document.answer = estimator_answer(study);
  document.json = [study] { return estimator_json(study); };

  const ReportTable consistency = estimator_table(study), bound = estimator_bound_table(study);
  const ReportTable differences = estimator_difference_table(study);
  document.show_answer();
  document.show_apart({consistency, bound});
  if (study.rows.size() > 1) document.brief.emplace_back(differences);

  document.section("Who is consistent");
  document.facts({{"world", world_text(study.scenario)}, {"runs", runs_text(study)}});
  document.table(consistency);
  document.figures(estimator_figures(study));
  document.table(bound);
  document.section("Differences");
  document.table(differences);
  document.section("Settings");
  document.verbatim(canonical_toml(study.scenario));
  return document;
}

}  // namespace credence
