#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "analysis/claims.h"
#include "app/commands.h"
#include "app/common_options.h"
#include "reports/claims_report.h"

namespace credence {
namespace {

int claims(const CommonOptions& options) {
  const std::vector<Claim> all = monobot_claims();
  fmt::print("{}", options.format == "json" ? claims_json(all) + "\n" : claims_text(all));
  if (options.out.empty()) return kDone;
  write_claims_report(options.out, all);
  if (!options.quiet) {
    fmt::print(stderr, "Report: {}\n", (std::filesystem::path(options.out) / "index.html").string());
  }
  return kDone;
}

}  // namespace

void add_claims_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("claims", "every claim of the paper with what is measured of it");
  auto options = std::make_shared<CommonOptions>();
  add_output_options(*command, *options);
  static constexpr const char* kExamples[] = {"credence claims", "credence claims --format json",
                                              "credence claims --out out/claims"};
  command->footer(examples(kExamples));
  command->callback([options] { throw ExitStatus{claims(*options)}; });
}

}  // namespace credence
