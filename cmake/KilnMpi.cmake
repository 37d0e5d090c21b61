# Open MPI, or another MPI 3: the module that makes `mpirun kiln` work together. The library and the program do not link it, so
# that they start without it and find_package(kiln) does not ask for it. MPI_FOUND says whether the module is built.
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
  target_compile_options(kiln_mpi PRIVATE -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion -fvisibility=hidden)
  target_link_libraries(kiln_mpi PRIVATE kiln MPI::MPI_CXX)
  set_source_files_properties(src/cluster/mpi_module.cpp PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON
    COMPILE_DEFINITIONS KILN_MPI_MODULE="$<TARGET_FILE_NAME:kiln_mpi>")
endif()
