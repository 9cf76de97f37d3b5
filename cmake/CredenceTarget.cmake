# What every target of the project shares: the language, the warnings, and the arithmetic.

add_library(credence_options INTERFACE)
add_library(Credence::options ALIAS credence_options)
set_target_properties(credence_options PROPERTIES EXPORT_NAME options)
target_compile_features(credence_options INTERFACE cxx_std_20)
# Contraction would make the bits of a result depend on the instruction set and the optimiser.
target_compile_options(credence_options INTERFACE $<$<CXX_COMPILER_ID:GNU,Clang>:-ffp-contract=off>)
# Alignment is the same for every instruction set, so that a program with -march=native can link the library
# (core/eigen_alignment.h).
target_compile_definitions(credence_options INTERFACE EIGEN_DONT_PARALLELIZE EIGEN_MAX_ALIGN_BYTES=64
                                                      EIGEN_MAX_STATIC_ALIGN_BYTES=16 EIGEN_MALLOC_ALREADY_ALIGNED=0)

set(CREDENCE_WARNINGS -Wall -Wextra -Wpedantic -Wconversion -Wshadow)

include(${CMAKE_CURRENT_LIST_DIR}/CredenceCompileTime.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/CredenceEmbed.cmake)

# credence_objects(target objects source ...): sources of a static target that are compiled in a way of their own.
function(credence_objects target objects)
  add_library(${objects} OBJECT ${ARGN})
  set_target_properties(${objects} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  target_compile_options(${objects} PRIVATE ${CREDENCE_WARNINGS})
  target_include_directories(${objects} PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${objects} PRIVATE credence_options)
  target_sources(${target} PRIVATE $<TARGET_OBJECTS:${objects}>)
endfunction()

# credence_library(core PUBLIC ... PRIVATE ... LITTLE subfolder ...): the static target of one folder, from all its
# sources; those of the subfolders behind LITTLE compute little and are optimised so.
function(credence_library folder)
  cmake_parse_arguments(ARG "" "" "PUBLIC;PRIVATE;LITTLE" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  set(kernels ${sources})
  list(FILTER kernels INCLUDE REGEX "_simd\\.cpp$")
  list(FILTER sources EXCLUDE REGEX "_simd\\.cpp$")
  set(little)
  foreach(subfolder IN LISTS ARG_LITTLE)
    file(GLOB_RECURSE of_subfolder CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${subfolder}/*.cpp)
    list(APPEND little ${of_subfolder})
  endforeach()
  if(little)
    list(REMOVE_ITEM sources ${little})
  endif()
  set(target credence_${folder})
  add_library(${target} STATIC ${sources})
  add_library(Credence::${folder} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${folder} POSITION_INDEPENDENT_CODE ON)
  target_include_directories(${target} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
                                              $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/credence>)
  target_compile_options(${target} PRIVATE ${CREDENCE_WARNINGS})
  target_link_libraries(${target} PUBLIC credence_options ${ARG_PUBLIC} PRIVATE ${ARG_PRIVATE})
  credence_use_precompiled(${target} library)
  credence_units(${target} 32)
  if(little)
    credence_objects(${target} ${target}_little ${little})
    target_link_libraries(${target}_little PRIVATE ${ARG_PUBLIC} ${ARG_PRIVATE})
    credence_use_precompiled(${target}_little library)
    credence_units(${target}_little 40)
    credence_optimised_little(${target}_little)
  endif()

  # Kernels are one source each, compiled once for each instruction set and chosen at run time
  # (core/simd/kernel_set.h). The same names mean another set in each, hence no common unit, and no common header.
  if(NOT kernels)
    return()
  endif()
  set(sets scalar)
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    list(APPEND sets avx2 avx512)
  endif()
  set(flags_avx2 -mavx2 -mfma)
  set(flags_avx512 -mavx512f -mavx512bw -mavx512dq -mavx512vl -mfma -mprefer-vector-width=512)
  foreach(set IN LISTS sets)
    string(TOUPPER ${set} upper)
    set(objects ${target}_${set})
    credence_objects(${target} ${objects} ${kernels})
    set_target_properties(${objects} PROPERTIES UNITY_BUILD OFF)
    target_compile_definitions(${objects} PRIVATE CREDENCE_SET_${upper})
    target_compile_options(${objects} PRIVATE ${flags_${set}})
  endforeach()
endfunction()
