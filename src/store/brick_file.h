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

/// The grid that a voxel type has in a brick. Of 8 and 16 bits as Int32 the upper bytes are almost constant, and cost
/// next to nothing once Blosc has put the bytes of one place together; half and float spread the same bits wider.
template <class T>
using BrickGridFor = std::conditional_t<std::is_integral_v<T> && sizeof(T) <= 2, openvdb::Int32Grid, GridFor<T>>;

/// The edge of a leaf of every grid. unit: voxels.
inline constexpr std::int64_t kLeaf = 8;
inline std::int64_t leafBelow(std::int64_t n) { return n & ~(kLeaf - 1); }

inline VoxelBox leafAt(const VoxelCoord& v) { return {v, {v.x + kLeaf, v.y + kLeaf, v.z + kLeaf}}; }
inline VoxelCoord voxelOf(const openvdb::Coord& c) { return {c.x(), c.y(), c.z()}; }

/// The voxels of the leaf at `origin` that lie in `part`. requires: part inside of the leaf.
inline openvdb::util::NodeMask<3> maskOf(const VoxelCoord& origin, const VoxelBox& part) {
  // A word is a plane of one x, z fastest.
  const std::uint64_t along_z = ((1u << (part.hi.z - part.lo.z)) - 1) << (part.lo.z - origin.z);
  std::uint64_t plane = 0;
  for (std::int64_t y = part.lo.y; y < part.hi.y; ++y) plane |= along_z << (kLeaf * (y - origin.y));
  openvdb::util::NodeMask<3> mask;
  for (std::int64_t x = part.lo.x; x < part.hi.x; ++x) {
    mask.getWord<std::uint64_t>(static_cast<openvdb::Index>(x - origin.x)) = plane;
  }
  return mask;
}

/// Of stores of either format.
inline constexpr int kBrickFileFormat = 1;

/// The file's own metadata, by which a reader knows that it has the right brick.
inline openvdb::MetaMap metadataOf(const BrickFrame& frame) {
  openvdb::MetaMap out;
  const BrickCoord& brick = frame.key.brick;
  out.insertMeta("kiln_format", openvdb::Int32Metadata(kBrickFileFormat));
  out.insertMeta("kiln_level", openvdb::Int32Metadata(frame.key.level));
  out.insertMeta("kiln_brick", openvdb::Vec3IMetadata(openvdb::Vec3i(brick.x, brick.y, brick.z)));
  out.insertMeta("kiln_type", openvdb::StringMetadata(std::string(nameOf(frame.type))));
  return out;
}

}  // namespace kiln
