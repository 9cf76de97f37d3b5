# credence_embed(target file ...): the files, by their paths within the project, as text in the program
# (app/embedded_files.h).
function(credence_embed target)
  set(entries "")
  foreach(file ${ARGN})
    file(READ ${PROJECT_SOURCE_DIR}/${file} text)
    string(APPEND entries "    {R\"credence(${file})credence\", R\"credence(${text})credence\"},\n")
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${file})
  endforeach()
  set(source ${PROJECT_BINARY_DIR}/generated/embedded_files.cpp)
  file(CONFIGURE OUTPUT ${source} @ONLY CONTENT [[
#include "app/embedded_files.h"

namespace credence::internal {
namespace {

constexpr EmbeddedFile kFiles[] = {
@entries@};

}  // namespace

std::span<const EmbeddedFile> embedded_files() { return kFiles; }

}  // namespace credence::internal
]])
  target_sources(${target} PRIVATE ${source})
  set_source_files_properties(${source} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()
