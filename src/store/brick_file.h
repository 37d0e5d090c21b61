// What writer and reader of a brick file agree on (FORMAT.md, brick files). Internal, and not installed.
#pragma once

#include "grid/openvdb_glue.h"
#include "store/brick_codec.h"
#include "store/manifest.h"

namespace kiln {

inline constexpr const char* kCoreGrid = "density";
inline constexpr const char* kApronGrid = "apron";
inline constexpr const char* kCellMinGrid = "cell_min";
inline constexpr const char* kCellMaxGrid = "cell_max";

/// The edge of a leaf of every grid. unit: voxels.
inline constexpr std::int64_t kLeaf = 8;
inline std::int64_t leafBelow(std::int64_t n) { return n & ~(kLeaf - 1); }

/// The file's own metadata, by which a reader knows that it has the right brick.
inline openvdb::MetaMap metadataOf(const BrickFrame& frame) {
  openvdb::MetaMap out;
  const BrickCoord& brick = frame.key.brick;
  out.insertMeta("kiln_format", openvdb::Int32Metadata(kFormatVersion));
  out.insertMeta("kiln_level", openvdb::Int32Metadata(frame.key.level));
  out.insertMeta("kiln_brick", openvdb::Vec3IMetadata(openvdb::Vec3i(brick.x, brick.y, brick.z)));
  out.insertMeta("kiln_type", openvdb::StringMetadata(std::string(nameOf(frame.type))));
  return out;
}

}  // namespace kiln
