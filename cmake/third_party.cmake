# Everything that is not ours, found once and given one name each.

list(PREPEND CMAKE_PREFIX_PATH "${C3RT_THIRD_PARTY}")
if(NOT EXISTS "${C3RT_THIRD_PARTY}/lib/libosqp.a")
  message(FATAL_ERROR "OSQP and Pinocchio are not in ${C3RT_THIRD_PARTY}: run ./c3rt setup (or cmake/third_party.sh) first")
endif()

find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(CycloneDDS 0.10 REQUIRED)
find_package(yaml-cpp REQUIRED)
find_package(spdlog REQUIRED)
find_package(CLI11 REQUIRED)
find_package(nlohmann_json 3.11 REQUIRED)
# OpenCV's own configuration file comes only with all of its modules (three hundred packages): two are enough
find_path(OPENCV_INCLUDE_DIRECTORY opencv2/core.hpp PATH_SUFFIXES opencv4 REQUIRED)
find_library(OPENCV_CORE opencv_core REQUIRED)
find_library(OPENCV_IMGPROC opencv_imgproc REQUIRED)
find_path(APRILTAG_INCLUDE_DIRECTORY apriltag/apriltag.h REQUIRED)
find_library(APRILTAG apriltag REQUIRED)
find_library(APRILTAG_UTILS apriltag-utils REQUIRED)
find_package(pinocchio 3.4 REQUIRED)
find_package(Boost REQUIRED COMPONENTS filesystem)
if(BUILD_TESTING)
  find_package(Catch2 2.13 REQUIRED)
endif()

# Third-party headers are not held to our warnings.
function(c3rt_imported name)
  cmake_parse_arguments(arg "" "" "INCLUDE;LINK" ${ARGN})
  add_library(third_party_${name} INTERFACE)
  add_library(third_party::${name} ALIAS third_party_${name})
  target_include_directories(third_party_${name} SYSTEM INTERFACE ${arg_INCLUDE})
  target_link_libraries(third_party_${name} INTERFACE ${arg_LINK})
endfunction()

c3rt_imported(osqp INCLUDE "${C3RT_THIRD_PARTY}/include/osqp" LINK "${C3RT_THIRD_PARTY}/lib/libosqp.a" m dl)
c3rt_imported(mujoco LINK mujoco)
c3rt_imported(osmesa LINK OSMesa)
c3rt_imported(opencv INCLUDE "${OPENCV_INCLUDE_DIRECTORY}" LINK "${OPENCV_IMGPROC}" "${OPENCV_CORE}")
# its own headers include one another from within its folder
c3rt_imported(apriltag INCLUDE "${APRILTAG_INCLUDE_DIRECTORY}" "${APRILTAG_INCLUDE_DIRECTORY}/apriltag" LINK "${APRILTAG}" "${APRILTAG_UTILS}")
c3rt_imported(pinocchio LINK pinocchio::pinocchio)

# A general MIQP solver, to compare with and for nothing else: without it those targets are left out.
# Its own headers need to be told that the standard library has <cstddef>.
find_path(BONMIN_INCLUDE_DIRECTORY BonBonminSetup.hpp PATH_SUFFIXES coin coin-or)
set(BONMIN_LIBRARIES "")
foreach(library bonmin Cbc OsiClp Osi CoinUtils ipopt)
  find_library(BONMIN_${library} ${library})
  list(APPEND BONMIN_LIBRARIES "${BONMIN_${library}}")
endforeach()
if(BONMIN_INCLUDE_DIRECTORY AND NOT "${BONMIN_LIBRARIES}" MATCHES "NOTFOUND")
  c3rt_imported(bonmin INCLUDE "${BONMIN_INCLUDE_DIRECTORY}" LINK ${BONMIN_LIBRARIES})
  target_compile_definitions(third_party_bonmin INTERFACE HAVE_CSTDDEF)
  message(STATUS "Bonmin found: building c3rt::miqp, the baseline of the comparisons")
else()
  message(STATUS "Bonmin not found (Debian: coinor-libbonmin-dev): leaving out c3rt::miqp, the baseline of the comparisons")
endif()
