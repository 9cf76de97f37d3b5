#include "app/tell_report.h"

#include <fmt/format.h>

#include <filesystem>

namespace credence {

void tell_report(const CommonOptions& options, std::span<const std::string> problems) {
  for (const std::string& problem : problems) fmt::print(stderr, "credence: figure not drawn: {}\n", problem);
  if (options.quiet) return;
  fmt::print(stderr, "Report: {}\n", (std::filesystem::path(options.out) / "index.html").string());
}

}  // namespace credence
