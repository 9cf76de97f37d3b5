# Packages for Debian and Ubuntu: .ci/package, or `cpack -G DEB` in a build folder in which all is built.
#   credence            the program, its manual, completion
#   libcredence-dev     libraries, headers, find_package(Credence)
#   credence-mpi        what the program loads under mpirun, where an MPI is installed
#   python3-credence    the Python module, where it is built

set(CPACK_PACKAGE_NAME credence)
set(CPACK_PACKAGE_CONTACT "Credence developers <credence@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY ${PROJECT_DESCRIPTION})
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL runtime development)
if(TARGET credence_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
if(TARGET credence_mpi)
  list(APPEND CPACK_COMPONENTS_ALL mpi)
endif()

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME credence)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libcredence-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "libeigen3-dev, libboost-dev, libtbb-dev, libfmt-dev, nlohmann-json3-dev, \
libsqlite3-dev, zlib1g-dev, libbz2-dev, liblz4-dev, libzstd-dev, libtomlplusplus-dev, libcairo2-dev, \
libnlopt-cxx-dev, pkg-config")
set(CPACK_DEBIAN_MPI_PACKAGE_NAME credence-mpi)
set(CPACK_DEBIAN_MPI_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_MPI_PACKAGE_DEPENDS "credence (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-credence)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
if(TARGET credence_python)
  math(EXPR next_minor "${CREDENCE_PYTHON_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3 (>= ${CREDENCE_PYTHON_MAJOR}.${CREDENCE_PYTHON_MINOR}), \
python3 (<< ${CREDENCE_PYTHON_MAJOR}.${next_minor}), python3-numpy")
endif()
set(CPACK_COMPONENT_RUNTIME_DESCRIPTION "Credence tells whether a filter's covariance can be trusted: the program.")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "Libraries and headers, to judge a filter of one's own in C++.")
set(CPACK_COMPONENT_MPI_DESCRIPTION "What the program loads under mpirun, to share a study among machines.")
set(CPACK_COMPONENT_PYTHON_DESCRIPTION "The Python module, to judge arrays and filters written in Python.")
include(CPack)
