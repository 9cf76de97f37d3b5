# Writes OUTPUT, the source that core/version.h declares, if what it says has changed. Run at every build.
# SOURCE: of the project; VERSION; OUTPUT
set(commit "")
find_package(Git QUIET)
if(Git_FOUND AND EXISTS ${SOURCE}/.git)
  execute_process(COMMAND ${GIT_EXECUTABLE} -C ${SOURCE} describe --always --exclude=* --abbrev=10 --dirty=+
                  OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
file(CONFIGURE OUTPUT ${OUTPUT} @ONLY CONTENT [[
#include "core/version.h"

namespace credence {

std::string_view version() { return "@VERSION@"; }

std::string_view commit() { return "@commit@"; }

std::string version_text() {
  std::string text(version());
  if (!commit().empty()) text.append(" (").append(commit()).append(")");
  return text;
}

}  // namespace credence
]])
