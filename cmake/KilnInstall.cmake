# Install and export, so that find_package(kiln) gives kiln::kiln. The dependencies' bundle is not exported: an installed
# kilnConfig makes it anew with the same file that this build uses.
include(CMakePackageConfigHelpers)
set(kiln_config_dir ${CMAKE_INSTALL_LIBDIR}/cmake/kiln)

target_include_directories(kiln PUBLIC $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>
                                       $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/kiln>)
install(TARGETS kiln EXPORT kilnTargets FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/kiln)
# Built as a shared library, Kiln is found beside the program, wherever the prefix lies.
file(RELATIVE_PATH kiln_lib_from_bin /${CMAKE_INSTALL_BINDIR} /${CMAKE_INSTALL_LIBDIR})
set_target_properties(kiln_tool PROPERTIES INSTALL_RPATH $ORIGIN/${kiln_lib_from_bin})
install(TARGETS kiln_tool RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
# Modules lie beside the library: whoever links it looks for them there, as a static library is no place to look from.
set_target_properties(kiln ${kiln_modules} PROPERTIES INSTALL_RPATH $ORIGIN)
target_link_options(kiln INTERFACE $<INSTALL_INTERFACE:LINKER:-rpath,$<INSTALL_PREFIX>/${CMAKE_INSTALL_LIBDIR}>)
install(TARGETS ${kiln_modules} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY ${PROJECT_BINARY_DIR}/tools/kiln/share/ DESTINATION ${CMAKE_INSTALL_DATADIR})
install(EXPORT kilnTargets NAMESPACE kiln:: DESTINATION ${kiln_config_dir})
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/kilnConfig.cmake.in ${PROJECT_BINARY_DIR}/kilnConfig.cmake
                              INSTALL_DESTINATION ${kiln_config_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/kilnConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/kilnConfig.cmake ${PROJECT_BINARY_DIR}/kilnConfigVersion.cmake
              ${CMAKE_CURRENT_LIST_DIR}/KilnDependencies.cmake DESTINATION ${kiln_config_dir})
