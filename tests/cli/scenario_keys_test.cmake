# docs/scenario_keys.md is what `c3rt scenario --keys` prints below its own first lines.
#
#   cmake -DC3RT=<c3rt> -DPAGE=<docs/scenario_keys.md> -P scenario_keys_test.cmake
execute_process(COMMAND ${C3RT} scenario --keys OUTPUT_VARIABLE keys RESULT_VARIABLE status)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "scenario_keys: c3rt scenario --keys ended with ${status}")
endif()
file(READ ${PAGE} page)
string(FIND "${page}" "\n## " begin)
string(SUBSTRING "${page}" ${begin} -1 page)
if(NOT page STREQUAL keys)
  message(FATAL_ERROR "scenario_keys: ${PAGE} is not what the readers ask for: docs/scenario_keys.md says how to make it anew")
endif()
