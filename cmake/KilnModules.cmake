# Modules, which the program loads when it needs them (base/module.h): it starts without them, and find_package(kiln) does
# not look for what they link. They lie beside the library, where programs of this build and installed programs look.
set(kiln_module_options -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion -fvisibility=hidden)

# GDCM, for compressed DICOM.
add_library(kiln_gdcm_libraries INTERFACE)
target_include_directories(kiln_gdcm_libraries SYSTEM INTERFACE ${GDCM_INCLUDE_DIR})
target_link_libraries(kiln_gdcm_libraries INTERFACE ${GDCM_gdcmMSFF} ${GDCM_gdcmDSED} ${GDCM_gdcmCommon})
add_library(kiln_gdcm MODULE src/ingest/dicom/gdcm_frames.cpp)
target_compile_features(kiln_gdcm PRIVATE cxx_std_20)
target_compile_options(kiln_gdcm PRIVATE ${kiln_module_options})
target_include_directories(kiln_gdcm PRIVATE src)
target_link_libraries(kiln_gdcm PRIVATE glm::glm kiln_gdcm_libraries)
set_source_files_properties(src/ingest/dicom/dicom_decode.cpp PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON
  COMPILE_DEFINITIONS KILN_GDCM_MODULE="$<TARGET_FILE_NAME:kiln_gdcm>")
add_dependencies(kiln kiln_gdcm)
set(kiln_modules kiln_gdcm)

# A program that runs the HDF5 library apart from Kiln, which survives what a hostile file does to the library.
if(HDF5_READER_FOUND)
  add_executable(kiln_hdf5_reader tools/hdf5_reader/main.cpp)
  target_compile_features(kiln_hdf5_reader PRIVATE cxx_std_20)
  target_compile_definitions(kiln_hdf5_reader PRIVATE H5_USE_110_API)  # newer libraries have it, too
  target_compile_options(kiln_hdf5_reader PRIVATE ${kiln_module_options})
  target_include_directories(kiln_hdf5_reader PRIVATE src)
  target_include_directories(kiln_hdf5_reader SYSTEM PRIVATE ${HDF5_READER_INCLUDE_DIR})
  target_link_libraries(kiln_hdf5_reader PRIVATE ${HDF5_READER_LIBRARY} nlohmann_json::nlohmann_json)
  add_dependencies(kiln kiln_hdf5_reader)
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
