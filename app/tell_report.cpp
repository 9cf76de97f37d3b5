#include "app/tell_report.h"

#include <fmt/format.h>

#include <filesystem>

#include "app/say.h"

namespace credence {

void tell_report(const CommonOptions& options) {
  if (options.quiet) return;
  say(fmt::format("Report: {}", (std::filesystem::path(options.out) / "index.html").string()));
}

}  // namespace credence
