# Installs the package into a prefix of its own, builds the example against it, and runs it.
# BUILD, SOURCE: of the project; WORK: a folder for all of that; CXX: the compiler
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

must_run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)
must_run(${CMAKE_COMMAND} -S ${SOURCE}/examples/cpp_filter -B ${WORK}/build -G Ninja
         -DCMAKE_PREFIX_PATH=${WORK}/prefix -DCMAKE_CXX_COMPILER=${CXX} -DCMAKE_BUILD_TYPE=Release)
must_run(${CMAKE_COMMAND} --build ${WORK}/build)
execute_process(COMMAND ${WORK}/build/my_filter WORKING_DIRECTORY ${WORK} RESULT_VARIABLE code OUTPUT_VARIABLE output)
if(NOT code EQUAL 1 OR NOT output MATCHES "Can this covariance be trusted. optimistic")
  message(FATAL_ERROR "my_filter ended with ${code}:\n${output}")
endif()
if(NOT EXISTS ${WORK}/out/index.html)
  message(FATAL_ERROR "my_filter wrote no report")
endif()
