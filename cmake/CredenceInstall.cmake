# find_package(Credence) for those who link the library.

include(CMakePackageConfigHelpers)

set(libraries core montecarlo analysis datasets reports)
list(TRANSFORM libraries PREPEND credence_ OUTPUT_VARIABLE targets)
install(TARGETS credence_options ${targets} EXPORT CredenceTargets)
install(TARGETS credence)
foreach(folder ${libraries})
  install(DIRECTORY ${folder} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/credence FILES_MATCHING PATTERN "*.h")
endforeach()
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/Credence)
install(EXPORT CredenceTargets NAMESPACE Credence:: DESTINATION ${package_dir})
configure_package_config_file(cmake/CredenceConfig.cmake.in CredenceConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(CredenceConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/CredenceConfig.cmake
              ${CMAKE_CURRENT_BINARY_DIR}/CredenceConfigVersion.cmake DESTINATION ${package_dir})
