#include <fmt/format.h>

#include <stdexcept>

#include "analysis/tuning/tune_scenario.h"
#include "app/interrupt.h"
#include "app/naming_file.h"
#include "app/progress.h"
#include "app/say.h"
#include "app/scenario_files.h"
#include "app/tell_report.h"
#include "app/terminal_text.h"
#include "app/this_command.h"
#include "app/tune_command.h"
#include "reports/document/tune_report.h"
#include "reports/document/tuning_tables.h"
#include "reports/render/atomic_file.h"
#include "reports/render/utf8_text.h"

namespace credence {
namespace {

void print_tuning(const ScenarioTuning& tuning) {
  fmt::print("{}.\n\n{}\n{}\n{}", printable_line(tune_answer(tuning).text),
             terminal_text(tune_forecast_table(tuning.tuning.forecast)), terminal_text(tune_table(tuning)),
             terminal_text(tune_gain_table(tuning)));
  for (const std::string& sentence : tune_sentences(tuning)) fmt::print("{}\n", printable_line(sentence));
}

}  // namespace

int tune_scenario_file(const TuneOptions& options) {
  ProgressDisplay search("tune", options.quiet, "plays of the runs"), fresh("fresh noise", options.quiet);
  TuneRequest request;
  if (!options.free.empty()) request.free = parse_free_noise(options.free);
  request.watch = [&](std::int64_t plays) { search.show({.runs_done = plays}); };
  request.progress = [&](const StudyProgress& progress) { fresh.show(progress); };
  request.threads = options.threads;
  request.stop = &catch_interrupt();
  const auto tuning = naming_file(options.inputs.front(), [&] {
    return tune_scenario(open_one_scenario(options.inputs.front(), options.overrides()), request);
  });
  if (!tuning) {
    say("credence: interrupted; nothing is kept of a tuning that is not done");
    return kInterrupted;
  }
  if (options.format == "json") {
    fmt::print("{}\n", tune_json(*tuning));
  } else {
    print_tuning(*tuning);
  }
  if (!options.out.empty()) {
    write_tune_report(options.report_folder(), *tuning, make_provenance(this_command()));
    tell_report(options);
  }
  if (!options.write.empty()) {
    if (!tuning->tuning.anything_known()) {
      throw std::invalid_argument(
          fmt::format("--write {}: nothing could be told, so there is no tuned scenario", options.write));
    }
    write_file(options.write, tuned_toml(*tuning));
  }
  const bool inconsistent = tuning->held_out && is_inconsistent(overall_verdict(tuning->held_out->after));
  return options.fail_on_inconsistent && inconsistent ? kInconsistent : kDone;
}

}  // namespace credence
