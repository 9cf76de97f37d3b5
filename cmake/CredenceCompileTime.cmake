# What many sources have in common is compiled once: precompiled headers, and units of several sources.

# A compiler cache serves sources one by one, and is better off with neither.
if(CMAKE_CXX_COMPILER_LAUNCHER MATCHES "ccache")
  set(CMAKE_DISABLE_PRECOMPILE_HEADERS ON)
  set(CREDENCE_UNITS OFF)
else()
  set(CREDENCE_UNITS ON)
endif()

# credence_units(target size): the sources of a target in units of that many. It pays most where a library's header costs
# more than the sources (CLI11 5 s in each, documents of nlohmann_json 6 s); of Eigen's templates a unit has those that
# its sources share once: clang takes a quarter less for units of sixteen than for single sources, and another sixth less
# for units of 32 (2.4 GB the largest); of tests units of twelve pay. g++ gets units of eight at most: of sixteen sources
# they take 2.6 GB, and no less time.
function(credence_units target size)
  if(NOT CMAKE_CXX_COMPILER_ID MATCHES "Clang")
    math(EXPR size "${size} / 2")
    if(size GREATER 8)
      set(size 8)
    endif()
  endif()
  if(CREDENCE_UNITS AND NOT CMAKE_UNITY_BUILD)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${size})
  endif()
endfunction()

# credence_optimised_little(target): of a target that computes little itself; a sixth of its compilation, and of clang,
# which inlines at -O1 nearly as at -O3 unless told otherwise, a third. What computes much is a ninth slower at -O1 alone.
function(credence_optimised_little target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
    target_compile_options(${target} PRIVATE "SHELL:$<$<CONFIG:Release>:-mllvm -inline-threshold=25>"
                                             "SHELL:$<$<CONFIG:Release>:-mllvm -inlinehint-threshold=25>")
  endif()
endfunction()

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
