#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iterator>
#include <map>
#include <memory>
#include <stdexcept>
#include <utility>

#include "app/commands.h"
#include "app/common_options.h"
#include "app/standard_input.h"
#include "app/study_runner.h"
#include "app/tell.h"
#include "reports/document/study/comparison_report.h"
#include "reports/document/sweep/sweep_comparison.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

struct CompareOptions : CommonOptions {
  std::vector<std::string> results;
  double confidence = 0.95;
};

/// Two results of one name, as of one scenario with other settings, are told apart by where they lie.
void tell_apart(std::vector<ComparedStudy>& studies, const std::vector<std::string>& places) {
  std::map<std::pair<std::string, std::string>, int> times;  // by name and configuration
  for (const ComparedStudy& study : studies) ++times[{study.name, study.cell}];
  for (std::size_t i = 0; i < studies.size(); ++i) {
    ComparedStudy& study = studies[i];
    if (times[{study.name, study.cell}] > 1) study.name = fmt::format("{} ({})", study.name, places[i]);
  }
}

std::vector<ComparedStudy> read_folder(const std::string& folder, const CompareOptions& options,
                                       std::vector<std::string>& places) {
  std::vector<ComparedStudy> studies;
  const std::size_t before = places.size();
  for (const fs::path& directory : study_directories(folder)) {
    StoredStudy study = read_study(directory);
    require_runs(study);
    if (study.is_sweep()) {
      const SweepAnalysis sweep = analyse_sweep(study.plan, analyse(study));
      if (!sweep.rank_map.empty()) {
        throw std::invalid_argument(
            fmt::format("{}: is a map of ranks, whose cells are counted and not compared one by one",
                        directory.string()));
      }
      std::ranges::move(compared(sweep), std::back_inserter(studies));
      places.resize(studies.size() + before, directory.string());
      continue;
    }
    const std::optional<StudyAnalysis> analysis = judge(study, options);
    if (!analysis) throw ExitStatus{kInterrupted};
    studies.push_back(compared(*analysis));
    places.push_back(directory.string());
  }
  return studies;
}

/// A run has no swept values by which a configuration of a sweep could stand beside it.
void require_sweeps(const std::vector<ComparedStudy>& studies, const std::vector<std::string>& results) {
  const auto run = std::ranges::find_if(studies, [](const auto& study) { return study.cell.empty(); });
  if (run == studies.end()) return;
  const auto sweep = std::ranges::find_if(studies, [](const auto& study) { return !study.cell.empty(); });
  throw std::invalid_argument(fmt::format(
      "compare: {} is a sweep and {} is none: compare sweeps with sweeps, and runs with runs",
      results[static_cast<std::size_t>(sweep->of_sweep)], results[static_cast<std::size_t>(run->of_sweep)]));
}

int compare(const CompareOptions& options) {
  std::vector<ComparedStudy> studies;
  std::vector<std::string> places;
  for (const std::string& result : options.results) {
    std::vector<ComparedStudy> these =
        fs::is_directory(result)
            ? read_folder(result, options, places)
            : compared_documents(result, text_of_file(result, result + ": no such folder or document"));
    places.resize(studies.size() + these.size(), result);
    for (ComparedStudy& study : these) study.of_sweep = &result - options.results.data();
    std::ranges::move(these, std::back_inserter(studies));
  }
  if (studies.size() < 2 || (options.results.size() < 2 && are_of_sweeps(studies)))
    throw std::invalid_argument("compare: takes two results or more");
  if (are_of_sweeps(studies)) require_sweeps(studies, options.results);
  tell_apart(studies, places);
  tell(are_of_sweeps(studies) ? sweep_comparison_document(studies, options.confidence)
                              : comparison_document(studies, options.confidence),
       options);
  return kDone;
}

}  // namespace

void add_compare_command(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("compare", "results side by side: verdicts, factors on P, paired differences");
  auto options = std::make_shared<CompareOptions>();
  command
      ->add_option("results", options->results,
                   "folders of run or sweep --out, and documents of run, sweep or check --format json; the "
                   "first is the reference")
      ->required();
  command->add_option("--confidence", options->confidence, "of the interval of a paired difference")
      ->check(CLI::Range(kLeastConfidence, kMostConfidence))
      ->capture_default_str();
  add_threads_option(*command, options->threads);
  add_output_options(*command, *options);
  static constexpr const char* kExamples[] = {
      ("credence run planar_loop --out out/a && "
       "credence run planar_loop --set filter.process_scale=2.0 --out out/b"),
      "credence compare out/a out/b --out out/compared",
      "credence check A.csv --format json > a.json    # and B.csv > b.json; then",
      "credence compare a.json b.json",
      ("credence sweep mistuned_sweep --out out/c && "
       "credence sweep mistuned_sweep --set filter.process_scale=2.0 --out out/d"),
      "credence compare out/c out/d    # configuration by configuration"};
  command->footer(examples(kExamples));
  command->callback([options] { throw ExitStatus{compare(*options)}; });
}

}  // namespace credence::internal
