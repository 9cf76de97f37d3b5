#include "reports/document/estimators/estimator_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/append_item.h"
#include "core/nan.h"
#include "core/number_text.h"
#include "montecarlo/scenario/scenario_text.h"
#include "montecarlo/worlds/posterior_bound.h"
#include "montecarlo/worlds/registry.h"
#include "reports/document/study/judgement_json.h"
#include "reports/document/verdict_text.h"
#include "reports/figures/estimator_figures.h"
#include "reports/render/json_numbers.h"

namespace credence::internal {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

const MeanInterval& nees_of(const EstimatorRow& row, EstimatorBlock block) {
  return row.nees[static_cast<std::size_t>(block)];
}

std::string with_interval(const MeanInterval& interval) {
  if (interval.count == 0) return "–";
  return interval_text(interval.mean, interval.lower, interval.upper, 4);
}

std::string nees_text(const MeanInterval& nees) {
  if (nees.count == 0) return "–";
  return nees.reason.empty() ? with_interval(nees) : number_text(nees.mean, 3);
}

/// Whether 1 lies outside of the interval, which of a few among many is chance.
bool deviates(const MeanInterval& nees) {
  return nees.count > 0 && nees.reason.empty() && (nees.lower > 1.0 || nees.upper < 1.0);
}

/// The same with a tone that says what all estimators together say of it, of what is judged so.
TableCell nees_cell(const EstimatorRow& row, EstimatorBlock block, double confidence) {
  const MeanInterval& nees = nees_of(row, block);
  const bool is_judged = block == EstimatorBlock::pose || block == EstimatorBlock::map;
  CellTone tone = nees.count > 0 ? CellTone::plain : CellTone::muted;
  if (is_judged && nees.count > 0 && nees.reason.empty()) {
    const Verdict verdict = verdict_of(row, block, confidence);
    tone = verdict == Verdict::optimistic         ? CellTone::alarm
           : verdict == Verdict::pessimistic      ? CellTone::caution
           : deviates(nees) || is_undecided(nees) ? CellTone::plain
                                                  : CellTone::good;
  }
  return {nees_text(nees), tone};
}

TableCell rmse_cell(const MeanInterval& rmse, double unit) {
  return rmse.count == 0 ? TableCell("–") : TableCell(unit * rmse.mean, 3);
}

TableCell failed_cell(const EstimatorRow& row) {
  const auto failed = static_cast<std::int64_t>(row.failures.size());
  if (failed == 0) return {"0", CellTone::plain};
  return {fmt::format("{}", failed), CellTone::alarm};
}

/// "fej: 3 of 40 runs failed …: 12 (diverged at step 9), … `credence run … --only-run 12` shows one."
std::vector<std::string> failure_notes(const EstimatorStudy& study) {
  constexpr std::size_t kNamed = 5;
  std::vector<std::string> notes;
  for (const EstimatorRow& row : study.rows) {
    if (row.failures.empty()) continue;
    std::string runs;
    for (std::size_t i = 0; i < std::min(kNamed, row.failures.size()); ++i) {
      append_item(runs, fmt::format("{} ({} at step {})", row.failures[i].run,
                                    to_string(row.failures[i].outcome), row.failures[i].step));
    }
    const auto failed = std::ssize(row.failures);
    notes.push_back(fmt::format("{}: {} and {} in no average: {}{}.", row.name,
                                failed_text(failed, study.runs), failed == 1 ? "is" : "are", runs,
                                row.failures.size() > kNamed ? ", …" : ""));
    if (study.run_command.empty()) continue;
    notes.back() += fmt::format(" `{} --set filter.estimator={} --only-run {}` shows one.", study.run_command,
                                row.name, row.failures.front().run);
  }
  return notes;
}

/// Two noises that hardly differ leave a ratio without meaning beyond its order.
TableCell pairing_cell(double gain) {
  constexpr double kMost = 1e4;
  return gain > kMost ? TableCell(fmt::format("> {:.0f}", kMost)) : TableCell(gain, 3);
}

const EstimatorRow& yardstick(const EstimatorStudy& study) {
  const auto ideal = std::ranges::find(study.rows, "ideal", &EstimatorRow::name);
  return ideal == study.rows.end() ? study.rows.front() : *ideal;
}

/// NaN throughout where nothing was counted.
MeanInterval known(const MeanInterval& interval) {
  return interval.count > 0 ? interval : MeanInterval{.mean = kNaN, .lower = kNaN, .upper = kNaN};
}

Json nees_interval_json(const MeanInterval& interval) {
  const MeanInterval i = known(interval);
  return {{"mean", i.mean}, {"lower", i.lower}, {"upper", i.upper}};
}

Json blocks_json(const EstimatorRow& row,
                 std::initializer_list<std::pair<const char*, EstimatorBlock>> blocks) {
  Json json;
  for (const auto& [name, block] : blocks) {
    json[name] = nees_interval_json(nees_of(row, block));
    const Band& band = row.bands[static_cast<std::size_t>(block)];
    if (block == EstimatorBlock::pose || block == EstimatorBlock::map) {
      const DirectedPValues& p = row.p_values[static_cast<std::size_t>(block)];
      json[name].update({{"optimistic_p_value", p.optimistic}, {"pessimistic_p_value", p.pessimistic}});
    }
    json[name]["quantiles"] = nees_of(row, block).count > 0 ? Json(band) : Json(nullptr);
  }
  return json;
}

/// The part that is judged first, and its squared error with its unit.
std::string_view judged(const EstimatorStudy& study) { return study.has_vehicle ? "pose" : "state"; }
std::string_view squared_error(const EstimatorStudy& study) {
  return study.has_vehicle ? "squared position error, m²" : "squared error of the state";
}

/// A number of headings and metres, or of the state in the units of its own.
Json accuracy_json(const EstimatorStudy& study, double heading_rad, double position) {
  const bool vehicle = study.has_vehicle;
  return {{"heading_rad", vehicle ? Json(heading_rad) : Json(nullptr)},
          {"position_m", vehicle ? Json(position) : Json(nullptr)},
          {"state", vehicle ? Json(nullptr) : Json(position)}};
}

Json row_json(const EstimatorStudy& study, const EstimatorRow& row) {
  using enum EstimatorBlock;
  Json json{{"estimator", row.name}, {"chart", row.profile.chart}};
  json["nees"] =
      blocks_json(row, {{"pose", pose}, {"heading", heading}, {"position", position}, {"map", map}});
  json["nees_other_chart"] = blocks_json(row, {{"pose", plane_pose}, {"position", chart_position}});
  const MeanInterval none{}, &position_rmse = row.position_rmse_m, &efficiency = row.position_efficiency;
  const auto of_vehicle = [&](const MeanInterval& r) -> const MeanInterval& {
    return study.has_vehicle ? r : none;
  };
  const auto of_state = [&](const MeanInterval& r) -> const MeanInterval& {
    return study.has_vehicle ? none : r;
  };
  const auto ends = [](const MeanInterval& r) { return Json{known(r).lower, known(r).upper}; };
  json["rmse"] = accuracy_json(study, known(row.heading_rmse_rad).mean, known(position_rmse).mean);
  json["rmse"]["heading_interval_rad"] = ends(row.heading_rmse_rad);
  json["rmse"]["position_interval_m"] = ends(of_vehicle(position_rmse));
  json["rmse"]["state_interval"] = ends(of_state(position_rmse));
  json["efficiency"] = {{"heading", nees_interval_json(row.heading_efficiency)},
                        {"position", nees_interval_json(of_vehicle(efficiency))},
                        {"state", nees_interval_json(of_state(efficiency))}};
  json["claimed_rmse"] = accuracy_json(study, row.claimed_heading_rad, row.claimed_position_m);
  json["unobservable"] = row.unobservable;
  json["rank_gap"] = row.rank_gap;
  json["seconds_per_step"] = row.profile.seconds_per_step;
  json["runs"] = row.runs + std::ssize(row.failures);
  json["failed"] = row.failures.size();
  json["failures"] = json_list(row.failures, failure_json);
  json["not_converged"] = not_converged_json(row.not_converged);
  json["pose_nees_over_time"] = row.pose_nees;
  json["pose_nees_quantiles_over_time"] = row.pose_bands;
  return json;
}

Json paired_json(const EstimatorStudy& study, const PairedDifference& paired) {
  return {{"first", paired.first},
          {"second", paired.second},
          {"of", !paired.of_position ? "nees.pose"
                 : study.has_vehicle ? "position_error_squared_m2"
                                     : "state_error_squared"},
          {"difference", known(paired.difference).mean},
          {"lower", paired.difference.lower},
          {"upper", paired.difference.upper},
          {"p_value", paired.p_value},
          {"gain", paired.gain},
          {"runs", paired.difference.count}};
}

std::string runs_text(const EstimatorStudy& study) {
  return fmt::format("{} of {}, the same {} and measurements for all.", counted(study.runs, "run"),
                     counted(study.scenario.study.steps, "step"),
                     study.has_vehicle ? "odometry" : "process noise");
}

ReportTable estimator_table(const EstimatorStudy& study) {
  using enum EstimatorBlock;
  constexpr ColumnAlign words = ColumnAlign::words;
  ReportTable table{.title = fmt::format("Estimators in {}", study.scenario.name),
                    .columns = {{"estimator", words}}};
  const auto add_columns = [&](std::initializer_list<TableColumn> columns) {
    table.columns.insert(table.columns.end(), columns);
  };
  if (study.has_vehicle) {
    add_columns({{"NEES of heading", words},
                 {"of position", words},
                 {"of pose", words},
                 {"of the map", words},
                 {"RMSE heading °"},
                 {"position m"}});
  } else {
    add_columns({{"NEES", words}, {"RMSE"}});
  }
  add_columns({{"unobservable"}, {"time a step", words}, {"failed runs"}});
  const double confidence = study.scenario.study.confidence;
  for (const EstimatorRow& row : study.rows) {
    std::vector<TableCell> cells = {row.name};
    if (study.has_vehicle) {
      for (const EstimatorBlock block : {heading, position, pose, map}) {
        cells.push_back(nees_cell(row, block, confidence));
      }
      cells.push_back(rmse_cell(row.heading_rmse_rad, kDegrees));
    } else {
      cells.push_back(nees_cell(row, pose, confidence));
    }
    cells.push_back(rmse_cell(row.position_rmse_m, 1.0));
    cells.emplace_back(row.unobservable);
    cells.emplace_back(duration_text(row.profile.seconds_per_step, 2));
    cells.push_back(failed_cell(row));
    table.add(std::move(cells));
  }
  table.notes = {fmt::format("{} NEES over dof, averaged over all steps of a run; mean over the runs with "
                             "its {:g} % interval, each by itself; the answer, and the colours, take all "
                             "estimators together (Holm). 1 is consistent, above is optimistic. That is "
                             "the mean alone: of single states and steps run tells.",
                             runs_text(study), 100.0 * confidence),
                 "unobservable: directions that the stack of H Φ at the filter's own Jacobians leaves open "
                 "in run 0. time a step: predict and update, without statistics.",
                 study.note};
  if (study.has_vehicle) {
    table.notes.insert(
        table.notes.begin() + 1,
        fmt::format("Pose and map: the error in the chart of the filter's own P. Position: x̂ − x, P "
                    "transported to first order at the estimate. The map at every {}.",
                    study.map_stride == 1 ? "step" : ordinal(study.map_stride) + " step"));
  }
  for (const EstimatorRow& row : study.rows) {
    if (row.profile.chart == "plane") continue;
    table.notes.push_back(fmt::format(
        "{}: its chart is {}. Taken as x̂ − x its pose NEES is {}; the position of its chart has {}.",
        row.name, row.profile.chart_text, nees_text(nees_of(row, plane_pose)),
        nees_text(nees_of(row, chart_position))));
  }
  for (std::string& note : failure_notes(study)) table.notes.push_back(std::move(note));
  for (const EstimatorRow& row : study.rows) {
    if (row.not_converged.empty()) continue;
    table.notes.push_back(
        fmt::format("{}: {}", row.name, not_converged_sentence(row.not_converged, study.runs)));
  }
  for (std::string& note : left_out_notes(study.left_out)) table.notes.push_back(std::move(note));
  return table;
}

ReportTable estimator_bound_table(const EstimatorStudy& study) {
  constexpr ColumnAlign words = ColumnAlign::words;
  ReportTable table{.title = "Errors beside the posterior Cramér-Rao bound",
                    .columns = {{"estimator", words}}};
  if (study.has_vehicle) {
    table.columns.insert(
        table.columns.end(),
        {{"efficiency in heading", words}, {"in position", words}, {"P claims: heading °"}, {"position m"}});
  } else {
    table.columns.insert(table.columns.end(), {{"efficiency", words}, {"P claims"}});
  }
  for (const EstimatorRow& row : study.rows) {
    if (row.runs == 0) continue;
    std::vector<TableCell> cells = {row.name};
    if (study.has_vehicle) cells.emplace_back(with_interval(row.heading_efficiency));
    cells.emplace_back(with_interval(row.position_efficiency));
    if (study.has_vehicle) cells.emplace_back(kDegrees * row.claimed_heading_rad, 3);
    cells.emplace_back(row.claimed_position_m, 3);
    table.add(std::move(cells));
  }
  const VehicleBound& bound = study.bound;
  if (std::isnan(bound.position_squared)) {
    const std::string reason = no_bound_reason(study.scenario);
    table.notes = {"No bound: " + (reason.empty() ? "the filter that knows the noise fails" : reason) + "."};
    return table;
  }
  const std::string position = number_text(std::sqrt(bound.position_squared), 3);
  table.notes = {fmt::format(
      "On average over all noise no estimator without bias has an RMSE below {} ([Tichavsky 1998]: Jacobians "
      "along the true path); that of these runs may be below by chance. Efficiency: the bound over the mean "
      "squared error, with the interval of the latter.",
      study.has_vehicle ? fmt::format("{} ° and {} m",
                                      number_text(kDegrees * std::sqrt(bound.heading_squared), 3), position)
                        : position)};
  if (std::ranges::any_of(study.rows, [](const EstimatorRow& row) { return !row.failures.empty(); })) {
    table.notes.emplace_back(
        "An estimator of which runs failed is measured on the others, which may be below the bound for that "
        "alone.");
  }
  return table;
}

/// "twice what P claims, or half", of those that are undecided.
std::string what_may_be(const EstimatorStudy& study, const std::vector<std::string>& undecided) {
  bool twice = false, half = false;
  for (const EstimatorRow& row : study.rows) {
    if (std::ranges::find(undecided, row.name) == undecided.end()) continue;
    twice = twice || may_be_twice(nees_of(row, EstimatorBlock::pose));
    half = half || may_be_half(nees_of(row, EstimatorBlock::pose));
  }
  return twice && half ? "twice what P claims, or half"
         : twice       ? "twice what P claims"
                       : "half of what P claims";
}

ReportAnswer estimator_answer(const EstimatorStudy& study) {
  std::vector<std::string> consistent, alone, undecided, optimistic, pessimistic, unknown, map_optimistic,
      map_pessimistic, failed;
  const double confidence = study.scenario.study.confidence;
  for (const EstimatorRow& row : study.rows) {
    const MeanInterval &pose = nees_of(row, EstimatorBlock::pose), &map = nees_of(row, EstimatorBlock::map);
    if (!row.failures.empty()) {
      failed.push_back(
          fmt::format("{} of {} of {}", row.failures.size(), counted(study.runs, "run"), row.name));
    }
    if (row.runs == 0 || std::isnan(pose.lower)) {
      unknown.push_back(row.name);
      continue;
    }
    const Verdict verdict = verdict_of(row, EstimatorBlock::pose, confidence);
    if (is_inconsistent(verdict)) {
      (verdict == Verdict::optimistic ? optimistic : pessimistic)
          .push_back(fmt::format("{} ({} times the squared error that P claims)", row.name,
                                 number_text(pose.mean, 3)));
      continue;
    }
    (deviates(pose) ? alone : is_undecided(pose) ? undecided : consistent).push_back(row.name);
    const Verdict of_map = verdict_of(row, EstimatorBlock::map, confidence);
    if (is_inconsistent(of_map)) {
      (of_map == Verdict::optimistic ? map_optimistic : map_pessimistic)
          .push_back(fmt::format("{} ({} times)", row.name, number_text(map.mean, 3)));
    }
  }
  if (std::ranges::all_of(study.rows, [](const EstimatorRow& row) { return row.runs == 0; })) {
    return {CellTone::alarm, "No run of any estimator finished"};
  }
  std::vector<std::string> sentences;
  for (const auto& [word, names] : {std::pair("Optimistic", &optimistic), {"Pessimistic", &pessimistic}}) {
    if (!names->empty())
      sentences.push_back(fmt::format("{} in the {}: {}", word, judged(study), fmt::join(*names, ", ")));
  }
  const bool all_right = optimistic.empty() && pessimistic.empty();
  if (!consistent.empty()) {
    const std::string of_any =
        all_right && alone.empty() && undecided.empty() ? fmt::format(" the {} of any:", judged(study)) : "";
    sentences.push_back(fmt::format("No evidence against{} {}", of_any, fmt::join(consistent, ", ")));
  } else if (unknown.empty() && alone.empty() && undecided.empty()) {
    sentences.emplace_back("None is consistent");
  }
  if (!alone.empty()) {
    sentences.push_back(
        fmt::format("Inconsistent alone, but not {}: {}",
                    study.rows.size() == 1 ? "with all its tests taken together" : "among so many",
                    fmt::join(alone, ", ")));
  }
  if (!undecided.empty()) {
    sentences.push_back(fmt::format("Undecided after {}, as {} squared error may be {}: {}",
                                    counted(study.runs, "run"), undecided.size() == 1 ? "its" : "their",
                                    what_may_be(study, undecided), fmt::join(undecided, ", ")));
  }
  for (const auto& [word, names] :
       {std::pair("optimistic", &map_optimistic), {"pessimistic", &map_pessimistic}}) {
    if (!names->empty()) {
      sentences.push_back(
          fmt::format("The map is {}, though not the pose: {}", word, fmt::join(*names, ", ")));
    }
  }
  if (!unknown.empty()) {
    sentences.push_back(fmt::format("Nothing can be said of {}", fmt::join(unknown, ", ")));
  }
  if (!failed.empty()) sentences.push_back(fmt::format("Failed: {}", fmt::join(failed, ", ")));
  const bool good = all_right && undecided.empty() && unknown.empty() && failed.empty() &&
                    map_optimistic.empty() && map_pessimistic.empty();
  return {good ? CellTone::good : CellTone::caution, fmt::format("{}", fmt::join(sentences, ". "))};
}

ReportTable estimator_difference_table(const EstimatorStudy& study) {
  const std::string& other = yardstick(study).name;
  ReportTable table{.title = fmt::format("Each estimator less {}, on the same noise", other),
                    .columns = {{"estimator", ColumnAlign::words},
                                {"of", ColumnAlign::words},
                                {"difference", ColumnAlign::words},
                                {"p"},
                                {"gain of pairing"},
                                {"runs"}}};
  for (const PairedDifference& paired : study.paired) {
    if (paired.first != other && paired.second != other) continue;
    const bool turned = paired.first == other;
    const MeanInterval& d = paired.difference;
    const double sign = turned ? -1.0 : 1.0;
    table.add({turned ? paired.second : paired.first,
               paired.of_position ? std::string(squared_error(study))
                                  : fmt::format("{} NEES over dof", judged(study)),
               d.count == 0
                   ? std::string("–")
                   : interval_text(sign * d.mean, turned ? -d.upper : d.lower, turned ? -d.lower : d.upper),
               TableCell(paired.p_value, 2), pairing_cell(paired.gain), d.count});
  }
  table.notes = {
      "Mean over the runs that both finished, with its interval (Student's and Hall's scores), and the "
      "p-value of no difference, not adjusted for the number of pairs.",
      "gain of pairing: how many times more runs would be needed for the same precision if each estimator "
      "had noise of its own."};
  return table;
}

}  // namespace

