# CONTRIBUTING.md names no file or folder that is not there.
#
#   cmake -DROOT=<repository> -P contributing_test.cmake
cmake_minimum_required(VERSION 3.20)
file(READ ${ROOT}/CONTRIBUTING.md text)
string(REGEX MATCHALL "`[a-z0-9_./-]+/[a-z0-9_./-]*`" names "${text}")
set(count 0)
foreach(name ${names})
  string(REPLACE "`" "" name ${name})
  math(EXPR count "${count} + 1")
  if(NOT EXISTS ${ROOT}/${name})
    message(SEND_ERROR "CONTRIBUTING.md names ${name}, which is not there")
  endif()
endforeach()
if(count LESS 15)
  message(FATAL_ERROR "only ${count} names found in CONTRIBUTING.md: has its form changed?")
endif()
