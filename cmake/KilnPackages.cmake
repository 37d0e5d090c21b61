# Packages for Debian: `cpack -G DEB --config BUILD/CPackConfig.cmake` makes one of each component that is installed
# (KilnInstall.cmake). What the programs link is found by dpkg-shlibdeps. MPI's module is a package of its own, because
# Open MPI brings 70 MB that one machine does not need.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME kiln)
set(CPACK_PACKAGE_VENDOR "Kiln")
set(CPACK_PACKAGE_CONTACT "${KILN_MAINTAINER}")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each package has its own
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)

set(CPACK_COMPONENTS_ALL program development)
if(TARGET kiln_mpi)
  list(APPEND CPACK_COMPONENTS_ALL mpi)
endif()
if(TARGET kiln_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
# Documents that Debian asks for, and paths that only Debian has.
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_LIST_DIR}/debian/staged_files.cmake)

set(same_version "(= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})")
set(about "Kiln converts a volume, such as a scan or a simulation, to a store of bricks,\nand draws pictures and videos of the store within a given amount of memory.\nIt needs no graphics card and no window system.\n")

set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME kiln)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "kiln-mpi, python3-kiln, ffmpeg, xdg-utils")
set(CPACK_DEBIAN_PROGRAM_DESCRIPTION "renderer for scalar volumes larger than memory\n${about}")

set(CPACK_DEBIAN_MPI_PACKAGE_NAME kiln-mpi)
set(CPACK_DEBIAN_MPI_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_MPI_PACKAGE_DEPENDS "kiln ${same_version}, openmpi-bin")
set(CPACK_DEBIAN_MPI_DESCRIPTION "renderer for volumes larger than memory - many machines\n${about}\nThis package holds the module with which the ranks of mpirun work together.")

# A static library leaves its dependencies to the program that links it.
list(JOIN kiln_library_debian ", " library_packages)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libkiln-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "kiln ${same_version}, pkg-config, ${library_packages}")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SUGGESTS cmake)
set(CPACK_DEBIAN_DEVELOPMENT_DESCRIPTION "renderer for volumes larger than memory - C++ library\n${about}\nThis package holds the static library, its headers and files for CMake.")

set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-kiln)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
if(TARGET kiln_python)
  math(EXPR next_minor "${Python3_VERSION_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "kiln ${same_version}, python3 (>= ${Python3_VERSION_MAJOR}.${Python3_VERSION_MINOR}~), python3 (<< ${Python3_VERSION_MAJOR}.${next_minor}), python3-numpy")
endif()
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${CMAKE_CURRENT_LIST_DIR}/debian/postinst ${CMAKE_CURRENT_LIST_DIR}/debian/prerm)
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PYTHON_DESCRIPTION "renderer for volumes larger than memory - Python 3 module\n${about}\nThis package holds the module kiln, which draws arrays and stores as arrays.")

include(CPack)
