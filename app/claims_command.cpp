#include <CLI/CLI.hpp>
#include <memory>
#include <optional>

#include "analysis/studies/claims.h"
#include "app/commands.h"
#include "app/common_options.h"
#include "app/data_set_folder.h"
#include "app/interrupt.h"
#include "app/progress.h"
#include "app/tell.h"
#include "core/stop_point.h"
#include "datasets/replay/carpark.h"
#include "datasets/replay/carpark_findings.h"
#include "datasets/replay/carpark_study.h"
#include "datasets/replay/replay_settings.h"
#include "reports/document/checks/claims_report.h"

namespace credence::internal {
namespace {

struct ClaimsOptions : CommonOptions {
  std::string data;
};

void append(std::vector<Claim>& all, std::vector<Claim> more) {
  for (Claim& claim : more) all.push_back(std::move(claim));
}

/// The car park's run, where its data are named.
std::optional<CarparkLog> carpark_log(const ClaimsOptions& options) {
  if (options.data.empty()) return std::nullopt;
  return read_carpark(data_set_folder(options.data, "carpark"));
}

/// What the car park's run shows; nothing of a study that was interrupted.
std::vector<Claim> carpark_claims(const std::optional<CarparkLog>& log, const ClaimsOptions& options) {
  if (!log) {
    return {{.id = "carpark",
             .source = "Figures 5 to 8",
             .statement = "the car park's run: covariance, map and path with each kind of decorrelation",
             .measured = "needs the data: --data DIR or CREDENCE_DATA (docs/datasets.md)"}};
  }
  ProgressDisplay display("car park", options.quiet, "replays");
  CarparkStudyOptions study;
  study.stop = &catch_interrupt();
  study.progress = [&](int done, int all) { display.show({.runs_done = done, .runs_total = all}); };
  const CarparkStudy result = run_carpark_study(*log, carpark_settings(), study);
  if (!result.complete) return {};
  std::vector<Claim> claims;
  const auto verdict_of_claim = [](const CarparkFinding& f) {
    if (f.refutes.empty()) return f.holds ? ClaimVerdict::holds : ClaimVerdict::fails;
    return f.holds ? ClaimVerdict::fails : ClaimVerdict::conditional;
  };
  for (const CarparkFinding& f : carpark_findings(result)) {
    claims.push_back({.id = f.id,
                      .source = f.source,
                      .statement = f.refutes.empty() ? f.statement : f.refutes,
                      .measured = f.measured,
                      .long_run = f.meaning,
                      .verdict = verdict_of_claim(f)});
  }
  return claims;
}

/// Of the paper's worlds; what is begun when it is interrupted is dropped.
std::vector<Claim> measured_claims(const ClaimsOptions& options) {
  const StopScope stop(&catch_interrupt());
  const StepDisplay display("claims", options.quiet, "steps of filters");
  std::vector<Claim> claims = monobot_claims();
  append(claims, planar_claims());
  return claims;
}

/// In the order of the paper.
std::vector<Claim> all_claims(const std::optional<CarparkLog>& log, const ClaimsOptions& options) {
  std::vector<Claim> all = measured_claims(options);
  append(all, timing_claims(&catch_interrupt()));
  append(all, carpark_claims(log, options));
  return all;
}

int claims(const ClaimsOptions& options) {
  const std::optional<CarparkLog> log = carpark_log(options);  // before anything is measured
  const std::vector<Claim> all = all_claims(log, options);
  if (catch_interrupt().load()) throw Stopped{};
  tell(claims_document(all), options);
  return kDone;
}

}  // namespace

void add_claims_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("claims", "every claim of the paper with what is measured of it");
  auto options = std::make_shared<ClaimsOptions>();
  add_output_options(*command, *options);
  command
      ->add_option("--data", options->data,
                   "folder of the car-park data, for Figures 5 to 8; default: CREDENCE_DATA")
      ->type_name("DIR")
      ->envname("CREDENCE_DATA");
  static constexpr const char* kExamples[] = {"credence claims", "credence claims --format json",
                                              "credence claims --data DIR --out out/claims"};
  command->footer(examples(kExamples));
  command->callback([options] { throw ExitStatus{claims(*options)}; });
}

}  // namespace credence::internal
