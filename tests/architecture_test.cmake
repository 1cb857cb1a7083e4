# Who may include whom, for every room: the one place that says it. A room without a row here is refused, and so is a
# row without a room.
#
#   cmake -DROOT=<repository> -P architecture_test.cmake

cmake_minimum_required(VERSION 3.20)
set(violations "")
macro(violation text)
  string(APPEND violations "\n  ${text}")
endmacro()

# may(ROOM [room...]): a room and the rooms that its files may include besides their own
set(rooms "")
macro(may room)
  list(APPEND rooms ${room})
  set(may_${room} ${ARGN})
endmacro()
# files_may(EXPRESSION [room...]): files whose path matches may include these, too
set(file_rules 0)
macro(files_may expression)
  set(file_rule_${file_rules} ${expression})
  set(file_rooms_${file_rules} ${ARGN})
  math(EXPR file_rules "${file_rules} + 1")
endmacro()

# from the bottom to the top
may(controller/base)
may(controller/rt controller/base)
may(controller/scene)
may(controller/mjcf controller/base controller/scene)
may(controller/task controller/base controller/scene)
may(controller/lcs)
may(controller/qp controller/lcs)
may(controller/c3 controller/lcs controller/qp)
may(controller/horizon controller/base controller/lcs controller/qp controller/c3)
may(controller/miqp controller/qp controller/c3 controller/horizon)
may(controller/model controller/lcs controller/scene)
may(controller/example controller/base controller/lcs controller/c3 controller/model)
may(controller/planner controller/base controller/scene controller/task controller/lcs controller/c3 controller/model)
may(controller/impedance controller/model)
may(vision/track controller/base)
may(vision/tag controller/base controller/scene vision/track)
may(vision controller/base controller/scene vision/track vision/tag plant_emulator)
may(plant_emulator controller/base controller/scene controller/mjcf)
may(config controller/base)
may(idl controller/base controller/rt controller/scene controller/task config)
may(cli/report cli controller/base controller/task plant_emulator)
may(cli/example cli cli/report controller/example controller/model plant_emulator)
may(cli/campaign cli cli/report cli/example config controller/base)
may(cli/reproduce cli cli/report cli/example cli/campaign config idl controller/base controller/scene controller/lcs
    controller/c3 controller/horizon controller/example controller/model controller/planner)
may(cli/mesh controller/scene)
may(cli/invariants cli/report controller/base controller/task idl plant_emulator)
may(cli/soak cli cli/report cli/invariants config idl controller/base controller/rt controller/task plant_emulator)
may(cli/chaos cli cli/report cli/invariants cli/soak config idl controller/base controller/rt controller/task)
may(cli/keys cli idl)
may(cli/doctor cli cli/keys config idl)
may(cli/latency cli cli/report cli/example config idl controller/base controller/rt plant_emulator)
may(cli cli/report cli/example cli/campaign cli/reproduce cli/mesh cli/keys cli/doctor cli/latency cli/soak cli/chaos config idl controller/base controller/rt controller/task
    controller/horizon controller/planner plant_emulator)

# a room's loader reads its section of the scenario
files_may("/load_[a-z_]+[.][ch]pp$" config controller/lcs controller/c3 controller/model controller/mjcf)
# config's top: a scenario is made of every room's section, a problem file of the solver's
files_may("^config/scenario[.]" controller/impedance controller/planner controller/task controller/c3 plant_emulator vision)
files_may("^config/(json_reader|problem_file|problem_result)[.]" controller/c3)
# a node speaks the types of the wire; its service, and the impedance controller's servo, speak on the bus
files_may("^(controller/planner|controller/impedance|vision|plant_emulator)/node[.]" idl controller/base controller/scene
    controller/model controller/task)
files_may("^(controller/planner|controller/impedance|vision|plant_emulator)/(service|servo)[.]" idl controller/base
    controller/rt controller/scene controller/model)
files_may("^vision/scene_source[.]" idl controller/scene)
# all nodes in one process
files_may("^cli/in_process[.]" controller/impedance controller/model vision)
files_may("^cli/object_(add|picture)[.]" controller/mjcf controller/model controller/scene)
files_may("^cli/inspect(_[a-z]+)?[.]" controller/lcs controller/mjcf controller/model controller/scene)
files_may("_main[.]cpp$" config idl controller/base controller/rt)

