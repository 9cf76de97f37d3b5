#include <filesystem>
#include <stdexcept>

#include "app/data_set_folder.h"
#include "app/interrupt.h"
#include "app/progress.h"
#include "app/tell.h"
#include "app/tune_command.h"
#include "datasets/logs/number_field.h"
#include "datasets/replay/replay_tuning.h"
#include "reports/document/tuning/replay_tune_report.h"

namespace credence::internal {
namespace {

std::vector<ReplayedLog> replayed_logs(const TuneOptions& options) {
  std::vector<ReplayedLog> logs;
  if (options.inputs.front() == "carpark") {
    logs.push_back(replayed_log(read_carpark(carpark_folder(options.data, options.robots)),
                                with_overrides(carpark_settings(), options.settings)));
    return logs;
  }
  const auto folders = data_set_folders(options.data, "mrclam7");
  for (const std::filesystem::path& folder : folders) {
    for (const int robot : options.robots.empty() ? mrclam_robots(folder) : options.robots) {
      logs.push_back(
          replayed_log(read_mrclam(folder, robot), with_overrides(mrclam_settings(robot), options.settings)));
      if (folders.size() > 1) logs.back().name += " of " + folder.filename().string();
    }
  }
  return logs;
}

std::vector<std::string> free_keys(const TuneOptions& options, const ReplaySettings& settings) {
  if (options.free.empty()) return replay_noise_keys(settings);
  std::vector<std::string> keys;
  for (const std::string_view key : comma_fields(options.free)) keys.emplace_back(key);
  return keys;
}

}  // namespace

int tune_data_set(const TuneOptions& options) {
  if (!options.write.empty() || options.runs || options.steps || options.seed) {
    throw std::invalid_argument(
        "a data set is no scenario: --write, --runs, --steps and --seed have no meaning for it");
  }
  const std::atomic<bool>& stop = catch_interrupt();
  const std::vector<ReplayedLog> logs = replayed_logs(options);
  if (logs.empty()) throw std::invalid_argument("--data: there is no robot's log in it");
  ProgressDisplay display("tune", options.quiet, "replays");
  ReplayScore score(logs, free_keys(options, logs.front().settings), options.threads, &stop);
  score.watch([&](double plays) { display.show({.runs_in_hand = plays}); });
  const ReplayTuning tuning = tune_replays(logs, score, kTuneConfidence);
  tell(replay_tune_document(tuning, score), options);
  const bool inconsistent = !tuning.left_out.empty() && is_inconsistent(left_out_verdict(tuning));
  return options.fail_on_inconsistent && inconsistent ? kInconsistent : kDone;
}

}  // namespace credence::internal
