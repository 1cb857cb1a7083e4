# The pure rooms name no bus, file, clock, thread or configuration; nobody but its owner names a third-party library.
#
#   cmake -DROOT=<repository> [-DPLANT=<a violation to plant>] -P architecture_test.cmake
#   cmake -DROOT=<repository> -P architecture_test.cmake
# refuse(<glob of files> <regular expression of an #include line> <why>)
set(violations "")
function(refuse pattern expression why)
  file(GLOB_RECURSE files ${ROOT}/${pattern}*.hpp ${ROOT}/${pattern}*.cpp)
  if(NOT files)
    message(FATAL_ERROR "architecture: no files match ${pattern}: has the room moved?")
  endif()
  foreach(file ${files})
    if(file MATCHES "${except}")
      continue()
    endif()
    file(STRINGS ${file} includes REGEX "^#include")
    foreach(line ${includes})
      if(line MATCHES "${expression}")
        set(violations "${violations}\n  ${file}: ${line}: ${why}" PARENT_SCOPE)
      endif()
    endforeach()
  endforeach()
endfunction()

set(except "load_parameters|_main\\.cpp|/service\\.|/servo\\.")
foreach(room lcs c3 model impedance planner)
  refuse(controller/${room}/ "<dds/|\"idl/|\"config/|yaml-cpp|<iostream>|<fstream>|<thread>|<chrono>|<mutex>|spdlog|mujoco"
    "a pure room may not")
endforeach()
refuse(vision/track/ "<dds/|\"idl/|\"config/|yaml-cpp|<iostream>|<fstream>|<thread>|<chrono>|<mutex>|spdlog|mujoco"
  "a pure room may not")
refuse(controller/lcs/ "\"controller/(c3|model|impedance|planner|rt)/" "dependency runs the other way")
refuse(controller/c3/ "\"controller/(model|impedance|planner|rt)/" "dependency runs the other way")
refuse(controller/model/ "\"controller/(c3|impedance|planner|rt)/" "dependency runs the other way")

set(except "_main\\.cpp|scenario\\.")
refuse(plant_emulator/ "\"(controller/(lcs|c3|model|impedance|planner)|vision)/" "the plant knows no controller")
set(except "_main\\.cpp")
refuse(vision/ "\"controller/(lcs|c3|model|impedance|planner)/" "vision knows no controller")

set(except "/model/arm\\.cpp")
refuse(controller/ "<pinocchio/" "only model/arm.cpp names Pinocchio")
set(except "/osqp_qp\\.cpp")
refuse(controller/ "[<\"]osqp" "only c3/osqp_qp.cpp names OSQP")
set(except "^$")
foreach(room config controller vision plant_emulator cli)
  refuse(${room}/ "<dds/" "only idl/ names Cyclone DDS")
endforeach()

if(violations)
  message(FATAL_ERROR "architecture:${violations}")
endif()
