#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "analysis/evidence/sweep_analysis.h"
#include "app/commands.h"
#include "app/common_options.h"
#include "app/interrupt.h"
#include "app/say.h"
#include "app/stored_study.h"
#include "app/tell_report.h"
#include "app/terminal_text.h"
#include "app/this_command.h"
#include "reports/document/study_json.h"
#include "reports/document/study_report.h"
#include "reports/document/study_table.h"
#include "reports/document/sweep_report.h"
#include "reports/render/utf8_text.h"

namespace credence {
namespace {

struct StoredOptions : CommonOptions {
  std::string directory;
};

/// "640 of 5000 runs are stored, and process 4711 goes on with them."
std::string progress_sentence(const StoredStudy& study) {
  const std::int64_t runs = study.runs(), asked = study.runs_asked();
  std::string text = fmt::format("{}: {} of {} runs are stored ({:.1f} %)", printable_line(study.plan.name),
                                 runs, asked, 100.0 * static_cast<double>(runs) / static_cast<double>(asked));
  if (study.writer) text += fmt::format("; process {} goes on with them", *study.writer);
  return text + fmt::format("; made by version {}.", printable_line(study.tool_version));
}

SweepAnalysis analyse_stored_sweep(StoredStudy& study) {
  std::vector<StudyAnalysis> analyses = analyse(study);
  return analyse_sweep(study.plan, std::move(analyses));
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

int show(const StoredOptions& options) {
  std::vector<StoredStudy> studies = read_all(options.directory);
  const bool sweep = is_sweep(studies);
  std::string progress;
  for (const StoredStudy& study : studies) progress += progress_sentence(study) + "\n";
  std::vector<StudyAnalysis> analyses;
  if (!sweep) {
    for (StoredStudy& study : studies) {
      if (std::optional<StudyAnalysis> a = judge(study, options)) analyses.push_back(std::move(*a));
    }
    if (catch_interrupt().load()) return kInterrupted;
  } else if (studies.front().runs() > 0) {
    const SweepAnalysis analysis = analyse_stored_sweep(studies.front());
    if (options.format == "json") {
      fmt::print("{}\n", sweep_json(analysis));
      return kDone;
    }
    for (const ReportTable& table : sweep_tables(analysis)) fmt::print("{}", terminal_text(table));
  }
  if (options.format == "json") {
    fmt::print("{}\n", analyses.size() == 1 ? study_json(analyses.front()) : studies_json(analyses));
    return kDone;
  }
  for (StudyAnalysis& a : analyses) a.complete = true;  // how much there is, is said below
  if (!analyses.empty()) fmt::print("{}", terminal_text(verdict_table(analyses)));
  fmt::print("\n{}", progress);
  return kDone;
}

std::vector<ReportedStudy> reported(std::vector<StoredStudy>& studies, const StoredOptions& options) {
  std::vector<ReportedStudy> all;
  for (StoredStudy& study : studies) {
    if (std::optional<StudyAnalysis> a = judge(study, options)) {
      all.push_back({std::move(*a), study.configurations.front().experiment->trace(0)});
    }
  }
  return all;
}

int report(StoredOptions options) {
  std::vector<StoredStudy> studies = read_all(options.directory);
  if (options.out.empty()) options.out = options.directory;
  for (const StoredStudy& study : studies) require_runs(study);
  if (is_sweep(studies)) {
    write_sweep_report(options.report_folder(), analyse_stored_sweep(studies.front()),
                       make_provenance(this_command()));
  } else {
    const std::vector<ReportedStudy> all = reported(studies, options);
    if (catch_interrupt().load()) return kInterrupted;
    write_study_report(options.report_folder(), report_title(all), all, make_provenance(this_command()));
  }
  tell_report(options);
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
      ->type_name("DIR");
  add_figures_option(*command, *options);
  add_threads_option(*command, options->threads);
  command->add_flag("--quiet", options->quiet, "do not say where the report is");
  static constexpr const char* kExamples[] = {
      "credence run figure1_two_landmarks --out out/one && credence report out/one",
      "credence report out/one --figures pgf,png,one-column    # each figure and panel, in out/one/figures",
      "credence report out/sweep --out out/so_far    # of a sweep that is still running"};
  command->footer(examples(kExamples));
  command->callback([options] { throw ExitStatus{report(*options)}; });
}

}  // namespace credence
