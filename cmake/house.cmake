# The project's own ways to declare a target, so that warnings and include roots are said once.

add_library(c3rt_house INTERFACE)
add_library(c3rt::house ALIAS c3rt_house)
target_compile_options(c3rt_house INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
  # Clang wants braces within braces, which C++ does without
  $<$<CXX_COMPILER_ID:Clang>:-Wno-missing-braces>
  $<$<BOOL:${C3RT_WERROR}>:-Werror>
  # the same bits on every machine: no fused multiply-add chosen by the compiler
  -ffp-contract=off)
target_include_directories(c3rt_house INTERFACE ${PROJECT_SOURCE_DIR})
if(C3RT_SANITIZE)
  # a finding ends the test; without this undefined behaviour is printed and the test passes. Null pointers and what lies
  # outside of an object end a test anyway, and alignment Eigen asserts itself: their checks at every access take the
  # compiler from 11 s and 0.7 GB to more than 90 s and 3.4 GB for controller/lcs/riccati.cpp
  target_compile_options(c3rt_house INTERFACE
    -fsanitize=${C3RT_SANITIZE} -fno-sanitize=null,alignment,object-size -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(c3rt_house INTERFACE -fsanitize=${C3RT_SANITIZE})
  # Eigen's blocks of empty matrices are offsets on null pointers, which nothing reads
  target_compile_options(c3rt_house INTERFACE $<$<CXX_COMPILER_ID:Clang>:-fno-sanitize=pointer-overflow>)
  # among the checks GCC sees uninitialised values in std::regex and Eigen that are not there
  target_compile_options(c3rt_house INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
endif()

# Reading Eigen, the standard library, fmt, nlohmann_json and Catch2 anew for each source takes a sixth to a quarter of the time:
# they are read once for sources that are compiled with the same options.
option(C3RT_PRECOMPILE_HEADERS "Read the headers of others once instead of once for each source" ON)
set(C3RT_STANDARD_HEADERS <algorithm> <array> <cmath> <cstdint> <cstring> <functional> <limits> <memory> <optional>
  <stdexcept> <string> <utility> <vector>)
if(C3RT_PRECOMPILE_HEADERS)
  file(WRITE ${PROJECT_BINARY_DIR}/precompiled.cpp "")
  # a compiler cache knows what depends on them by this
  add_compile_options($<$<COMPILE_LANG_AND_ID:CXX,GNU>:-fpch-preprocess>)
  foreach(launcher CMAKE_C_COMPILER_LAUNCHER CMAKE_CXX_COMPILER_LAUNCHER)
    if("${${launcher}}" STREQUAL ccache)
      set(${launcher} env CCACHE_SLOPPINESS=pch_defines,time_macros ccache)
    endif()
  endforeach()
endif()

# Most of what a source costs is templates of Eigen and of our own headers, instantiated again in each: several sources of a
# library as one cost a third to a half. After a change all of them are compiled again, so it is off unless asked for.
option(C3RT_JOIN_SOURCES "Compile several sources of a library as one" OFF)

# c3rt_precompiled(KIND HEADERS header... [DEPS target...] [OPTIONS option...] [POSITION_INDEPENDENT])
function(c3rt_precompiled kind)
  cmake_parse_arguments(arg "POSITION_INDEPENDENT" "" "HEADERS;DEPS;OPTIONS" ${ARGN})
  if(C3RT_PRECOMPILE_HEADERS)
    add_library(c3rt_precompiled_${kind} OBJECT ${PROJECT_BINARY_DIR}/precompiled.cpp)
    set_target_properties(c3rt_precompiled_${kind} PROPERTIES POSITION_INDEPENDENT_CODE ${arg_POSITION_INDEPENDENT})
    target_link_libraries(c3rt_precompiled_${kind} PRIVATE c3rt::house Eigen3::Eigen ${arg_DEPS})
    target_compile_options(c3rt_precompiled_${kind} PRIVATE ${arg_OPTIONS})
    target_precompile_headers(c3rt_precompiled_${kind} PRIVATE ${C3RT_STANDARD_HEADERS} <Eigen/Dense> ${arg_HEADERS})
  endif()
endfunction()
# the tests' own code runs for moments: less optimised it compiles in three quarters of the time; GCC then sees uninitialised
# values in Eigen's copies that are not there
set(C3RT_TEST_OPTIONS "$<$<CONFIG:Release>:-O1>" "$<$<CONFIG:Debug>:-O0>" $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
# what reads and writes text is not hot: with sanitizers it compiles in two fifths of the time
set(C3RT_TOOL_OPTIONS "$<$<CONFIG:Debug>:-O0>")
c3rt_precompiled(library POSITION_INDEPENDENT)
c3rt_precompiled(tool POSITION_INDEPENDENT OPTIONS ${C3RT_TOOL_OPTIONS} HEADERS <fmt/format.h> <nlohmann/json.hpp> DEPS fmt::fmt nlohmann_json::nlohmann_json)
if(BUILD_TESTING)
  c3rt_precompiled(test HEADERS <catch2/catch.hpp> DEPS Catch2::Catch2 OPTIONS ${C3RT_TEST_OPTIONS})
endif()

# c3rt_use_precompiled(TARGET KIND)
function(c3rt_use_precompiled target kind)
  if(C3RT_PRECOMPILE_HEADERS)
    target_precompile_headers(${target} REUSE_FROM c3rt_precompiled_${kind})
  endif()
endfunction()

# c3rt_library(NAME SOURCES file... [DEPS target...] [PRIVATE_DEPS target...])
# A library c3rt_NAME, alias c3rt::NAME. Without sources it is header-only.
function(c3rt_library name)
  cmake_parse_arguments(arg "" "" "SOURCES;DEPS;PRIVATE_DEPS" ${ARGN})
  if(arg_SOURCES)
    add_library(c3rt_${name} STATIC ${arg_SOURCES})
    set_target_properties(c3rt_${name} PROPERTIES POSITION_INDEPENDENT_CODE ON)
    target_link_libraries(c3rt_${name} PUBLIC ${arg_DEPS} PRIVATE ${arg_PRIVATE_DEPS} $<BUILD_INTERFACE:c3rt::house>)
    target_include_directories(c3rt_${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>)
    if("fmt::fmt" IN_LIST arg_PRIVATE_DEPS)
      target_compile_options(c3rt_${name} PRIVATE ${C3RT_TOOL_OPTIONS})
      c3rt_use_precompiled(c3rt_${name} tool)
    else()
      c3rt_use_precompiled(c3rt_${name} library)
    endif()
  else()
    add_library(c3rt_${name} INTERFACE)
    target_link_libraries(c3rt_${name} INTERFACE ${arg_DEPS})
    target_include_directories(c3rt_${name} INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>)
  endif()
  add_library(c3rt::${name} ALIAS c3rt_${name})
endfunction()

# c3rt_join_sources(NAME...): the libraries c3rt_NAME may be compiled eight sources at a time
function(c3rt_join_sources)
  foreach(name ${ARGN})
    set_target_properties(c3rt_${name} PROPERTIES UNITY_BUILD ${C3RT_JOIN_SOURCES} UNITY_BUILD_BATCH_SIZE 8)
    if(C3RT_JOIN_SOURCES)
      # that a class of one source has a member of a type without linkage is meant as long as it is one source's
      target_compile_options(c3rt_${name} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
    endif()
  endforeach()
endfunction()

# c3rt_process(NAME main.cpp [DEPS target...]): the executable c3rt-NAME, installed
function(c3rt_process name source)
  cmake_parse_arguments(arg "" "" "DEPS" ${ARGN})
  add_executable(c3rt-${name} ${source})
  target_link_libraries(c3rt-${name} PRIVATE ${arg_DEPS} c3rt::house)
  set_target_properties(c3rt-${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
  install(TARGETS c3rt-${name} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endfunction()

# c3rt_timeout(VARIABLE seconds): what a test may take in this build
function(c3rt_timeout variable seconds)
  if(C3RT_SANITIZE)
    math(EXPR seconds "10 * ${seconds}")
  endif()
  set(${variable} ${seconds} PARENT_SCOPE)
endfunction()

# c3rt_test(room/name [DEPS target...] [LABEL unit|property|integration|system] [TIMEOUT seconds] [COST seconds] [WAITS])
# WAITS: it computes next to nothing. For ctest a test is two processors and one that waits a single one: with five, as in
# CMakePresets.json and ./c3rt test, two of them compute and one waits. What has a larger COST (default: TIMEOUT) begins first.
# tests/room/name_test.cpp becomes the ctest "room/name". The target unit_tests builds those that need no process. A program
# test_room_name has it by itself, or with sources that are joined one test_room the unit and property tests of its folder.
function(c3rt_test path)
  cmake_parse_arguments(arg "WAITS" "LABEL;TIMEOUT;COST" "DEPS" ${ARGN})
  if(NOT arg_LABEL)
    set(arg_LABEL unit)
  endif()
  if(NOT arg_TIMEOUT)
    set(arg_TIMEOUT 60)
  endif()
  c3rt_timeout(timeout ${arg_TIMEOUT})
  if(C3RT_JOIN_SOURCES AND arg_LABEL MATCHES "^(unit|property)$")
    get_filename_component(room ${path} DIRECTORY)
    get_filename_component(name ${path} NAME)
    string(REPLACE "/" "_" target test_${room})
    get_property(begun DIRECTORY PROPERTY ${target}_TESTS)
    if(NOT begun)
      cmake_language(EVAL CODE "cmake_language(DEFER CALL c3rt_join_tests ${target})")
    endif()
    set_property(DIRECTORY APPEND PROPERTY ${target}_TESTS ${path})
    set_property(DIRECTORY APPEND PROPERTY ${target}_DEPS ${arg_DEPS})
    add_test(NAME ${path} COMMAND ${target} --filenames-as-tags "[#${name}_test]")
  else()
    string(REPLACE "/" "_" target test_${path})
    c3rt_test_program(${target} ${arg_LABEL} DEPS ${arg_DEPS} SOURCES ${PROJECT_SOURCE_DIR}/tests/${path}_test.cpp)
    add_test(NAME ${path} COMMAND ${target})
  endif()
  # what may take long begins first, so that no core waits for it at the end
  if(NOT arg_COST)
    set(arg_COST ${arg_TIMEOUT})
  endif()
  set(processors 2)
  if(arg_WAITS)
    set(processors 1)
  endif()
  set_tests_properties(${path} PROPERTIES LABELS ${arg_LABEL} TIMEOUT ${timeout} COST ${arg_COST} PROCESSORS ${processors})
endfunction()

# c3rt_test_program(TARGET LABEL SOURCES file... [DEPS target...])
function(c3rt_test_program target label)
  cmake_parse_arguments(arg "" "" "DEPS;SOURCES" ${ARGN})
  add_executable(${target} ${arg_SOURCES})
  target_link_libraries(${target} PRIVATE ${arg_DEPS} c3rt_test_main c3rt::house)
  target_compile_definitions(${target} PRIVATE
    C3RT_SOURCE_DIRECTORY="${PROJECT_SOURCE_DIR}" C3RT_BINARY_DIRECTORY="${PROJECT_BINARY_DIR}"
    C3RT_THIRD_PARTY="${C3RT_THIRD_PARTY}")
  if(label MATCHES "^(unit|property)$")
    if(NOT TARGET unit_tests)
      add_custom_target(unit_tests)
    endif()
    add_dependencies(unit_tests ${target})
  endif()
  target_compile_options(${target} PRIVATE ${C3RT_TEST_OPTIONS})
  c3rt_use_precompiled(${target} test)
endfunction()

# The program of a folder's tests, eight in a source. Each is in a namespace of its own, so that the same name in two of them
# stays two things; what it includes comes first, outside of it.
function(c3rt_join_tests target)
  get_property(tests DIRECTORY PROPERTY ${target}_TESTS)
  get_property(deps DIRECTORY PROPERTY ${target}_DEPS)
  list(REMOVE_DUPLICATES deps)
  set(sources "")
  set(includes "")
  set(texts "")
  set(count 0)
  list(LENGTH tests last)
  foreach(test ${tests})
    math(EXPR count "${count} + 1")
    set(file ${PROJECT_SOURCE_DIR}/tests/${test}_test.cpp)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
    file(STRINGS ${file} of_test REGEX "^#include")
    list(APPEND includes ${of_test})
    string(MAKE_C_IDENTIFIER "test_${test}" name)
    string(APPEND texts "namespace ${name} {\n#include \"${file}\"\n}\n")
    math(EXPR rest "${count} % 8")
    if(rest EQUAL 0 OR count EQUAL last)
      list(REMOVE_DUPLICATES includes)
      list(JOIN includes "\n" includes)
      set(source ${CMAKE_CURRENT_BINARY_DIR}/${target}_${count}.cpp)
      file(CONFIGURE OUTPUT ${source} CONTENT "${includes}\n\n${texts}" @ONLY)
      list(APPEND sources ${source})
      set(includes "")
      set(texts "")
    endif()
  endforeach()
  c3rt_test_program(${target} unit DEPS ${deps} SOURCES ${sources})
endfunction()
