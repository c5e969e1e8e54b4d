# cmake --install: the program, the library with its headers, and the package that find_package(Roomwise) finds.
# Included when all modules are declared. Components: program, library, laboratory, python, licence.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/Roomwise)

get_property(modules GLOBAL PROPERTY ROOMWISE_MODULES)
foreach(module ${modules})
  string(REPLACE roomwise_ "" name ${module})
  set_target_properties(${module} PROPERTIES EXPORT_NAME ${name})
endforeach()
install(TARGETS ${modules} EXPORT RoomwiseTargets COMPONENT library)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/roomwise DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT library
  FILES_MATCHING PATTERN "*.h"
  # What only the tests use.
  PATTERN testing EXCLUDE)

install(EXPORT RoomwiseTargets NAMESPACE Roomwise:: DESTINATION ${package_dir} COMPONENT library)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/RoomwiseConfig.cmake.in
  ${PROJECT_BINARY_DIR}/RoomwiseConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/RoomwiseConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES
  ${PROJECT_BINARY_DIR}/RoomwiseConfig.cmake
  ${PROJECT_BINARY_DIR}/RoomwiseConfigVersion.cmake
  ${CMAKE_CURRENT_LIST_DIR}/FindFFmpeg.cmake
  ${CMAKE_CURRENT_LIST_DIR}/FindLibZip.cmake
  ${CMAKE_CURRENT_LIST_DIR}/FindLZ4.cmake
  ${CMAKE_CURRENT_LIST_DIR}/FindZstd.cmake
  ${CMAKE_CURRENT_LIST_DIR}/FindOneDNN.cmake
  ${CMAKE_CURRENT_LIST_DIR}/FindOpenCVModules.cmake
  ${CMAKE_CURRENT_LIST_DIR}/FindOpenNI2.cmake
  ${CMAKE_CURRENT_LIST_DIR}/FindPQ.cmake
  ${CMAKE_CURRENT_LIST_DIR}/FindSodium.cmake
  ${CMAKE_CURRENT_LIST_DIR}/FindWebP.cmake
  ${CMAKE_CURRENT_LIST_DIR}/FindSpeechd.cmake
  DESTINATION ${package_dir} COMPONENT library)
install(DIRECTORY ${PROJECT_BINARY_DIR}/share/roomwise DESTINATION ${CMAKE_INSTALL_DATADIR} COMPONENT program PATTERN labelling EXCLUDE)
if(ROOMWISE_LAB AND ROOMWISE_BUILD_WEB)
  install(DIRECTORY ${PROJECT_BINARY_DIR}/share/roomwise/labelling DESTINATION ${CMAKE_INSTALL_DATADIR}/roomwise COMPONENT laboratory)
endif()
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT licence)
