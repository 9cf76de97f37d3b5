#include "app/tell_report.h"

#include <fmt/format.h>

#include <filesystem>

#include "app/say.h"

namespace credence {

void tell_report(const CommonOptions& options, std::span<const std::string> problems) {
  for (const std::string& problem : problems) say(fmt::format("credence: figure not drawn: {}", problem));
  if (options.quiet) return;
  say(fmt::format("Report: {}", (std::filesystem::path(options.out) / "index.html").string()));
}

}  // namespace credence
