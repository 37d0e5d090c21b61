# Install and export, so that find_package(kiln) gives kiln::kiln. The dependencies' bundle is not exported: an installed
# kilnConfig makes it anew with the same file that this build uses. Components are packages (KilnPackages.cmake).
include(CMakePackageConfigHelpers)
set(kiln_config_dir ${CMAKE_INSTALL_LIBDIR}/cmake/kiln)

target_include_directories(kiln PUBLIC $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>
                                       $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/kiln>)
install(TARGETS kiln EXPORT kilnTargets LIBRARY COMPONENT program NAMELINK_COMPONENT development ARCHIVE COMPONENT development
        FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/kiln COMPONENT development)
install(TARGETS kiln_tool RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
# A program that links the library finds the modules: a static library is no place to look from.
target_link_options(kiln INTERFACE $<INSTALL_INTERFACE:LINKER:-rpath,$<INSTALL_PREFIX>/${kiln_module_dir}>)
foreach(module ${kiln_modules})
  set(component program)
  if(module STREQUAL "kiln_mpi")
    set(component mpi)
  endif()
  install(TARGETS ${module} LIBRARY DESTINATION ${kiln_module_dir} COMPONENT ${component})
endforeach()
install(TARGETS ${kiln_workers} RUNTIME DESTINATION ${kiln_module_dir} COMPONENT program)
install(DIRECTORY ${PROJECT_BINARY_DIR}/tools/kiln/share/ DESTINATION ${CMAKE_INSTALL_DATADIR} COMPONENT program)
# The installed README links what is installed; names of source files remain as text.
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS README.md)
file(READ README.md readme)
string(REPLACE "](tools/kiln/manual/" "](manual/" readme "${readme}")
string(REPLACE "](tests/pictures/" "](pictures/" readme "${readme}")
string(REGEX REPLACE "\\[([^]\n]*)\\]\\((src|tests)/[^)]*\\)" "\\1" readme "${readme}")
file(WRITE ${PROJECT_BINARY_DIR}/README.md "${readme}")
install(FILES ${PROJECT_BINARY_DIR}/README.md LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)
install(FILES tests/pictures/head.png DESTINATION ${CMAKE_INSTALL_DOCDIR}/pictures COMPONENT program)
install(DIRECTORY tools/kiln/manual DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)
install(EXPORT kilnTargets NAMESPACE kiln:: DESTINATION ${kiln_config_dir} COMPONENT development)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/kilnConfig.cmake.in ${PROJECT_BINARY_DIR}/kilnConfig.cmake
                              INSTALL_DESTINATION ${kiln_config_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/kilnConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/kilnConfig.cmake ${PROJECT_BINARY_DIR}/kilnConfigVersion.cmake
              ${CMAKE_CURRENT_LIST_DIR}/KilnDependencies.cmake ${CMAKE_CURRENT_LIST_DIR}/KilnFind.cmake
        DESTINATION ${kiln_config_dir} COMPONENT development)
