#include "app/tell_report.h"

#include <fmt/format.h>

#include <filesystem>

namespace credence {

void tell_report(const CommonOptions& options) {
  if (options.quiet) return;
  fmt::print(stderr, "Report: {}\n", (std::filesystem::path(options.out) / "index.html").string());
}

}  // namespace credence
