# Everything that Kiln's library links, for this build and for an installed kilnConfig.cmake. Absent packages are in
# kiln_missing: this build fails then, and a find_package(kiln) reports that Kiln was not found.
include(${CMAKE_CURRENT_LIST_DIR}/KilnFind.cmake)

set(kiln_found "")
set(kiln_missing "")
set(kiln_missing_debian "")
set(kiln_debian "")
kiln_find_package(TBB libtbb-dev)
kiln_find_package(Boost libboost-iostreams-dev COMPONENTS iostreams)
kiln_find_package(OpenEXR libopenexr-dev)
kiln_find_package(Imath libimath-dev)
kiln_find_package(glm libglm-dev)
kiln_find_package(fmt libfmt-dev)
kiln_find_package(nlohmann_json nlohmann-json3-dev)
kiln_find_package(PNG libpng-dev)
kiln_find_package(TIFF libtiff-dev)
kiln_find_package(ZLIB zlib1g-dev)
kiln_find_package(JPEG libjpeg-dev)
kiln_find_package(BZip2 libbz2-dev)
kiln_find_package(LibLZMA liblzma-dev)
kiln_find_package(EXPAT libexpat1-dev)
kiln_find_library(xxHash libxxhash-dev xxhash.h xxhash)
kiln_find_library(Highway libhwy-dev hwy/highway.h hwy)
# OpenVDB's compressors, and those of chunked formats.
kiln_find_library(Blosc libblosc-dev blosc.h blosc)
kiln_find_library(LZ4 liblz4-dev lz4.h lz4)
kiln_find_library(Zstd libzstd-dev zstd.h zstd)
kiln_find_library(Libdeflate libdeflate-dev libdeflate.h deflate)

# OpenVDB's find module lies beside its library, outside CMake's own search path. It ends CMake where a package that
# OpenVDB links is absent: it is called where nothing is missing so far, else the header alone is looked for.
function(kiln_find_openvdb)
  list(APPEND CMAKE_MODULE_PATH /usr/lib/${CMAKE_LIBRARY_ARCHITECTURE}/cmake/OpenVDB)
  if(NOT kiln_missing)
    kiln_find_package(OpenVDB libopenvdb-dev COMPONENTS openvdb)
  else()
    find_path(header openvdb/openvdb.h HINTS ${OpenVDB_ROOT} ENV OpenVDB_ROOT PATH_SUFFIXES include NO_CACHE)
    if(NOT header)
      kiln_add_missing(OpenVDB libopenvdb-dev)
    endif()
  endif()
  kiln_return_lists()
endfunction()
kiln_find_openvdb()
set(kiln_library_debian ${kiln_debian})

if(NOT kiln_missing AND NOT TARGET kiln_dependencies)
  add_library(kiln_dependencies INTERFACE)
  target_include_directories(kiln_dependencies SYSTEM INTERFACE ${XXHASH_INCLUDE_DIR} ${HIGHWAY_INCLUDE_DIR}
                             ${BLOSC_INCLUDE_DIR} ${LZ4_INCLUDE_DIR} ${ZSTD_INCLUDE_DIR} ${LIBDEFLATE_INCLUDE_DIR})
  target_link_libraries(kiln_dependencies INTERFACE OpenVDB::openvdb TBB::tbb OpenEXR::OpenEXR Imath::Imath fmt::fmt
                        nlohmann_json::nlohmann_json PNG::PNG TIFF::TIFF ZLIB::ZLIB JPEG::JPEG BZip2::BZip2 LibLZMA::LibLZMA
                        EXPAT::EXPAT ${XXHASH_LIBRARY} ${HIGHWAY_LIBRARY} ${BLOSC_LIBRARY} ${LZ4_LIBRARY} ${ZSTD_LIBRARY}
                        ${LIBDEFLATE_LIBRARY})
endif()
