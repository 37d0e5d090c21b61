# Folders in which programs and modules look for libraries (DT_RUNPATH). The build tree is laid out as an install tree is, so
# that an installed file has the same run path as a built one: relative to itself, wherever the prefix lies. A run path that
# CMake replaces while it installs has a colon at its end in the build tree, and the loader takes the empty element behind
# a colon for the working directory. Modules and workers have a folder of their own: none is a library to link.
set(kiln_module_dir ${CMAKE_INSTALL_LIBDIR}/kiln)
file(RELATIVE_PATH kiln_lib_from_bin ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR})
set(kiln_lib_folder ${PROJECT_BINARY_DIR}/tools/kiln/${kiln_lib_from_bin})
cmake_path(NORMAL_PATH kiln_lib_folder)
set(kiln_module_folder ${kiln_lib_folder}/kiln)
set_target_properties(kiln PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${kiln_lib_folder} INSTALL_RPATH $ORIGIN/kiln)
set_target_properties(kiln_tool PROPERTIES INSTALL_RPATH $ORIGIN/${kiln_lib_from_bin}/kiln)
if(kiln_modules)
  set_target_properties(${kiln_modules} PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${kiln_module_folder} INSTALL_RPATH $ORIGIN)
endif()
set_target_properties(${kiln_workers} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${kiln_module_folder})
if(BUILD_SHARED_LIBS)
  set_property(TARGET kiln_tool APPEND PROPERTY INSTALL_RPATH $ORIGIN/${kiln_lib_from_bin})
  set_property(TARGET ${kiln_modules} APPEND PROPERTY INSTALL_RPATH $ORIGIN/..)
endif()
# Libraries outside the system's folders, such as an MPI in /opt, are found where they were linked.
set_target_properties(kiln kiln_tool ${kiln_workers} ${kiln_modules} PROPERTIES BUILD_WITH_INSTALL_RPATH ON INSTALL_RPATH_USE_LINK_PATH ON)
# Tests and benchmarks are not installed.
set(CMAKE_BUILD_RPATH ${kiln_module_folder})
