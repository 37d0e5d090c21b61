# CPack runs this over the files that it has installed, one folder for each component, before it packs them: adds the
# documents of a package (copyright, changelog), compresses man pages, and moves Python's files to Debian's folder.
function(run)
  execute_process(COMMAND ${ARGV} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)  # SOURCE_DATE_EPOCH makes it reproducible
string(TIMESTAMP year "%Y" UTC)
foreach(component ${CPACK_COMPONENTS_ALL})
  string(TOUPPER ${component} upper)
  set(package ${CPACK_DEBIAN_${upper}_PACKAGE_NAME})
  set(usr ${CPACK_TEMPORARY_DIRECTORY}/${component}${CPACK_PACKAGING_INSTALL_PREFIX})
  set(documents ${usr}/share/doc/${package})

  # The copyright file stands for the licence: Debian has the text of Apache 2.0 in a file of its own.
  file(REMOVE ${documents}/LICENSE)
  file(WRITE ${documents}/copyright
    "Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/\nUpstream-Name: Kiln\n\n"
    "Files: *\nCopyright: ${year} ${CPACK_PACKAGE_CONTACT}\nLicense: Apache-2.0\n"
    " On Debian systems the licence's text is in /usr/share/common-licenses/Apache-2.0.\n")
  file(GLOB_RECURSE font ${usr}/lib/libkiln_font.so)
  if(font)
    file(READ /usr/share/doc/fonts-dejavu-core/copyright licence)
    string(REGEX REPLACE ".*\nFiles: \\*\n(.*)\n\nFiles: debian.*" "\\1" licence "${licence}")
    file(APPEND ${documents}/copyright
      "\nFiles: usr/lib/kiln/libkiln_font.so\nComment: The font DejaVu Sans is compiled in.\n${licence}\n")
  endif()
  file(WRITE ${documents}/changelog.Debian
    "kiln (${CPACK_PACKAGE_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE}) unstable; urgency=medium\n\n"
    "  * Built from the sources of version ${CPACK_PACKAGE_VERSION}.\n\n -- ${CPACK_PACKAGE_CONTACT}  ${date}\n")
  file(GLOB_RECURSE pages ${usr}/share/man/*)
  list(FILTER pages EXCLUDE REGEX "\\.gz$")
  run(gzip -9n ${pages} ${documents}/changelog.Debian)

  # An MPI's own folder, where CMake has linked it, holds links to the libraries of the system's folder.
  file(GLOB_RECURSE modules ${usr}/lib/libkiln_mpi.so)
  foreach(module ${modules})
    run(patchelf --set-rpath $ORIGIN ${module})
  endforeach()

  file(GLOB python ${usr}/lib/python3.*)
  if(python)
    file(MAKE_DIRECTORY ${usr}/lib/python3/dist-packages)
    file(GLOB folder ${python}/*-packages/kiln)
    file(RENAME ${folder} ${usr}/lib/python3/dist-packages/kiln)
    file(REMOVE_RECURSE ${python})
  endif()
endforeach()
