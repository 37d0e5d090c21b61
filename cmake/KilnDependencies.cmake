# Everything Kiln links, found where Debian puts it; used by this build and by an installed kilnConfig.cmake.
# OpenVDB's find module lies beside its library, outside CMake's own search path.
list(APPEND CMAKE_MODULE_PATH /usr/lib/${CMAKE_LIBRARY_ARCHITECTURE}/cmake/OpenVDB)
# That module sets BUILD_SHARED_LIBS for whoever asks: what the user said is put back.
if(DEFINED BUILD_SHARED_LIBS)
  set(kiln_build_shared_libs ${BUILD_SHARED_LIBS})
endif()
find_package(OpenVDB REQUIRED COMPONENTS openvdb)
if(DEFINED kiln_build_shared_libs)
  set(BUILD_SHARED_LIBS ${kiln_build_shared_libs})
else()
  unset(BUILD_SHARED_LIBS)
endif()
find_package(TBB REQUIRED)
find_package(OpenEXR REQUIRED)
find_package(glm REQUIRED)
find_package(fmt REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(PNG REQUIRED)
find_package(ZLIB REQUIRED)
find_path(XXHASH_INCLUDE_DIR xxhash.h REQUIRED)
find_library(XXHASH_LIBRARY xxhash REQUIRED)

if(NOT TARGET kiln_dependencies)
  add_library(kiln_dependencies INTERFACE)
  target_link_libraries(kiln_dependencies INTERFACE OpenVDB::openvdb TBB::tbb OpenEXR::OpenEXR Imath::Imath fmt::fmt
                        nlohmann_json::nlohmann_json PNG::PNG ZLIB::ZLIB ${XXHASH_LIBRARY})
endif()
