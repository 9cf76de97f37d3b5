# Installs the package into a prefix of its own, and builds the examples against it and runs them, my_filter with every compiler for
# the least and the most that the machine has, and for what lies between with one: the verdict is the same.
# BUILD, SOURCE: of the project; WORK: a folder for all of that; CXX: the compilers, separated by ";"
file(REMOVE_RECURSE ${WORK})
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_VARIABLE output)
  set(output "${output}" PARENT_SCOPE)
  set(code ${code} PARENT_SCOPE)
endfunction()

function(must_run)
  run(${ARGN})
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "${ARGN}: ${code}\n${output}")
  endif()
endfunction()

function(configure example folder compiler flags)
  must_run(${CMAKE_COMMAND} -S ${SOURCE}/examples/${example} -B ${folder} -G Ninja -DCMAKE_PREFIX_PATH=${WORK}/prefix
           -DCMAKE_CXX_COMPILER=${compiler} -DCMAKE_BUILD_TYPE=Release "-DCMAKE_CXX_FLAGS=${flags}")
endfunction()

must_run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)

set(between)
if(EXISTS /proc/cpuinfo)
  # AVX2 aligns as AVX does.
  file(STRINGS /proc/cpuinfo has REGEX "^flags.* avx " LIMIT_COUNT 1)
  if(has)
    set(between -mavx)
  endif()
endif()

set(number 0)
foreach(compiler ${CXX})
  set(flag_sets plain ${between} -march=native)
  set(between)
  foreach(flags ${flag_sets})
    math(EXPR number "${number} + 1")
    set(folder ${WORK}/build${number})
    string(REPLACE "plain" "" given "${flags}")
    configure(cpp_filter ${folder} ${compiler} "${given}")
    must_run(${CMAKE_COMMAND} --build ${folder})
    execute_process(COMMAND ${folder}/my_filter WORKING_DIRECTORY ${folder} RESULT_VARIABLE code OUTPUT_VARIABLE output)
    if(NOT code EQUAL 1 OR NOT output MATCHES "Can this covariance be trusted. No: optimistic")
      message(FATAL_ERROR "my_filter (${compiler} ${flags}) ended with ${code}:\n${output}")
    endif()
    if(NOT EXISTS ${folder}/out/index.html)
      message(FATAL_ERROR "my_filter (${compiler} ${flags}) wrote no report")
    endif()
    message(STATUS "${compiler} ${flags}: optimistic, as it is")
  endforeach()
endforeach()

list(GET CXX 0 compiler)
configure(cpp_world ${WORK}/world ${compiler} "")
must_run(${CMAKE_COMMAND} --build ${WORK}/world)
execute_process(COMMAND ${WORK}/world/my_world WORKING_DIRECTORY ${WORK}/world RESULT_VARIABLE code OUTPUT_VARIABLE output)
if(NOT code EQUAL 1 OR NOT output MATCHES "Can this covariance be trusted. No: optimistic in x2")
  message(FATAL_ERROR "my_world ended with ${code}:\n${output}")
endif()

# What would crash is refused when it is compiled.
configure(cpp_filter ${WORK}/refused ${compiler} "-UEIGEN_MAX_ALIGN_BYTES -DEIGEN_MAX_ALIGN_BYTES=32")
run(${CMAKE_COMMAND} --build ${WORK}/refused)
if(code EQUAL 0 OR NOT output MATCHES "Credence needs EIGEN_MAX_ALIGN_BYTES=64")
  message(FATAL_ERROR "Another alignment of Eigen was not refused: ${code}\n${output}")
endif()
