# The public interface: what a program needs to convert, open, render, composite and read statistics. Headers that these
# include are installed with them; all others are the library's own.
set(kiln_public_headers
  base/memory/memory.h base/module.h
  ingest/open_source.h convert/convert.h convert/open_array.h
  export/export_store.h store/store_reader.h store/verify.h
  scene/transfer/presets.h job/render_job.h sequence/render_job_run.h composite/composite_parts.h
  image/file/image_file.h)

# Sets `out` to the headers and all headers of src/ that they include, as absolute paths.
function(kiln_with_included out)
  set(waiting ${ARGN})
  set(found)
  while(waiting)
    list(POP_FRONT waiting header)
    if(header IN_LIST found)
      continue()
    endif()
    list(APPEND found ${header})
    file(STRINGS ${PROJECT_SOURCE_DIR}/src/${header} lines REGEX "^#include \"")
    foreach(line ${lines})
      string(REGEX REPLACE "^#include \"([^\"]+)\".*" "\\1" included "${line}")
      list(APPEND waiting ${included})
    endforeach()
  endwhile()
  list(TRANSFORM found PREPEND ${PROJECT_SOURCE_DIR}/src/)
  set(${out} ${found} PARENT_SCOPE)
endfunction()

# Keeps the public interface small.
function(kiln_require_few_headers)
  list(LENGTH ARGN count)
  if(count GREATER 40)
    message(FATAL_ERROR "${count} public headers are too many (at most 40); declare types forward or use a private header")
  endif()
endfunction()
