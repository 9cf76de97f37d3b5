#include "reports/document/logs/log_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <utility>

#include "analysis/evidence/verdicts/judgement_settling.h"
#include "analysis/evidence/verdicts/judgement_tests.h"
#include "analysis/evidence/verdicts/judgement_word.h"
#include "core/append_item.h"
#include "core/number_text.h"
#include "reports/document/logs/log_gate.h"
#include "reports/document/logs/log_json.h"
#include "reports/document/logs/log_table.h"
#include "reports/document/study/calibration_report.h"
#include "reports/document/study/judgement_report.h"
#include "reports/document/study/step_csv.h"
#include "reports/document/verdict_text.h"
#include "reports/figures/log_figures.h"

namespace credence::internal {
namespace {

/// The mean NEES of the first log in every chart.
ReportTable charts_table(const LogPoses& log) {
  ReportTable table{
      .title =
          fmt::format("Mean NEES of the pose in every chart, 6 expected; judged is {}", log.charts.declared),
      .columns = {{"chart", ColumnAlign::words},
                  {"if it were written so"},
                  {"p", ColumnAlign::words},
                  {"carried over"}},
      .notes = {fmt::format("Of {}, {} rows. If it were written so: the numbers of the file, read as of this "
                            "chart, and whether they would fit. Carried over: the covariance of the chart "
                            "that is judged, taken into this one by the Jacobian at the error.",
                            log.file.filename().string(), log.charts.rows),
                "The chart is a matter of the program that wrote the log (--chart), and to be chosen before "
                "one looks at these numbers."}};
  for (const ChartNees& nees : log.charts.charts) {
    const bool judged = nees.chart == log.charts.declared;
    table.add({judged ? nees.chart + " (judged)" : nees.chart, nees.as_written, p_value_text(nees.p_value),
               nees.carried});
  }
  return table;
}

void add_rejected(Document& document, const Evidence& s) {
  if (s.rejected.empty()) return;
  document.callout(CellTone::alarm, fmt::format("{} of {} rows were rejected: counted, never repaired. "
                                                "Neither their NEES nor their NIS is in the numbers above.",
                                                s.rejected_rows(), s.rows));
  std::vector<std::string> items;
  for (const auto& [reason, rows] : s.rejected) {
    items.push_back(fmt::format("{}: {}{}", counted(rows.count, "row"), reason,
                                rows.first.empty() ? "" : "; the first is " + rows.first));
  }
  document.bullets(std::move(items));
}

void add_wrongly_certain(Document& document, const Evidence& s) {
  for (const auto& [state, rows] : s.wrongly_certain) {
    document.callout(
        CellTone::alarm,
        fmt::format("{} errs in {} of {} rows where P claims certainty (variance 0), and is left out "
                    "of them{}.",
                    state, rows.count, s.rows, rows.first.empty() ? "" : "; the first is " + rows.first));
  }
}

/// All tests with their numbers, folded.
void add_tests(Document& document, const CheckedLogs& logs, const std::string& name) {
  const LogAnalysis& a = logs.analysis;
  document.section("Tests");
  document.folded("All tests and statistics", [&] {
    std::vector<std::string> sentences;
    if (a.evidence.has_truth) sentences.push_back(verdict_sentence("NEES", a.judgement.nees));
    if (a.judgement.nis.count > 0) sentences.push_back(verdict_sentence("NIS", a.judgement.nis));
    for (std::string& sentence : log_statistics(a.judgement)) sentences.push_back(std::move(sentence));
    document.bullets(std::move(sentences));
    document.table(tests_table(a.judgement));
    if (!a.judgement.accuracy.empty()) {
      document.table(accuracy_table(a.judgement, a.bound ? &*a.bound : nullptr));
    }
    document.figure(evidence_figure(name, a.judgement, a.evidence.layout.sensors));
  });
}

/// Whether errors beside P are all that tells it.
bool told_by_errors(Cause cause) {
  constexpr Cause kCauses[] = {Cause::covariance_scale,
                               Cause::covariance_at_steps,
                               Cause::claimed_sigma,
                               Cause::shared_noise,
                               Cause::cross_covariance,
                               Cause::truth,
                               Cause::wrong_dof,
                               Cause::wide_angle,
                               Cause::linearisation,
                               Cause::linearisation_or_bias,
                               Cause::process_noise_or_linearisation,
                               Cause::initial_covariance_or_process_noise};
  return std::ranges::find(kCauses, cause) != std::end(kCauses);
}

/// Whether errors or innovations of the wrong size or mean tell it.
bool told_by_size(Cause cause) {
  constexpr Cause kCauses[] = {Cause::bias,
                               Cause::process_noise_too_small,
                               Cause::process_noise_too_large,
                               Cause::measurement_noise_too_small,
                               Cause::measurement_noise_too_large,
                               Cause::measurement_noise_of_components,
                               Cause::process_or_measurement_noise,
                               Cause::initial_covariance,
                               Cause::initial_covariance_or_nonlinear_start,
                               Cause::nonlinear_start};
  return std::ranges::find(kCauses, cause) != std::end(kCauses);
}

/// Nothing that is told of runs or of time is so where one is the other.
void leave_swapped_open(Judgement& j) {
  const std::string open = "the axes of the arrays look swapped: runs are steps, and steps are runs";
  const auto leave = [&](ConsistencyVerdict& v) {
    v.verdict = Verdict::undecided;
    v.reason = open;
  };
  leave(j.nees);
  leave(j.nis);
  if (j.vehicle_nees) leave(*j.vehicle_nees);
  for (BlockVerdict& block : j.blocks) leave(block.verdict);
  for (SensorJudgement& sensor : j.sensors) leave(sensor.nis);
  j.word.verdict = Verdict::undecided;
  j.word.says.clear();
  j.word.joined.clear();
  j.causes.clear();
  j.responsible = {};
  j.scale_covariance = j.scale_innovation = j.scale_measurement_noise = no_scale("the axes look swapped");
}

}  // namespace

std::vector<std::string> CheckedLogs::all_remarks() const {
  std::vector<std::string> all = remarks;
  if (std::string no_pose = no_pose_sentence(analysis.evidence.layout); !no_pose.empty())
    all.push_back(std::move(no_pose));
  return all;
}

std::vector<std::string> CheckedLogs::advice() const {
  std::vector<std::string> all = mistakes;
  std::ranges::move(advice_sentences(analysis.judgement, explained), std::back_inserter(all));
  constexpr std::int64_t kFew = 5;
  const std::int64_t runs = analysis.evidence.study.runs;
  if (analysis.judgement.word.verdict == Verdict::pessimistic && runs < kFew) {
    all.push_back(
        fmt::format("{} cannot {} a covariance that is too large from one that rightly holds an error which "
                    "stays over a run, and happens to be small in {}: further runs can.",
                    runs == 1 ? "One run" : "So few runs", runs == 1 ? "tell" : "surely tell",
                    runs == 1 ? "this one" : "these"));
  }
  return all;
}

std::vector<std::string> CheckedLogs::factor_sentences() const {
  const Judgement& j = analysis.judgement;
  if (!j.lost.runs.empty()) {
    return {fmt::format("No factor on P is given: it would be that of the {} that left P behind ({}).",
                        j.lost.runs.size() == 1 ? "run" : "runs", names_of(j.lost))};
  }
  if (j.word.no_factor && !j.scale_covariance.reason.empty())
    return {fmt::format("No factor on P is given: {}.", j.scale_covariance.reason)};
  std::vector<std::string> sentences = calibration_sentences(calibration);
  const std::int64_t rows = analysis.evidence.whole_runs.nees_values.count;
  if (!sentences.empty() && !calibration.parts.empty() && calibration.rows < rows) {
    const auto behind_factors = sentences.begin() + (calibration.unit_count > 0 ? 1 : 0);
    sentences.insert(
        behind_factors,
        fmt::format("These factors are of the {} rows that have all states, of {}.", calibration.rows, rows));
  }
  return sentences;
}

namespace {

/// A block of errors that are all zero is a mistake of the log, unless another block is wrong as well.
void tell_zero_blocks(const Judgement& judgement, CheckedLogs& logs) {
  std::vector<std::string> zero;
  bool others_wrong = false;
  for (const BlockVerdict& block : judgement.blocks) {
    if (block.verdict.count == 0 || !(block.verdict.expected > 0.0)) continue;
    if (block.verdict.mean == 0.0)
      zero.push_back(block.name);
    else
      others_wrong = others_wrong || is_inconsistent(block.verdict.verdict);
  }
  if (zero.empty()) return;
  (others_wrong ? logs.remarks : logs.mistakes)
      .push_back(
          fmt::format("Every error of {} is exactly zero: is that part of the truth a copy of the estimate?",
                      first_items(zero, 6)));
}

/// S = H P Hᵀ + R is no smaller than R, so that tr(S⁻¹ R) is at most m.
std::vector<std::string> larger_noise_than_s(const Evidence& evidence) {
  constexpr double kRounding = 1e-6;
  std::vector<std::string> said;
  for (const SensorSums& of : evidence.sensors) {
    if (of.measurement_share.count == 0 || !(of.measurement_share.mean > 1.0 + kRounding)) continue;
    said.push_back(fmt::format(
        "R{} is larger than S, by tr(S⁻¹ R)/m = {} on average, and S is H P Hᵀ + R: look whether they are "
        "exchanged, or of other units or components",
        of.sensor.name.empty() ? "" : " of " + of.sensor.name, number_text(of.measurement_share.mean, 3)));
  }
  return said;
}

}  // namespace

void judge_collected(Evidence evidence, CalibrationUnits calibration, JudgementContext context,
                     InputMistakes mistakes, CheckedLogs& logs) {
  std::ranges::move(larger_noise_than_s(evidence), std::back_inserter(logs.remarks));
  double effective_rows = 0.0;
  for (const CalibrationRun& run : calibration.runs)
    effective_rows += static_cast<double>(run.whole.rows) / run.correlation_time;
  if (evidence.law.errors_stand() || evidence.law.stretches.stand(effective_rows))
    calibration.keep_whole_runs();
  calibration.memory = memory_in_rows(evidence);
  context.memory = calibration.memory;
  logs.calibration = judge_calibration(calibration, context.confidence);
  context.claimed_sigma = logs.calibration.claimed_sigma;
  logs.analysis = analyse_logs(std::move(evidence), context);
  Judgement& judgement = logs.analysis.judgement;
  logs.units = unit_factors(calibration);
  if (logs.calibration.unit_count > 0 && judgement.nees.factor.reason.empty())
    logs.calibration.whole.factor = judgement.nees.factor;
  logs.mistakes = mistakes_told(std::move(mistakes.said), judgement);
  if (judgement.nees.count > 0 && judgement.nees.mean == 0.0)
    logs.mistakes.emplace_back("Every error is exactly zero: is the truth a copy of the estimate?");
  else
    tell_zero_blocks(judgement, logs);
  if (const Moments& nees = logs.analysis.evidence.whole_runs.nees_values; are_of_one_size(nees)) {
    logs.mistakes.push_back(fmt::format(
        "Every NEES is {}: errors of one size are no sample of a covariance; was one error drawn for all {} "
        "rows, or are they a bias without noise?",
        number_text(nees.mean, 4), nees.count));
  }
  if (mistakes.swapped_axes) {
    leave_swapped_open(judgement);
    logs.calibration = {};
    logs.units = {};
  } else if (!logs.mistakes.empty()) {
    drop_explained_causes(judgement);
  }
}

std::vector<std::string> mistakes_told(Said said, const Judgement& judgement) {
  const bool others_fit = !judgement.lost.runs.empty() && judgement.lost.others_are_right();
  const bool fits =
      others_fit || (judgement.nees.verdict == Verdict::consistent && !any_block_is_wrong(judgement));
  std::vector<std::string> told = fits ? std::vector<std::string>{} : std::move(said.misfits);
  std::ranges::move(said.others, std::back_inserter(told));
  return told;
}

void drop_explained_causes(Judgement& judgement) {
  const bool innovations_fit = !is_inconsistent(judgement.nis.verdict);
  std::erase_if(judgement.causes, [&](const CauseFound& found) {
    return told_by_errors(found.cause) || (innovations_fit && told_by_size(found.cause));
  });
  refuse_factor("a mistake of what was logged is named", judgement);
}

Document log_document(CheckedLogs given) {
  const auto shared = std::make_shared<const CheckedLogs>(std::move(given));
  const CheckedLogs& logs = *shared;
  const LogAnalysis& a = logs.analysis;
  const std::string name = plain_name(logs.name, "logs");
  Document document(logs.name, logs.files > 0 ? "Consistency of a filter from its logs"
                                              : "Consistency of a filter from its runs");
  document.answer = {verdict_cell(a.judgement.word.verdict).tone, log_answer(logs)};
  document.json = [shared] { return log_json(*shared); };
  document.brief.emplace_back(log_table(logs));

  if (logs.gate) {
    document.callout(!logs.gate->worse.empty() ? CellTone::alarm
                     : logs.gate->compares()   ? CellTone::good
                                               : CellTone::caution,
                     gate_sentence(*logs.gate));
  }
  document.section("Verdicts");
  ReportTable verdicts = log_verdicts(logs, a.judgement.blocks.size());
  verdicts.title = "One row for the whole state, the innovations, and each block of states";
  document.table(std::move(verdicts));
  add_rejected(document, a.evidence);
  add_wrongly_certain(document, a.evidence);
  if (std::vector<std::string> advice = logs.advice(); !advice.empty()) {
    document.section("What to do");
    document.bullets(std::move(advice));
  }
  if (std::vector<std::string> mends = logs.factor_sentences(); !mends.empty()) {
    document.section("Factors on P");
    document.bullets(std::move(mends));
  }
  const auto with_charts =
      std::ranges::find_if(logs.poses, [](const LogPoses& log) { return !log.charts.charts.empty(); });
  if (with_charts != logs.poses.end()) {
    document.section("Charts");
    document.table(charts_table(*with_charts));
  }
  std::vector<Figure> figures = log_figures(name, logs);
  std::erase_if(figures, [](const Figure& figure) { return figure.panels.empty(); });
  if (!figures.empty()) document.section("Figures");
  document.figures(std::move(figures));
  if (!logs.calibration.bins.empty()) {
    document.section("Where P lies");
    document.folded("Errors by claimed σ",
                    [&] { document.table(sigma_table(logs.calibration, a.evidence.layout)); });
  }
  add_tests(document, logs, name);
  document.link("every step as CSV", name + ".csv");
  document.file(name + ".csv", [shared](const auto& target) { write_log_csv(target, shared->analysis); });
  return document;
}

}  // namespace credence::internal
