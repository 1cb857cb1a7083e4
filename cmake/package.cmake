# What find_package(c3rt) gives: the pure libraries, their headers, and OSQP, which they link. A consumer needs only
# Eigen. Installed alone by: cmake --install <build> --component library
include(CheckCXXSourceCompiles)
include(CMakePackageConfigHelpers)

# What Eigen allocates here may be freed in the consumer's code, so both must agree on how: with AddressSanitizer or for
# another vector unit Eigen would do it differently. lcs.hpp refuses the latter.
set(CMAKE_REQUIRED_LIBRARIES Eigen3::Eigen)
set(eigen_alignment 16)
foreach(bytes 16 32 64)
  check_cxx_source_compiles("#include <Eigen/Core>
    static_assert(EIGEN_DEFAULT_ALIGN_BYTES == ${bytes}, \"\");
    int main() {}" C3RT_EIGEN_ALIGNMENT_IS_${bytes})
  if(C3RT_EIGEN_ALIGNMENT_IS_${bytes})
    set(eigen_alignment ${bytes})
    break()
  endif()
endforeach()
if(C3RT_SANITIZE)
  set(CMAKE_REQUIRED_FLAGS -fsanitize=${C3RT_SANITIZE})
endif()
check_cxx_source_compiles("#include <Eigen/Core>
  static_assert(EIGEN_MALLOC_ALREADY_ALIGNED, \"\");
  int main() {}" C3RT_EIGEN_PLAIN_MALLOC)
unset(CMAKE_REQUIRED_FLAGS)
unset(CMAKE_REQUIRED_LIBRARIES)
set(eigen_plain_malloc $<BOOL:${C3RT_EIGEN_PLAIN_MALLOC}>)

# c3rt_export(ROOM header...): the target c3rt::ROOM of the package and its public headers
function(c3rt_export room)
  set_target_properties(c3rt_${room} PROPERTIES EXPORT_NAME ${room})
  target_include_directories(c3rt_${room} INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_compile_features(c3rt_${room} INTERFACE cxx_std_17)
  target_compile_definitions(c3rt_${room} INTERFACE
    $<INSTALL_INTERFACE:C3RT_EIGEN_ALIGNMENT=${eigen_alignment};EIGEN_MALLOC_ALREADY_ALIGNED=${eigen_plain_malloc}>)
  install(TARGETS c3rt_${room} EXPORT c3rtTargets
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library)
  list(TRANSFORM ARGN PREPEND ${PROJECT_SOURCE_DIR}/controller/${room}/)
  install(FILES ${ARGN} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/controller/${room} COMPONENT library)
endfunction()

c3rt_export(lcs lcs.hpp lemke.hpp riccati.hpp simulate.hpp step.hpp)
c3rt_export(c3 deadline.hpp parallel.hpp problem.hpp projection.hpp qp.hpp solver.hpp)
c3rt_export(horizon condensed.hpp modes.hpp problem.hpp search.hpp)
c3rt_export(model ball_model.hpp balls_model.hpp cart_pole.hpp contact_system.hpp finger_gaiting.hpp linearise.hpp
  pivoting.hpp)
c3rt_export(example closed_loop.hpp controller.hpp experiment.hpp)

# under a name that meets no other OSQP in the same prefix; its headers stay here
install(FILES ${C3RT_THIRD_PARTY}/lib/libosqp.a DESTINATION ${CMAKE_INSTALL_LIBDIR} RENAME libc3rt_osqp.a
  COMPONENT library)
set_target_properties(third_party_osqp PROPERTIES
  EXPORT_NAME osqp
  INTERFACE_INCLUDE_DIRECTORIES $<BUILD_INTERFACE:${C3RT_THIRD_PARTY}/include/osqp>
  INTERFACE_SYSTEM_INCLUDE_DIRECTORIES $<BUILD_INTERFACE:${C3RT_THIRD_PARTY}/include/osqp>
  INTERFACE_LINK_LIBRARIES "$<BUILD_INTERFACE:${C3RT_THIRD_PARTY}/lib/libosqp.a>;$<INSTALL_INTERFACE:$<INSTALL_PREFIX>/${CMAKE_INSTALL_LIBDIR}/libc3rt_osqp.a>;m;dl")
install(TARGETS third_party_osqp EXPORT c3rtTargets)

set(package_directory ${CMAKE_INSTALL_LIBDIR}/cmake/c3rt)
install(EXPORT c3rtTargets NAMESPACE c3rt:: DESTINATION ${package_directory} COMPONENT library)
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/c3rtConfig.cmake.in ${PROJECT_BINARY_DIR}/c3rtConfig.cmake
  INSTALL_DESTINATION ${package_directory} NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/c3rtConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/c3rtConfig.cmake ${PROJECT_BINARY_DIR}/c3rtConfigVersion.cmake
  DESTINATION ${package_directory} COMPONENT library)
# builds what the component holds
add_custom_target(library DEPENDS c3rt_lcs c3rt_c3 c3rt_horizon c3rt_model c3rt_example)
