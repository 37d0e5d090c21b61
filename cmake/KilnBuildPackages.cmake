# Packages of the program, its modules, tests and benchmarks: this build finds them, an installed library does not.

kiln_find_package(CLI11 libcli11-dev)

# GDCM's own CMake files require programs of packages that Kiln does not need.
find_path(GDCM_INCLUDE_DIR gdcmReader.h PATH_SUFFIXES gdcm-3.2 gdcm-3.0)
foreach(kiln_library gdcmMSFF gdcmDSED gdcmCommon)
  find_library(GDCM_${kiln_library} ${kiln_library})
endforeach()
if(GDCM_INCLUDE_DIR AND GDCM_gdcmMSFF AND GDCM_gdcmDSED AND GDCM_gdcmCommon)
  list(APPEND kiln_found GDCM)
else()
  kiln_add_missing(GDCM libgdcm-dev)
endif()

# Finds what `option` is for, and sets NAME_FOUND. ON: an absent package is missing. AUTO: the build goes on without it,
# and prints `without`. OFF: it is not looked for.
function(kiln_find_optional option without name debian)
  set(${name}_FOUND FALSE)
  if(${option} STREQUAL "AUTO")
    set(required ${kiln_missing})
    set(required_debian ${kiln_missing_debian})
    kiln_find_package(${name} ${debian} ${ARGN})
    set(kiln_missing ${required})
    set(kiln_missing_debian ${required_debian})
    if(NOT ${name}_FOUND)
      message(STATUS "${name} was not found (Debian: ${debian}): ${without}")
    endif()
  elseif(${option})
    kiln_find_package(${name} ${debian} ${ARGN})
  endif()
  set(${name}_FOUND ${${name}_FOUND} PARENT_SCOPE)
  kiln_return_lists()
endfunction()

# FindMPI ends CMake where MPI's compiler wrapper is installed without the headers, and its cache keeps that nothing was
# found. Such a wrapper counts as no MPI: FindMPI is not called until a file with MPI's header can be preprocessed.
function(kiln_find_mpi)
  find_program(MPI_CXX_COMPILER NAMES mpicxx mpic++ mpiCC HINTS ${MPI_HOME} ENV MPI_HOME PATH_SUFFIXES bin)
  if(MPI_CXX_COMPILER)
    set(probe ${PROJECT_BINARY_DIR}/CMakeFiles/kiln_mpi_probe.cpp)
    file(WRITE ${probe} "#include <mpi.h>\n")
    execute_process(COMMAND ${CMAKE_COMMAND} -E env OMPI_CXX=${CMAKE_CXX_COMPILER} MPICH_CXX=${CMAKE_CXX_COMPILER}
                            ${MPI_CXX_COMPILER} -E ${probe}
                    RESULT_VARIABLE failed OUTPUT_QUIET ERROR_QUIET)
    if(failed)
      set(CMAKE_DISABLE_FIND_PACKAGE_MPI ON)
    endif()
  endif()
  set(MPI_CXX_SKIP_MPICXX ON)  # classes of MPI 2, which take a trial compilation and which Kiln does not use
  kiln_find_optional(KILN_MPI "kiln works on one machine" MPI libopenmpi-dev 3.0 COMPONENTS CXX)
  set(MPI_FOUND ${MPI_FOUND} PARENT_SCOPE)
  kiln_return_lists()
endfunction()
if(KILN_MPI)
  kiln_find_mpi()
endif()

# Reports an absent package. AUTO: the build goes on, and prints `without`. ON: the package is missing.
macro(kiln_report_absent option name debian without)
  if(${option} STREQUAL "AUTO")
    message(STATUS "${name} was not found (Debian: ${debian}): ${without}")
  else()
    kiln_add_missing("${name}" "${debian}")
  endif()
endmacro()

# A library for a program of its own: the cache has PREFIX_INCLUDE_DIR with `header`, and PREFIX_LIBRARY, a library of one
# of the names `libraries`. Sets PREFIX_FOUND.
function(kiln_find_for_worker option name debian without prefix header libraries folders)
  find_path(${prefix}_INCLUDE_DIR ${header} PATH_SUFFIXES ${folders})
  find_library(${prefix}_LIBRARY NAMES ${libraries} PATH_SUFFIXES ${folders})
  set(${prefix}_FOUND FALSE PARENT_SCOPE)
  if(${prefix}_INCLUDE_DIR AND ${prefix}_LIBRARY)
    set(${prefix}_FOUND TRUE PARENT_SCOPE)
    list(APPEND kiln_found ${name})
  else()
    kiln_report_absent(${option} ${name} ${debian} "${without}")
  endif()
  kiln_return_lists()
