# c3rt::door, for a program of others that takes the plant's place on the bus (examples/real_robot): bus, session, requests,
# status, the robot's modes and limits, scenarios, and the emulated arm. Here an interface of the rooms' own targets; installed
# (cmake --install <build> --component door, beside the component library) one archive of their objects. Such a program is
# compiled for the same vector unit as the package, as c3rt::door shares Eigen's types with it, and links no other target of it.
set(rooms topic_types wire rt config process_options scene mjcf mujoco_scene pushes start plant plant_config plant_node)
add_library(c3rt_door INTERFACE)
add_library(c3rt::door ALIAS c3rt_door)
target_link_libraries(c3rt_door INTERFACE c3rt::plant_node c3rt::plant_config c3rt::process_options c3rt::rt c3rt::wire)

set(objects "")
foreach(room ${rooms})
  list(APPEND objects $<TARGET_OBJECTS:c3rt_${room}>)
endforeach()
add_library(c3rt_package_door STATIC EXCLUDE_FROM_ALL ${objects})
set_target_properties(c3rt_package_door PROPERTIES EXPORT_NAME door OUTPUT_NAME c3rt_door LINKER_LANGUAGE CXX
  ARCHIVE_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/package)
set(door_headers ${CMAKE_INSTALL_INCLUDEDIR}/c3rt/door)
target_include_directories(c3rt_package_door INTERFACE $<INSTALL_INTERFACE:${door_headers}>)
target_link_libraries(c3rt_package_door INTERFACE CycloneDDS::ddsc Eigen3::Eigen Threads::Threads yaml-cpp mujoco
  ${CMAKE_DL_LIBS})
target_compile_features(c3rt_package_door INTERFACE cxx_std_17)
install(TARGETS c3rt_package_door EXPORT c3rtDoor ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT door EXCLUDE_FROM_ALL)
install(EXPORT c3rtDoor NAMESPACE c3rt:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/c3rt COMPONENT door EXCLUDE_FROM_ALL)
foreach(folder idl config plant_emulator controller/base controller/rt controller/scene controller/task)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${folder}/ DESTINATION ${door_headers}/${folder} COMPONENT door EXCLUDE_FROM_ALL
    FILES_MATCHING PATTERN "*.hpp")
endforeach()
install(FILES ${PROJECT_BINARY_DIR}/idl/c3rt.h ${PROJECT_BINARY_DIR}/idl/c3rt_fields.h DESTINATION ${door_headers}
  COMPONENT door EXCLUDE_FROM_ALL)
add_custom_target(door DEPENDS c3rt_package_door)
