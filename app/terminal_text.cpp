#include "app/terminal_text.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdlib>
#include <string_view>

#include "reports/render/text_table.h"

namespace credence {
namespace {

/// The wish of https://no-color.org, and of terminals that know no colours.
bool wants_colour() {
  const char* const no_colour = std::getenv("NO_COLOR");
  if (no_colour != nullptr && *no_colour != '\0') return false;
  const char* const terminal = std::getenv("TERM");
  return terminal == nullptr || std::string_view(terminal) != "dumb";
}

}  // namespace

std::size_t terminal_width(int descriptor) {
  winsize size{};
  if (isatty(descriptor) != 1 || ioctl(descriptor, TIOCGWINSZ, &size) != 0) return 0;
  return size.ws_col;
}

std::string terminal_text(const ReportTable& table) {
  const bool terminal = isatty(STDOUT_FILENO) == 1;
  return text_table(table, terminal && wants_colour(), terminal_width(STDOUT_FILENO));
}

}  // namespace credence
