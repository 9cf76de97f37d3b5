#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>

#include "app/commands.h"
#include "app/common_options.h"
#include "app/this_command.h"
#include "core/append_item.h"
#include "reports/document/report_index.h"
#include "reports/render/utf8_text.h"

namespace credence::internal {

void add_index_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("index", "one page above all reports of a folder");
  auto folder = std::make_shared<std::string>();
  command->add_option("folder", *folder, "folder with reports in it or below; gets reports.html")->required();
  command->footer("Examples:\n  credence run planar_loop --out out/loop && credence index out");
  command->callback([folder] {
    const std::size_t reports = write_report_index(*folder, make_provenance(this_command()));
    fmt::print("{}: {}\n", counted(reports, "report"),
               printable_line((std::filesystem::path(*folder) / "reports.html").string()));
    throw ExitStatus{kDone};
  });
}

}  // namespace credence::internal