endfunction()
# Debian keeps headers and library in folders of the variant without MPI.
if(KILN_HDF5)
  kiln_find_for_worker(KILN_HDF5 HDF5 libhdf5-dev "HDF5 files are not read" HDF5_READER hdf5.h "hdf5_serial;hdf5" hdf5/serial)
endif()
if(KILN_OPENJPEG)
  kiln_find_for_worker(KILN_OPENJPEG OpenJPEG libopenjp2-7-dev "slices of JPEG 2000 are not read" OPENJPEG_READER openjpeg.h openjp2
                       "openjpeg-2.5;openjpeg-2.4;openjpeg-2.3")
endif()

# NanoVDB is headers alone.
set(NANOVDB_FOUND FALSE)
if(KILN_NANOVDB)
  find_path(NANOVDB_INCLUDE_DIR nanovdb/util/OpenToNanoVDB.h)
  if(NANOVDB_INCLUDE_DIR)
    set(NANOVDB_FOUND TRUE)
    list(APPEND kiln_found NanoVDB)
  else()
    kiln_report_absent(KILN_NANOVDB NanoVDB libnanovdb-dev "NanoVDB files are not written")
  endif()
endif()

# Boost.Beast is headers alone, which Debian's packages of Boost's libraries bring.
if(KILN_VIEW)
  find_path(BEAST_INCLUDE_DIR boost/beast/http.hpp HINTS ${Boost_INCLUDE_DIRS})
  set(BEAST_FOUND FALSE)
  if(BEAST_INCLUDE_DIR)
    set(BEAST_FOUND TRUE)
    list(APPEND kiln_found Beast)
  else()
    kiln_report_absent(KILN_VIEW Beast libboost-iostreams-dev "volumes are not viewed in a browser")
  endif()
endif()

# FreeType, and the font that is compiled in (KILN_FONT_FILE).
set(FONT_FOUND FALSE)
if(KILN_FREETYPE)
  kiln_find_optional(KILN_FREETYPE "pictures have no letters" Freetype libfreetype-dev)
  find_file(KILN_FONT_FILE DejaVuSans.ttf NO_CMAKE_FIND_ROOT_PATH PATHS /usr/share/fonts /usr/local/share/fonts
            PATH_SUFFIXES truetype/dejavu dejavu TTF dejavu-sans-fonts)
  if(NOT KILN_FONT_FILE)
    kiln_report_absent(KILN_FREETYPE "DejaVu Sans" fonts-dejavu-core "pictures have no letters")
  elseif(Freetype_FOUND)
    set(FONT_FOUND TRUE)
  endif()
endif()

# An interpreter that has NumPy is preferred. pybind11 is headers alone. A sanitizer would have to be loaded before Python is.
function(kiln_find_python)
  set(PYTHON_MODULE_FOUND FALSE PARENT_SCOPE)
  foreach(python python3 /usr/bin/python3)
    if(Python3_EXECUTABLE)
      break()
    endif()
    execute_process(COMMAND ${python} -c "import numpy, sys; print(sys.executable)" OUTPUT_VARIABLE found OUTPUT_STRIP_TRAILING_WHITESPACE
                    ERROR_QUIET RESULT_VARIABLE failed)
    if(failed EQUAL 0)
      set(Python3_EXECUTABLE ${found} CACHE FILEPATH "The Python that the package is for")
    endif()
  endforeach()
  find_package(Python3 QUIET COMPONENTS Interpreter Development.Module)
  find_path(PYBIND11_INCLUDE_DIR pybind11/pybind11.h)
  if(Python3_FOUND AND PYBIND11_INCLUDE_DIR)
    foreach(variable EXECUTABLE SOABI SITEARCH VERSION_MAJOR VERSION_MINOR)
      set(Python3_${variable} ${Python3_${variable}} PARENT_SCOPE)
    endforeach()
    set(PYTHON_MODULE_FOUND TRUE PARENT_SCOPE)
    list(APPEND kiln_found "pybind11 for Python ${Python3_VERSION}")
  else()
    kiln_report_absent(KILN_PYTHON pybind11 "pybind11-dev python3-dev" "no package for Python is made")
  endif()
  kiln_return_lists()
endfunction()
if(KILN_PYTHON AND NOT KILN_SANITIZE)
  kiln_find_python()
endif()

kiln_find_optional(KILN_TESTS "tests are not built" GTest libgtest-dev)
kiln_find_optional(KILN_BENCH "benchmarks are not built" benchmark libbenchmark-dev)
