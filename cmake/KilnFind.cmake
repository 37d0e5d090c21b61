# Finds packages and collects the absent ones, so that one message names all of them:
#   kiln_found           names and versions, for the report of this build
#   kiln_missing         names
#   kiln_missing_debian  Debian's packages with the same places in the list
#   kiln_debian          Debian's packages of everything that was looked for

macro(kiln_add_missing name debian)
  list(APPEND kiln_missing ${name})
  list(APPEND kiln_missing_debian ${debian})
endmacro()

# Gives the lists of a function to its caller.
macro(kiln_return_lists)
  foreach(list found missing missing_debian debian)
    set(kiln_${list} ${kiln_${list}} PARENT_SCOPE)
  endforeach()
endmacro()

# find_package(name ...) without a word: some find modules print their own variables. Sets NAME_FOUND.
# It is a function because OpenVDB's find module sets BUILD_SHARED_LIBS for whoever calls it.
function(kiln_find_package name debian)
  list(APPEND kiln_debian ${debian})
  set(CMAKE_MESSAGE_LOG_LEVEL WARNING)
  find_package(${name} ${ARGN} QUIET)
  if(${name}_FOUND)
    string(STRIP "${name} ${${name}_VERSION}" found)
    list(APPEND kiln_found ${found})
  else()
    kiln_add_missing(${name} ${debian})
  endif()
  set(${name}_FOUND ${${name}_FOUND} PARENT_SCOPE)
  kiln_return_lists()
endfunction()

# A library without CMake files: the cache has NAME_INCLUDE_DIR with `header`, and NAME_LIBRARY.
function(kiln_find_library name debian header library)
  list(APPEND kiln_debian ${debian})
  string(TOUPPER ${name} prefix)
  find_path(${prefix}_INCLUDE_DIR ${header})
  find_library(${prefix}_LIBRARY ${library})
  if(${prefix}_INCLUDE_DIR AND ${prefix}_LIBRARY)
    list(APPEND kiln_found ${name})
  else()
    kiln_add_missing(${name} ${debian})
  endif()
  kiln_return_lists()
endfunction()

# Sets `message` to one line with all absent packages; to nothing where none is absent.
function(kiln_missing_message message)
  set(line "")
  if(kiln_missing)
    list(JOIN kiln_missing ", " names)
    list(JOIN kiln_missing_debian " " packages)
    set(line "kiln needs packages that were not found: ${names}; install them (Debian: apt-get install ${packages})")
  endif()
  set(${message} ${line} PARENT_SCOPE)
endfunction()
