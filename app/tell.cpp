#include "app/tell.h"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <string>

#include "app/say.h"
#include "app/terminal_text.h"
#include "app/this_command.h"
#include "reports/render/latex_page.h"
#include "reports/render/utf8_text.h"
#include "reports/render/write_document.h"

namespace credence::internal {

void print(const Document& document, const CommonOptions& options) {
  fmt::print("{}", options.format == "json"    ? printable_json(document.json()) + "\n"
                   : options.format == "latex" ? latex_page(document)
                                               : terminal_text(document));
  std::fflush(stdout);  // a page may take long; a full disk is told of at the end (main)
}

void write_report(const Document& document, const CommonOptions& options, const std::string& command) {
  if (options.out.empty()) return;
  write_document(document, options.report_folder(),
                 make_provenance(command.empty() ? this_command() : command));
  if (!options.quiet)
    say(fmt::format("Report: {}", (std::filesystem::path(options.out) / "index.html").string()));
}

void tell(const Document& document, const CommonOptions& options) {
  print(document, options);
  write_report(document, options);
}

}  // namespace credence::internal
