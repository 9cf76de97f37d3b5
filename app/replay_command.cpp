
#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>

#include "app/commands.h"
#include "app/common_options.h"
#include "app/data_set_folder.h"
#include "app/interrupt.h"
#include "app/progress.h"
#include "app/say.h"
#include "app/tell.h"
#include "datasets/replay/carpark_replay.h"
#include "datasets/replay/carpark_study.h"
#include "datasets/replay/mrclam_replay.h"
#include "reports/document/replay/carpark_study_report.h"
#include "reports/document/replay/replay_report.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

struct ReplayOptions : CommonOptions {
  std::string dataset;
  std::vector<std::string> data;
  std::vector<int> robots;  ///< empty: the first
  bool variants = false;
};

ReportedReplay replay_carpark_run(const ReplayOptions& options) {
  const ReplaySettings settings = with_overrides(carpark_settings(), options.settings);
  return {replay_carpark(read_carpark(carpark_folder(options.data, options.robots)), settings), {}};
}

/// One robot, and once more with Jacobians at the truth unless that is what was asked for.
ReportedReplay replay_robot(const ReplayOptions& options, const fs::path& folder, int robot) {
  ReplaySettings settings = with_overrides(mrclam_settings(robot), options.settings);
  const MrclamLog log = read_mrclam(folder, robot);
  ReportedReplay replay{replay_mrclam(log, settings), {}};
  const ReplayFilterSettings& filter = settings.filter;
  if (filter.estimator == "ekf" && filter.jacobians == ReplayJacobians::estimate &&
      filter.association == ReplayAssociation::survey) {
    settings.filter.jacobians = ReplayJacobians::truth;
    replay.ideal = replay_mrclam(log, settings);
  }
  return replay;
}

/// All robots of all folders, each an independent run.
std::vector<ReportedReplay> replay_all(const ReplayOptions& options) {
  if (options.dataset == "carpark") return {replay_carpark_run(options)};
  std::vector<ReportedReplay> replays;
  const std::vector<fs::path> folders = data_set_folders(options.data, "mrclam7");
  for (const fs::path& folder : folders) {
    for (const int robot : options.robots.empty() ? std::vector{1} : options.robots) {
      replays.push_back(replay_robot(options, folder, robot));
      if (folders.size() > 1) replays.back().result.run += " of " + folder.filename().string();
    }
  }
  return replays;
}

/// All variants of the car park run; nothing is printed of a study that was interrupted.
int study_variants(const ReplayOptions& options) {
  if (options.dataset != "carpark") throw std::invalid_argument("--variants: only of the car park");
  const ReplaySettings settings = with_overrides(carpark_settings(), options.settings);
  const CarparkLog log = read_carpark(carpark_folder(options.data, options.robots));
  CarparkStudyOptions study_options;
  CarparkStudy study;
  {
    ProgressDisplay display("car park", options.quiet);
    study_options.stop = &catch_interrupt();
    study_options.progress = [&](int done, int all) { display.show({.runs_done = done, .runs_total = all}); };
    study = run_carpark_study(log, settings, study_options);
  }
  if (!study.complete) {
    say("credence: replay interrupted, nothing is reported");
    return kInterrupted;
  }
  tell(carpark_study_document(study), options);
  return kDone;
}

int replay(const ReplayOptions& options) {
  if (options.variants) return study_variants(options);
  const std::vector<ReportedReplay> replays = replay_all(options);
  tell(replay_document(replays, judge_replays(replays)), options);
  const bool failed = std::ranges::any_of(replays, [](const auto& r) { return r.result.failed > 0; });
  return failed ? kSomeFailed : kDone;
}

}  // namespace

void add_replay_command(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("replay", "EKF-SLAM on real data: path, map and innovations against what is known");
  auto options = std::make_shared<ReplayOptions>();
  command->add_option("dataset", options->dataset, "which data set")
      ->required()
      ->check(CLI::IsMember({"carpark", "mrclam"}));
  command
      ->add_option("--data", options->data, "folder of the data; mrclam: repeatable; default: CREDENCE_DATA")
      ->type_name("DIR")
      ->allow_extra_args(false);
  command->add_option("--robot", options->robots, "mrclam: which robots' logs, e.g. 1,3")
      ->delimiter(',')
      ->check(CLI::Range(1, 5))
      ->default_str("1");
  add_setting_option(*command, *options);
  command->add_flag("--variants", options->variants,
                    "carpark: Figures 5 to 8, all their variants, independence of P0 and the long horizon");
  add_output_options(*command, *options);
  static constexpr const char* kExamples[] = {
      "credence replay carpark --data DIR",
      "credence replay carpark --data DIR --set filter.inflation=map --out out/map",
      "credence replay carpark --data DIR --variants --out out/carpark",
      "credence replay mrclam --data DIR --robot 1,3 --out out/robots"};
  command->footer(examples(kExamples));
  command->callback([options] { throw ExitStatus{replay(*options)}; });
}

}  // namespace credence::internal
