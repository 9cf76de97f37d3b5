#include <fmt/format.h>

#include <optional>
#include <stdexcept>

#include "analysis/tuning/tune_scenario.h"
#include "app/interrupt.h"
#include "app/naming_file.h"
#include "app/progress.h"
#include "app/scenario_files.h"
#include "app/tell.h"
#include "app/tune_command.h"
#include "core/stop_point.h"
#include "reports/document/tuning/tune_report.h"
#include "reports/render/atomic_file.h"

namespace credence::internal {

int tune_scenario_file(const TuneOptions& options) {
  ProgressDisplay search("tune", options.quiet, "plays of the runs");
  std::optional<ProgressDisplay> fresh;  // its clock begins when these runs do
  TuneRequest request;
  if (!options.free.empty()) request.free = parse_free_noise(options.free);
  request.watch = [&](double plays) { search.show({.runs_in_hand = plays}); };
  request.progress = [&](const StudyProgress& progress) {
    if (!fresh) fresh.emplace("fresh noise", options.quiet);
    fresh->show(progress);
  };
  request.threads = options.threads;
  request.stop = &catch_interrupt();
  auto tuning = naming_file(options.inputs.front(), [&] {
    const Scenario scenario = open_one_scenario(options.inputs.front(), options.overrides());
    tell_of_stop_rule(scenario, "tune");
    return tune_scenario(scenario, request);
  });
  if (!tuning) throw Stopped{};
  const std::string tuned = tuning->tuning.anything_known() ? tuned_toml(*tuning) : "";
  const bool inconsistent = tuning->held_out && is_inconsistent(overall_verdict(tuning->held_out->after));
  if (!options.write.empty() && !tuned.empty())
    write_new_file(options.write, tuned);  // before figures, which take long
  tell(tune_document(std::move(*tuning)), options);
  if (!options.write.empty() && tuned.empty()) {
    throw std::invalid_argument(
        fmt::format("--write {}: nothing could be told, so there is no tuned scenario", options.write));
  }
  return options.fail_on_inconsistent && inconsistent ? kInconsistent : kDone;
}

}  // namespace credence::internal
