# Install and export, so that find_package(kiln) gives kiln::kiln. The dependencies' bundle is not exported: an installed
# kilnConfig makes it anew with the same file that this build uses.
include(CMakePackageConfigHelpers)
set(kiln_config_dir ${CMAKE_INSTALL_LIBDIR}/cmake/kiln)

target_include_directories(kiln PUBLIC $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>
                                       $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/kiln>)
install(TARGETS kiln EXPORT kilnTargets FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/kiln)
install(TARGETS kiln_tool RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
# Whoever links the library looks for its modules beside it: a static library is no place to look from.
target_link_options(kiln INTERFACE $<INSTALL_INTERFACE:LINKER:-rpath,$<INSTALL_PREFIX>/${CMAKE_INSTALL_LIBDIR}>)
if(kiln_modules)
  install(TARGETS ${kiln_modules} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
endif()
install(TARGETS ${kiln_workers} RUNTIME DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY ${PROJECT_BINARY_DIR}/tools/kiln/share/ DESTINATION ${CMAKE_INSTALL_DATADIR})
install(FILES README.md LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY tools/kiln/manual DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(EXPORT kilnTargets NAMESPACE kiln:: DESTINATION ${kiln_config_dir})
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/kilnConfig.cmake.in ${PROJECT_BINARY_DIR}/kilnConfig.cmake
                              INSTALL_DESTINATION ${kiln_config_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/kilnConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/kilnConfig.cmake ${PROJECT_BINARY_DIR}/kilnConfigVersion.cmake
              ${CMAKE_CURRENT_LIST_DIR}/KilnDependencies.cmake ${CMAKE_CURRENT_LIST_DIR}/KilnFind.cmake DESTINATION ${kiln_config_dir})
