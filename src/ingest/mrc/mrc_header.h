// The header of an MRC, CCP4 or MAP file: type, extents, order of axes and unit cell.
#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "ingest/bytes/header_bytes.h"
#include "ingest/bytes/stored_type.h"
#include "ingest/source/volume_source.h"

namespace kiln {

struct MrcHeader {
  StoredType type = VoxelType::u8;
  bool big_endian = false;
  /// True if the whole file is in gzip.
  bool in_gzip = false;
  /// Columns, rows and sections, in the order of the file.
  Extent3 dims;
  /// Sections of one volume: fewer than `dims.z` in a stack of volumes.
  std::int64_t sections_of_volume = 0;
  /// The axis of the cell, 0 to 2, along which columns, rows and sections follow each other.
  std::array<int, 3> cell_axis = {0, 1, 2};
  /// Steps of a voxel along the axes x, y, z of the cell, and the place of the first voxel. unit: ångström, if
  /// `has_cell`; else voxels.
  std::array<glm::dvec3, 3> step = {glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1)};
  glm::dvec3 origin{0};
  bool has_cell = false, right_angles = true;
  /// Begin of the voxels. unit: bytes of the decompressed file.
  std::uint64_t end_offset = 0;
  /// Sentences for the user.
  std::vector<std::string> notes;
};

/// throws: Error kFormat if the bytes are no header; kUnsupported for complex numbers, 4-bit integers and colours.
MrcHeader readMrcHeader(const std::filesystem::path& path);

}  // namespace kiln
