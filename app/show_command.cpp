#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "analysis/evidence/sweep_analysis.h"
#include "app/commands.h"
#include "app/common_options.h"
#include "app/interrupt.h"
#include "app/study_runner.h"
#include "app/tell.h"
#include "reports/document/report_index.h"
#include "reports/document/study/study_json.h"
#include "reports/document/study/study_report.h"
#include "reports/document/sweep/sweep_report.h"

namespace credence::internal {
namespace {

struct StoredOptions : CommonOptions {
  std::string directory;
};

/// "640 of 5000 runs are stored, and process 4711 goes on with them."
std::string progress_sentence(const StoredStudy& study) {
  const RunsBehindGaps behind = runs_behind_gaps(study);
  const std::int64_t runs = study.runs() + behind.count, asked = study.runs_asked();
  std::string text = fmt::format("{}: {} of {} runs are stored ({:.1f} %)", study.plan.name, runs, asked,
                                 100.0 * static_cast<double>(runs) / static_cast<double>(asked));
  if (behind.count > 0) {
    text += fmt::format("; {} of them are not judged, as {} before them are missing", behind.count,
                        missing_text(study, behind));
  }
  if (study.writer) text += fmt::format("; process {} goes on with them", *study.writer);
  return text + fmt::format("; made by {} {}.",
                            study.tool_version.find(',') == std::string::npos ? "version" : "versions",
                            study.tool_version);
}

/// The sweep of a folder alone: it has tables and a report of its own.
bool is_sweep(const std::vector<StoredStudy>& studies) {
  if (studies.size() == 1) return studies.front().is_sweep();
  const auto sweep = std::ranges::find_if(studies, &StoredStudy::is_sweep);
  if (sweep == studies.end()) return false;
  throw std::invalid_argument(
      fmt::format("{}: is a sweep among other studies; name its folder alone", sweep->directory.string()));
}

std::vector<StoredStudy> read_all(const std::string& path) {
  std::vector<StoredStudy> studies;
  for (const std::filesystem::path& directory : study_directories(path))
    studies.push_back(read_study(directory));
  return studies;
}

/// All that have runs; with `traced` one run of each for its page.
std::vector<ReportedStudy> reported(std::vector<StoredStudy>& studies, const StoredOptions& options,
                                    bool traced) {
  std::vector<ReportedStudy> all;
  for (StoredStudy& study : studies) {
    std::optional<StudyAnalysis> analysis = judge(study, options);
    if (!analysis) continue;
    ReportedStudy& each = all.emplace_back(ReportedStudy{.analysis = std::move(*analysis)});
    if (traced)
      each.trace = study.configurations.front().experiment->trace_to_draw(run_to_draw(each.analysis));
  }
  return all;
}

int show(const StoredOptions& options) {
  std::vector<StoredStudy> studies = read_all(options.directory);
  Document document;
  document.json = [] { return studies_json({}); };
  if (!is_sweep(studies)) {
    std::vector<ReportedStudy> all = reported(studies, options, false);
    if (catch_interrupt().load()) return kInterrupted;
    if (options.format != "json") {
      for (ReportedStudy& each : all) each.analysis.complete = true;  // how much there is, is said below
    }
    if (!all.empty()) document = study_document(std::move(all));
  } else if (const StoredStudy& sweep = studies.front(); sweep.runs() > 0) {
    document = sweep_document(analyse_sweep(sweep.plan, analyse(sweep)));
  }
  if (!document.brief.empty()) document.brief.emplace_back("");
  for (const StoredStudy& study : studies) document.brief.emplace_back(progress_sentence(study));
  print(document, options);
  return kDone;
}

int report(StoredOptions options) {
  std::vector<StoredStudy> studies = read_all(options.directory);
  // What made the results, not what draws their page again.
  const std::filesystem::path page = std::filesystem::path(options.directory) / "index.html";
  const std::string command = command_of_page(page);
  if (options.out.empty()) options.out = options.directory;
  for (const StoredStudy& study : studies) require_runs(study);
  if (is_sweep(studies)) {
    const StoredStudy& sweep = studies.front();
    write_report(sweep_document(analyse_sweep(sweep.plan, analyse(sweep))), options, command);
    return kDone;
  }
  std::vector<ReportedStudy> all = reported(studies, options, true);
  if (catch_interrupt().load()) return kInterrupted;
  for (ReportedStudy& each : all) each.description = description_of_page(page, each.analysis.scenario.name);
  write_report(study_document(std::move(all)), options, command);
  return kDone;
}

}  // namespace

void add_show_command(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("show", "what a folder of run or sweep holds, also while it is being written");
  auto options = std::make_shared<StoredOptions>();
  command->add_option("directory", options->directory, "folder of --out")->required();
  add_threads_option(*command, options->threads);
  add_print_options(*command, *options);
  static constexpr const char* kExamples[] = {
      "credence run figure1_two_landmarks --out out/one && credence show out/one",
      "credence sweep mistuned_sweep --out out/sweep & sleep 5; credence show out/sweep"};
  command->footer(examples(kExamples));
  command->callback([options] { throw ExitStatus{show(*options)}; });
}

void add_report_command(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("report", "makes the pages of stored results again, also while they grow");
  auto options = std::make_shared<StoredOptions>();
  command->add_option("directory", options->directory, "folder with stored results")->required();
  command->add_option("--out", options->out, "folder for the pages; default: that of the results")
      ->type_name("DIR")
      ->check(folder_for_page);
  add_figures_option(*command, *options);
  add_threads_option(*command, options->threads);
  command->add_flag("--quiet", options->quiet, "do not say where the report is");
  static constexpr const char* kExamples[] = {
      "credence run figure1_two_landmarks --out out/one && credence report out/one",
      "credence report out/one --figures pgf,png,one-column    # each figure and panel, in out/one/figures",
      "credence sweep mistuned_sweep --out out/sweep & sleep 5; credence report out/sweep --out out/so_far"};
  command->footer(examples(kExamples));
  command->callback([options] { throw ExitStatus{report(*options)}; });
}

}  // namespace credence::internal