std::vector<std::string> left_out_notes(std::span<const LeftOutEstimator> left_out) {
  std::vector<std::string> notes;
  for (const LeftOutEstimator& of : left_out)
    notes.push_back(fmt::format("{} is left out: {}.", of.name, of.reason));
  return notes;
}

Json left_out_json(std::span<const LeftOutEstimator> left_out) {
  return json_list(left_out, [](const LeftOutEstimator& of) -> Json {
    return {{"estimator", of.name}, {"reason", of.reason}};
  });
}

std::string estimator_json(const EstimatorStudy& study) {
  Json json;
  json["schema"] = kSchema;
  json["scenario"] = Json::parse(scenario_to_json(study.scenario));
  json["runs"] = study.runs;
  json["steps"] = study.scenario.study.steps;
  json["confidence"] = study.scenario.study.confidence;
  json["complete"] = study.complete;
  json["map_every_steps"] = study.map_stride;
  json["quantile_levels"] = kBandLevels;
  json["bound"] =
      accuracy_json(study, std::sqrt(study.bound.heading_squared), std::sqrt(study.bound.position_squared));
  json["window_ends"] = study.window_ends;
  json["rows"] = json_list(study.rows, [&](const EstimatorRow& row) -> Json { return row_json(study, row); });
  json["left_out"] = left_out_json(study.left_out);
  json["paired"] = json_list(
      study.paired, [&](const PairedDifference& paired) -> Json { return paired_json(study, paired); });
  json["null_reason"] = "no run that ended well, no finite bound, or a world without such states";
  return text_of_json(json);
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

}  // namespace credence::internal
