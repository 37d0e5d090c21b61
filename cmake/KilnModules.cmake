# Modules, which the program loads when it needs them (base/module.h), and workers, which it starts (base/worker_process.h):
# it starts without them, and find_package(kiln) does not look for what they link. They lie in lib/kiln, where
# programs of this build and installed programs look.
set(kiln_module_options -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion -fvisibility=hidden)
set(kiln_modules)

add_library(kiln_worker_loop STATIC src/base/worker_loop.cpp)
target_compile_features(kiln_worker_loop PUBLIC cxx_std_20)
target_compile_options(kiln_worker_loop PRIVATE ${kiln_module_options})
target_include_directories(kiln_worker_loop PUBLIC src)

# Adds the worker tools/NAME/main.cpp and the libraries that a hostile file may crash.
set(kiln_workers)
macro(kiln_add_worker name)
  add_executable(kiln_${name} tools/${name}/main.cpp)
  target_compile_options(kiln_${name} PRIVATE ${kiln_module_options})
  target_link_libraries(kiln_${name} PRIVATE kiln_worker_loop ${ARGN})
  if(NOT kiln_below_drawing)
    add_dependencies(kiln kiln_${name})
  endif()
  list(APPEND kiln_workers kiln_${name})
endmacro()

# GDCM, for compressed DICOM.
add_library(kiln_gdcm_libraries INTERFACE)
target_include_directories(kiln_gdcm_libraries SYSTEM INTERFACE ${GDCM_INCLUDE_DIR})
target_link_libraries(kiln_gdcm_libraries INTERFACE ${GDCM_gdcmMSFF} ${GDCM_gdcmDSED} ${GDCM_gdcmCommon})
kiln_add_worker(gdcm_reader kiln_gdcm_libraries)

if(HDF5_READER_FOUND)
  kiln_add_worker(hdf5_reader ${HDF5_READER_LIBRARY} nlohmann_json::nlohmann_json)
  target_compile_options(kiln_hdf5_reader PRIVATE -Og)  # JSON is most of what there is to optimise
  target_compile_definitions(kiln_hdf5_reader PRIVATE H5_USE_110_API)  # newer libraries have it, too
  target_include_directories(kiln_hdf5_reader SYSTEM PRIVATE ${HDF5_READER_INCLUDE_DIR})
endif()

if(OPENJPEG_READER_FOUND)
  kiln_add_worker(openjpeg_reader ${OPENJPEG_READER_LIBRARY})
  target_include_directories(kiln_openjpeg_reader SYSTEM PRIVATE ${OPENJPEG_READER_INCLUDE_DIR})
endif()

# Open MPI or another MPI 3, with which the ranks of `mpirun kiln` work together.
if(MPI_FOUND)
  add_library(kiln_mpi MODULE src/cluster/mpi_ranks.cpp)
  target_compile_options(kiln_mpi PRIVATE ${kiln_module_options})
  target_link_libraries(kiln_mpi PRIVATE kiln MPI::MPI_CXX)
  set_source_files_properties(src/cluster/mpi_module.cpp PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON
    COMPILE_DEFINITIONS KILN_MPI_MODULE="$<TARGET_FILE_NAME:kiln_mpi>")
  list(APPEND kiln_modules kiln_mpi)
endif()

# The HTTP server of `kiln view`, on Boost.Beast, with the files of its page.
if(BEAST_FOUND)
  set(kiln_page ${PROJECT_SOURCE_DIR}/tools/kiln/view/page)
  set(kiln_page_source ${PROJECT_BINARY_DIR}/kiln_page/page_files.cpp)
  file(GLOB kiln_page_files CONFIGURE_DEPENDS ${kiln_page}/*.html ${kiln_page}/*.js ${kiln_page}/*.css ${kiln_page}/*.svg)
  add_custom_command(OUTPUT ${kiln_page_source} DEPENDS ${kiln_page_files} ${PROJECT_SOURCE_DIR}/cmake/embed_page.cmake VERBATIM
    COMMAND ${CMAKE_COMMAND} -D FOLDER=${kiln_page} -D OUT=${kiln_page_source} -P ${PROJECT_SOURCE_DIR}/cmake/embed_page.cmake)
  add_library(kiln_view MODULE src/view/http_server.cpp ${kiln_page_source})
  # Beast compiles half a minute without what a server of one user needs: speed.
  target_compile_options(kiln_view PRIVATE ${kiln_module_options} -O1)
  target_compile_definitions(kiln_view PRIVATE BOOST_ASIO_NO_DEPRECATED BOOST_ASIO_DISABLE_CONCEPTS)
  target_include_directories(kiln_view SYSTEM PRIVATE ${BEAST_INCLUDE_DIR})
  target_link_libraries(kiln_view PRIVATE kiln)
  set_target_properties(kiln_view PROPERTIES UNITY_BUILD OFF)
  set_source_files_properties(src/view/view_module.cpp PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON
    COMPILE_DEFINITIONS KILN_VIEW_MODULE="$<TARGET_FILE_NAME:kiln_view>")
  list(APPEND kiln_modules kiln_view)
endif()

# The font of annotations: FreeType, with DejaVu Sans compiled in.
if(FONT_FOUND)
  add_library(kiln_font MODULE src/annotate/freetype_font.cpp)
  target_compile_options(kiln_font PRIVATE ${kiln_module_options})
  target_compile_definitions(kiln_font PRIVATE KILN_FONT_FILE="${KILN_FONT_FILE}")
  set_source_files_properties(src/annotate/freetype_font.cpp PROPERTIES OBJECT_DEPENDS ${KILN_FONT_FILE})
  target_link_libraries(kiln_font PRIVATE kiln Freetype::Freetype)
  set_target_properties(kiln_font PROPERTIES UNITY_BUILD OFF)
  set_source_files_properties(src/annotate/font_module.cpp PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON
    COMPILE_DEFINITIONS KILN_FONT_MODULE="$<TARGET_FILE_NAME:kiln_font>")
  list(APPEND kiln_modules kiln_font)
endif()
