# Headers that are parsed once for many sources.

# A compiler cache serves sources one by one, and better without.
if(CMAKE_CXX_COMPILER_LAUNCHER MATCHES "ccache")
  set(CMAKE_DISABLE_PRECOMPILE_HEADERS ON)
endif()

# credence_precompiled(library ...): cmake/precompiled/library.h, compiled with the flags of the named libraries.
function(credence_precompiled header)
  set(target credence_precompiled_${header})
  add_library(${target} OBJECT ${PROJECT_SOURCE_DIR}/cmake/precompiled/unit.cpp)
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR})
  target_compile_options(${target} PRIVATE ${CREDENCE_WARNINGS})
  target_link_libraries(${target} PRIVATE credence_options ${ARGN})
  target_precompile_headers(${target} PRIVATE ${PROJECT_SOURCE_DIR}/cmake/precompiled/${header}.h)
endfunction()

# credence_use_precompiled(core library): the sources of a target start from that header.
function(credence_use_precompiled target header)
  target_precompile_headers(${target} REUSE_FROM credence_precompiled_${header})
endfunction()
