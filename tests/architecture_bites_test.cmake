# The layering test must bite: each kind of violation, planted in a copy, is found and named.
#
#   cmake -DROOT=<repository> -DSCRATCH=<folder> -P architecture_bites_test.cmake
cmake_minimum_required(VERSION 3.20)

file(REMOVE_RECURSE ${SCRATCH})
foreach(room config controller vision plant_emulator idl cli python)
  file(COPY ${ROOT}/${room} DESTINATION ${SCRATCH} FILES_MATCHING PATTERN "*.hpp" PATTERN "*.cpp")
endforeach()

# Not one by one: a run looks at every file. Each line is a file and what is planted in it.
set(planted
  "controller/lcs/planted.cpp|#include <chrono>"                          # a pure room
  "controller/scene/planted.hpp|#include \"controller/task/task.hpp\""    # against the direction of dependency
  "vision/planted.cpp|#include \"controller/planner/planner.hpp\""        # from room to room
  "controller/planner/planted.cpp|#include \"idl/topics.hpp\""            # the bus
  "config/planted.cpp|#include \"controller/c3/problem.hpp\""             # the bottom of config
  "controller/model/planted.cpp|#include <pinocchio/fwd.hpp>"             # somebody else's library
  "python/src/planted.cpp|#include \"idl/topics.hpp\""                   # the bus, of which the package has nothing
  "cli/planted.cpp|#include <nanobind/nanobind.h>"                        # Python's library
  "cli/report/planted.cpp|#include <dds/dds.h>"                           # the bus's library
  "controller/newcomer/planted.cpp|#include <vector>")                    # a room without a row
foreach(plant ${planted})
  string(REPLACE "|" ";" plant "${plant}")
  list(GET plant 0 file)
  list(GET plant 1 line)
  file(WRITE ${SCRATCH}/${file} "${line}\n")
endforeach()
execute_process(COMMAND ${CMAKE_COMMAND} -DROOT=${SCRATCH} -P ${ROOT}/tests/architecture_test.cmake
  RESULT_VARIABLE status ERROR_VARIABLE text)
foreach(plant ${planted})
  string(REPLACE "|" ";" plant "${plant}")
  list(GET plant 0 file)
  if(status EQUAL 0 OR NOT text MATCHES "${file}")
    message(FATAL_ERROR "planted and not found: ${plant}\n${text}")
  endif()
endforeach()

# and a row whose room is gone
file(REMOVE_RECURSE ${SCRATCH}/controller/task)
execute_process(COMMAND ${CMAKE_COMMAND} -DROOT=${SCRATCH} -P ${ROOT}/tests/architecture_test.cmake
  RESULT_VARIABLE status ERROR_VARIABLE text)
if(status EQUAL 0 OR NOT text MATCHES "controller/task: has a row and no file")
  message(FATAL_ERROR "a room that is gone was not missed:\n${text}")
endif()