# Pure rooms: a function of its arguments, whose files name no bus, file, clock, thread or configuration.
set(pure controller/base controller/scene controller/task controller/lcs controller/qp controller/c3 controller/horizon
    controller/miqp
    controller/model controller/example controller/planner controller/impedance vision/track vision/tag cli/invariants)
set(impure_files "/load_[a-z_]+[.][ch]pp$|_main[.]cpp$|/service[.]|/servo[.]")
set(impure "<dds/|yaml-cpp|<iostream>|<fstream>|<thread>|<chrono>|<mutex>|spdlog|mujoco")

# Third-party libraries have one owner each.
set(owned "<pinocchio/" "[<\"]osqp" "[<\"](Bon|Cbc|Coin|Ip)[A-Z]" "<dds/" "yaml-cpp" "<mujoco/" "<GL/" "CLI/" "<apriltag/" "<openssl/")
set(owners "^controller/model/arm[.]cpp" "^controller/qp/osqp_qp[.]cpp" "^controller/miqp/bonmin[.]cpp" "^idl/" "^config/"
    "^plant_emulator/|^vision/virtual_cameras[.]|^controller/mjcf/" "^vision/virtual_cameras[.]" "^cli/|^config/process_options[.]" "^vision/apriltag[.]cpp"
    "^cli/keys/crypto[.]cpp")

# The room of a path: its longest folder that has a row.
function(room_of path out)
  set(found "")
  foreach(room ${rooms})
    string(LENGTH "${room}/" length)
    string(LENGTH "${found}" best)
    string(FIND "${path}" "${room}/" at)
    if(at EQUAL 0 AND length GREATER best)
      set(found ${room})
    endif()
  endforeach()
  set(${out} "${found}" PARENT_SCOPE)
endfunction()

foreach(room ${rooms})
  set(files_in_${room} 0)
endforeach()
foreach(top controller vision plant_emulator idl config cli)
  file(GLOB_RECURSE files RELATIVE ${ROOT} ${ROOT}/${top}/*.hpp ${ROOT}/${top}/*.cpp)
  foreach(file ${files})
    room_of(${file} room)
    if(NOT room)
      violation("${file}: its room has no row in tests/architecture_test.cmake")
      continue()
    endif()
    math(EXPR files_in_${room} "${files_in_${room}} + 1")
    set(allowed ${room} ${may_${room}})
    if(file_rules GREATER 0)
      math(EXPR last "${file_rules} - 1")
      foreach(i RANGE ${last})
        if(file MATCHES "${file_rule_${i}}")
          list(APPEND allowed ${file_rooms_${i}})
        endif()
      endforeach()
    endif()
    file(STRINGS ${ROOT}/${file} includes REGEX "^#include")
    foreach(line ${includes})
      if(line MATCHES "^#include \"([a-z0-9_/]+/)[a-z0-9_]+[.]hpp\"")
        room_of(${CMAKE_MATCH_1} target)
        if(NOT target IN_LIST allowed)
          violation("${file}: ${line}: ${room} may not include ${CMAKE_MATCH_1}")
        endif()
      endif()
      if(room IN_LIST pure AND line MATCHES "${impure}" AND NOT file MATCHES "${impure_files}")
        violation("${file}: ${line}: a pure room may not")
      endif()
      foreach(library owner IN ZIP_LISTS owned owners)
        if(line MATCHES "${library}" AND NOT file MATCHES "${owner}")
          violation("${file}: ${line}: only ${owner} names this library")
        endif()
      endforeach()
    endforeach()
  endforeach()
endforeach()
foreach(room ${rooms})
  if(files_in_${room} EQUAL 0)
    violation("${room}: has a row and no file: has the room moved?")
  endif()
  foreach(other ${may_${room}})
    if(NOT other IN_LIST rooms)
      violation("${room}: may include ${other}, which is no room")
    endif()
  endforeach()
endforeach()

if(violations)
  message(FATAL_ERROR "architecture:${violations}")
endif()
