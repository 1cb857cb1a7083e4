# The 1 kHz process loads no simulator and no image library: it reads its own sections of the scenario alone.
#
#   cmake -DIMPEDANCE=<c3rt-impedance> -DPLANT=<c3rt-plant> -P links_test.cmake
function(libraries program result)
  execute_process(COMMAND ldd ${program} OUTPUT_VARIABLE text RESULT_VARIABLE status)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "links: ldd ${program} ended with ${status}")
  endif()
  set(${result} "${text}" PARENT_SCOPE)
endfunction()

libraries(${PLANT} of_plant)
if(NOT of_plant MATCHES "libmujoco")
  message(FATAL_ERROR "links: the plant does not load MuJoCo: does this test see what a program loads?")
endif()
libraries(${IMPEDANCE} of_impedance)
if(of_impedance MATCHES "lib(mujoco|opencv|OSMesa)[^ ]*")
  message(FATAL_ERROR "links: c3rt-impedance loads ${CMAKE_MATCH_0}")
endif()
