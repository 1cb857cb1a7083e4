# What find_package(c3rt) gives: the pure libraries and their headers, for which a consumer needs only Eigen, with whatever
# flags; and with COMPONENTS client what takes part in the bus, on Cyclone DDS. Installed alone by:
# cmake --install <build> --component library
include(CheckCXXSourceCompiles)
include(CMakePackageConfigHelpers)

# How Eigen allocates in this build. Where that is std::malloc, the package's code allocates by its caller's Eigen instead
# (eigen_abi.hpp.in); else, with sanitizers or for another vector unit, its callers must do as this build does.
set(CMAKE_REQUIRED_LIBRARIES Eigen3::Eigen)
set(native_alignment 16)
foreach(bytes 16 32 64)
  check_cxx_source_compiles("#include <Eigen/Core>
    static_assert(EIGEN_DEFAULT_ALIGN_BYTES == ${bytes}, \"\");
    int main() {}" C3RT_EIGEN_ALIGNMENT_IS_${bytes})
  if(C3RT_EIGEN_ALIGNMENT_IS_${bytes})
    set(native_alignment ${bytes})
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

set(native_pads 1)
set(allocates_by_caller 0)
if(C3RT_EIGEN_PLAIN_MALLOC)
  set(native_pads 0)
  if(NOT C3RT_SANITIZE)
    set(allocates_by_caller 1)
  endif()
endif()
configure_file(${PROJECT_SOURCE_DIR}/cmake/eigen_abi.hpp.in ${PROJECT_BINARY_DIR}/package/eigen_abi.hpp @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/package/eigen_abi.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/controller
  COMPONENT library)

# c3rt_package_archive(ROOM BY_CALLER bool TYPES bool OBJECTS file... [ARCHIVES file...]): the target c3rt::ROOM of the package, and
# archives that it is to hold what it needs of
function(c3rt_package_archive room)
  cmake_parse_arguments(arg "" "BY_CALLER;TYPES" "OBJECTS;ARCHIVES" ${ARGN})
  set(object ${PROJECT_BINARY_DIR}/package/${room}.o)
  add_custom_command(OUTPUT ${object}
    COMMAND ${CMAKE_COMMAND} -DLINKER=${CMAKE_LINKER} -DOBJCOPY=${CMAKE_OBJCOPY} -DNM=${CMAKE_NM}
      "-DINPUTS=${arg_OBJECTS}" "-DARCHIVES=${arg_ARCHIVES}" -DBY_CALLER=${arg_BY_CALLER} -DTYPES=${arg_TYPES}
      -DOUTPUT=${object} -P ${PROJECT_SOURCE_DIR}/cmake/isolate.cmake
    DEPENDS ${arg_OBJECTS} ${arg_ARCHIVES} ${PROJECT_SOURCE_DIR}/cmake/isolate.cmake VERBATIM)
  set_source_files_properties(${object} PROPERTIES EXTERNAL_OBJECT ON GENERATED ON)
  add_library(c3rt_package_${room} STATIC ${object})
  set_target_properties(c3rt_package_${room} PROPERTIES
    EXPORT_NAME ${room} OUTPUT_NAME c3rt_${room} LINKER_LANGUAGE CXX
    ARCHIVE_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/package)
  target_include_directories(c3rt_package_${room} INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_compile_features(c3rt_package_${room} INTERFACE cxx_std_17)
  install(TARGETS c3rt_package_${room} EXPORT c3rtTargets
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library)
endfunction()

# c3rt_export(ROOM HEADERS file... [DEPS room...] [ARCHIVES file...]): a room of controller/ and its public headers
function(c3rt_export room)
  cmake_parse_arguments(arg "" "" "HEADERS;DEPS;ARCHIVES" ${ARGN})
  c3rt_package_archive(${room} BY_CALLER ${allocates_by_caller} TYPES 0 OBJECTS $<TARGET_OBJECTS:c3rt_${room}>
    ARCHIVES ${arg_ARCHIVES})
  list(TRANSFORM arg_DEPS PREPEND c3rt_package_)
  target_link_libraries(c3rt_package_${room} INTERFACE ${arg_DEPS} Eigen3::Eigen)
  if(arg_ARCHIVES)
    target_link_libraries(c3rt_package_${room} INTERFACE m dl)
  endif()
  c3rt_export_headers(${room} HEADERS ${arg_HEADERS})
endfunction()

# the public headers of a room, all that there is of one that has only headers
function(c3rt_export_headers room)
  cmake_parse_arguments(arg "" "" "HEADERS" ${ARGN})
  install(CODE "
    set(from \"${PROJECT_SOURCE_DIR}\")
    set(to \"${CMAKE_INSTALL_INCLUDEDIR}\")
    set(headers ${arg_HEADERS})
    list(TRANSFORM headers PREPEND controller/${room}/)
    include(\"${PROJECT_SOURCE_DIR}/cmake/install_headers.cmake\")" COMPONENT library)
  list(TRANSFORM arg_HEADERS PREPEND controller/${room}/)
  set_property(GLOBAL APPEND PROPERTY c3rt_public_headers ${arg_HEADERS})
endfunction()

# A public header may include only public headers: a room's new header that is missing from the list ends the configuring.
function(c3rt_check_public_headers)
  get_property(public GLOBAL PROPERTY c3rt_public_headers)
  foreach(header ${public})
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${header})
    file(STRINGS ${PROJECT_SOURCE_DIR}/${header} includes REGEX "^#include \"controller/")
    foreach(include ${includes})
      string(REGEX REPLACE "^#include \"([^\"]+)\".*" "\\1" included "${include}")
      if(NOT included IN_LIST public)
        message(FATAL_ERROR "${header} is a header of the package and includes ${included}, which is not: name it in cmake/package.cmake")
      endif()
    endforeach()
  endforeach()
endfunction()

c3rt_export(lcs HEADERS acceptance.hpp dictionary.hpp double_double.hpp lcs.hpp lemke.hpp riccati.hpp simulate.hpp step.hpp)
c3rt_export(qp HEADERS kernels.hpp node_qp.hpp problem.hpp qp.hpp qp_cost.hpp qp_rows.hpp riccati.hpp
  DEPS lcs ARCHIVES ${C3RT_THIRD_PARTY}/lib/libosqp.a)
c3rt_export(c3 HEADERS consensus.hpp deadline.hpp fixed_modes.hpp known_plan.hpp parallel.hpp polish.hpp problem.hpp projection.hpp projection/registry.hpp solver.hpp
  DEPS qp lcs)
c3rt_export(horizon HEADERS condensed.hpp feedback.hpp modes.hpp problem.hpp search.hpp DEPS c3 qp lcs)
c3rt_export(scene HEADERS distance.hpp mechanism.hpp object.hpp scene.hpp shape.hpp)
c3rt_export(model HEADERS ball_model.hpp balls_model.hpp between.hpp block_errors.hpp cart_pole.hpp contact_model.hpp contact_system.hpp
  finger_gaiting.hpp linearise.hpp mechanism_model.hpp objects_model.hpp pivoting.hpp planning_model.hpp pushed_box.hpp registry.hpp support_points.hpp system_model.hpp
  DEPS lcs
  scene)
c3rt_export(example HEADERS closed_loop.hpp controller.hpp experiment.hpp DEPS c3 model lcs)
c3rt_check_public_headers()

# the client: its room and all that it stands on, in one archive. No header of it names Eigen
set(objects "")
foreach(room client wire topic_types rt)
  list(APPEND objects $<TARGET_OBJECTS:c3rt_${room}>)
endforeach()
c3rt_package_archive(client BY_CALLER 0 TYPES 1 OBJECTS ${objects})
target_link_libraries(c3rt_package_client INTERFACE CycloneDDS::ddsc pthread dl)
foreach(header client/client.hpp client/estimator.hpp client/motion.hpp client/mover.hpp client/planner.hpp client/process.hpp dds.hpp topics.hpp validate.hpp)
  get_filename_component(folder ${header} DIRECTORY)
  install(FILES ${PROJECT_SOURCE_DIR}/idl/${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/idl/${folder} COMPONENT library)
endforeach()
# the types of the IDL
get_target_property(types c3rt_topic_types BINARY_DIR)
install(FILES ${types}/c3rt.h ${types}/c3rt_fields.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT library)

set(package_directory ${CMAKE_INSTALL_LIBDIR}/cmake/c3rt)
install(EXPORT c3rtTargets NAMESPACE c3rt:: DESTINATION ${package_directory} COMPONENT library)
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/c3rtConfig.cmake.in ${PROJECT_BINARY_DIR}/c3rtConfig.cmake
  INSTALL_DESTINATION ${package_directory} NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/c3rtConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/c3rtConfig.cmake ${PROJECT_BINARY_DIR}/c3rtConfigVersion.cmake
  DESTINATION ${package_directory} COMPONENT library)
# builds what the component holds, from objects that the programs have anyway
add_custom_target(library
  DEPENDS c3rt_package_lcs c3rt_package_qp c3rt_package_c3 c3rt_package_horizon c3rt_package_scene c3rt_package_model
    c3rt_package_example c3rt_package_client)
add_dependencies(programs library)
