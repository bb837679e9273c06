# What `cmake --install` lays down: the libraries with their headers as an exported package, so that
# another project can find_package(slammot), and what the program reads at run time.
include(CMakePackageConfigHelpers)

set(SLAMMOT_CMAKE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/slammot)

get_property(libraries GLOBAL PROPERTY SLAMMOT_LIBRARIES)
install(TARGETS ${libraries} slammot_blas EXPORT slammotTargets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT slammotTargets NAMESPACE slammot:: DESTINATION ${SLAMMOT_CMAKE_DIR})

set(SLAMMOT_SHARE_DIR ${CMAKE_INSTALL_DATADIR}/slammot)
configure_package_config_file(
  ${CMAKE_CURRENT_LIST_DIR}/slammotConfig.cmake.in ${PROJECT_BINARY_DIR}/slammotConfig.cmake
  INSTALL_DESTINATION ${SLAMMOT_CMAKE_DIR} PATH_VARS SLAMMOT_SHARE_DIR)
write_basic_package_version_file(
  ${PROJECT_BINARY_DIR}/slammotConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/slammotConfig.cmake
              ${PROJECT_BINARY_DIR}/slammotConfigVersion.cmake
        DESTINATION ${SLAMMOT_CMAKE_DIR})

install(CODE "
  set(source [[${PROJECT_SOURCE_DIR}]])
  set(destination [[${CMAKE_INSTALL_INCLUDEDIR}/slammot]])")
install(SCRIPT ${CMAKE_CURRENT_LIST_DIR}/InstallHeaders.cmake)

install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME copyright)
install(FILES ${PROJECT_SOURCE_DIR}/CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME changelog)

# Not byte code; studies only once there are some.
install(DIRECTORY ${PROJECT_SOURCE_DIR}/eval/studies
        DESTINATION ${CMAKE_INSTALL_DATADIR}/slammot OPTIONAL PATTERN "__pycache__" EXCLUDE)
