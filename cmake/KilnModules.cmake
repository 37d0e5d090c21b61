# Modules, which the program loads when it needs them (base/module.h): it starts without them, and find_package(kiln) does
# not ask for what they link. They lie beside the library, where programs of this build and installed ones look.
set(kiln_module_options -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion -fvisibility=hidden)

# GDCM, for compressed DICOM. Its own CMake files name programs of packages that are not needed, and complain that they are
# not there.
find_path(GDCM_INCLUDE_DIR gdcmReader.h PATH_SUFFIXES gdcm-3.2 gdcm-3.0)
foreach(kiln_library gdcmMSFF gdcmDSED gdcmCommon)
  find_library(GDCM_${kiln_library} ${kiln_library})
endforeach()
if(NOT GDCM_INCLUDE_DIR OR NOT GDCM_gdcmMSFF OR NOT GDCM_gdcmDSED OR NOT GDCM_gdcmCommon)
  message(FATAL_ERROR "Kiln needs packages that were not found: GDCM (Debian: libgdcm-dev)")
endif()
add_library(kiln_gdcm_libraries INTERFACE)
target_include_directories(kiln_gdcm_libraries SYSTEM INTERFACE ${GDCM_INCLUDE_DIR})
target_link_libraries(kiln_gdcm_libraries INTERFACE ${GDCM_gdcmMSFF} ${GDCM_gdcmDSED} ${GDCM_gdcmCommon})
add_library(kiln_gdcm MODULE src/ingest/gdcm_frames.cpp)
target_compile_features(kiln_gdcm PRIVATE cxx_std_20)
target_compile_options(kiln_gdcm PRIVATE ${kiln_module_options})
target_include_directories(kiln_gdcm PRIVATE src)
target_link_libraries(kiln_gdcm PRIVATE glm::glm kiln_gdcm_libraries)
set_source_files_properties(src/ingest/dicom_decode.cpp PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON
  COMPILE_DEFINITIONS KILN_GDCM_MODULE="$<TARGET_FILE_NAME:kiln_gdcm>")
add_dependencies(kiln kiln_gdcm)
set(kiln_modules kiln_gdcm)

# Open MPI, or another MPI 3: what makes `mpirun kiln` work together. MPI_FOUND says whether there is this module.
if(NOT KILN_MPI STREQUAL "OFF")
  if(KILN_MPI STREQUAL "ON")
    find_package(MPI 3.0 REQUIRED COMPONENTS CXX)
  else()
    find_package(MPI 3.0 QUIET COMPONENTS CXX)
    if(NOT MPI_FOUND)
      message(STATUS "No MPI was found (Debian: libopenmpi-dev): kiln works on one machine")
    endif()
  endif()
endif()
if(MPI_FOUND)
  add_library(kiln_mpi MODULE src/cluster/mpi_ranks.cpp)
  target_compile_options(kiln_mpi PRIVATE ${kiln_module_options})
  target_link_libraries(kiln_mpi PRIVATE kiln MPI::MPI_CXX)
  set_source_files_properties(src/cluster/mpi_module.cpp PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON
    COMPILE_DEFINITIONS KILN_MPI_MODULE="$<TARGET_FILE_NAME:kiln_mpi>")
  list(APPEND kiln_modules kiln_mpi)
endif()
