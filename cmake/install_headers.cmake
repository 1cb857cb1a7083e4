# Installs the public headers, each of which begins with the choice that eigen_abi.hpp makes. By install(CODE), with `from`,
# `to` and `headers` set.
foreach(header ${headers})
  file(READ "${from}/${header}" text)
  string(REPLACE "#pragma once\n" "#pragma once\n#include \"controller/eigen_abi.hpp\"\n" text "${text}")
  set(installed "${CMAKE_INSTALL_PREFIX}/${to}/${header}")
  message(STATUS "Installing: $ENV{DESTDIR}${installed}")
  file(WRITE "$ENV{DESTDIR}${installed}" "${text}")
  list(APPEND CMAKE_INSTALL_MANIFEST_FILES "${installed}")
endforeach()
