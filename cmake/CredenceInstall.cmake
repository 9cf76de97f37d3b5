# find_package(Credence) for those who link the library, and what those who type commands need.
# Components: runtime (the program, its manual and completion), development (libraries, headers), python.

include(CMakePackageConfigHelpers)

set(libraries core montecarlo analysis datasets reports)
list(TRANSFORM libraries PREPEND credence_ OUTPUT_VARIABLE targets)
install(TARGETS credence_options ${targets} EXPORT CredenceTargets COMPONENT development)
# Which headers are public, is seen when they are installed: they may have changed since the configuration.
install(CODE "
  include(${CMAKE_CURRENT_LIST_DIR}/CredencePublicHeaders.cmake)
  credence_public_headers(${PROJECT_SOURCE_DIR} headers)
  foreach(header \${headers})
    get_filename_component(folder \${header} DIRECTORY)
    file(INSTALL ${PROJECT_SOURCE_DIR}/\${header}
         DESTINATION \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_INCLUDEDIR}/credence/\${folder}\")
  endforeach()" COMPONENT development)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/Credence)
install(EXPORT CredenceTargets NAMESPACE Credence:: DESTINATION ${package_dir} COMPONENT development)
configure_package_config_file(cmake/CredenceConfig.cmake.in CredenceConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(CredenceConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/CredenceConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/CredenceConfigVersion.cmake
        DESTINATION ${package_dir} COMPONENT development)
# Of these names for find_package(credence).
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/CredenceConfig.cmake DESTINATION ${package_dir}
        RENAME credence-config.cmake COMPONENT development)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/CredenceConfigVersion.cmake DESTINATION ${package_dir}
        RENAME credence-config-version.cmake COMPONENT development)

install(TARGETS credence COMPONENT runtime)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/credence RENAME copyright
        COMPONENT runtime)
