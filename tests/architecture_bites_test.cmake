# The layering test must bite: a forbidden include, planted in a copy, is found and named.
#
#   cmake -DROOT=<repository> -DSCRATCH=<folder> -P architecture_bites_test.cmake

file(REMOVE_RECURSE ${SCRATCH})
foreach(room config controller vision plant_emulator cli)
  file(COPY ${ROOT}/${room} DESTINATION ${SCRATCH})
endforeach()
file(APPEND ${SCRATCH}/controller/lcs/lcs.cpp "#include <chrono>\n")
execute_process(COMMAND ${CMAKE_COMMAND} -DROOT=${SCRATCH} -P ${ROOT}/tests/architecture_test.cmake
  RESULT_VARIABLE status ERROR_VARIABLE text)
if(status EQUAL 0 OR NOT text MATCHES "controller/lcs/lcs.cpp")
  message(FATAL_ERROR "a planted <chrono> was not found: ${text}")
endif()
