// Names, leaf order and metadata shared by the encoder and decoder of brick files (FORMAT.md, brick files). Internal,
// not installed.
#pragma once

#include "grid/openvdb_glue.h"
#include "store/codec/brick_codec.h"
#include "store/manifest/manifest.h"

namespace kiln {

inline constexpr const char* kCoreGrid = "density";
inline constexpr const char* kApronGrid = "apron";
inline constexpr const char* kCellMinGrid = "cell_min";
inline constexpr const char* kCellMaxGrid = "cell_max";
/// Grid metadata for a transform that is not in the world's unit.
inline constexpr const char* kUnitExponent = "kiln_unit_exponent";

/// The grid type of a voxel type. 8 and 16 bits are stored as Int32: the upper bytes are almost constant, and cost
/// almost nothing after Blosc's byte shuffle. Half and float spread the same bits wider.
template <class T>
using BrickGridFor = std::conditional_t<std::is_integral_v<T> && sizeof(T) <= 2, openvdb::Int32Grid, GridFor<T>>;

/// Edge of a leaf of every grid. unit: voxels.
inline constexpr std::int64_t kLeaf = 8;
inline std::int64_t leafBelow(std::int64_t n) { return n & ~(kLeaf - 1); }

inline VoxelBox leafAt(const VoxelCoord& v) { return {v, {v.x + kLeaf, v.y + kLeaf, v.z + kLeaf}}; }
inline VoxelCoord voxelOf(const openvdb::Coord& c) { return {c.x(), c.y(), c.z()}; }

/// The leaves with voxels in a box, x fastest. requires: coordinates are not negative.
struct LeafLattice {
  VoxelCoord first;
  Extent3 size;
  explicit LeafLattice(const VoxelBox& box)
      : first{box.lo.x / kLeaf, box.lo.y / kLeaf, box.lo.z / kLeaf},
        size{(box.hi.x - 1) / kLeaf + 1 - first.x, (box.hi.y - 1) / kLeaf + 1 - first.y,
             (box.hi.z - 1) / kLeaf + 1 - first.z} {}
  std::size_t count() const { return static_cast<std::size_t>(size.count()); }
  /// Index of the leaf that holds the voxel.
  std::size_t indexOf(const VoxelCoord& v) const {
    const std::int64_t y = v.y / kLeaf - first.y, z = v.z / kLeaf - first.z;
    return static_cast<std::size_t>((z * size.y + y) * size.x + v.x / kLeaf - first.x);
  }
};

/// Mask of the voxels of the leaf at `origin` that lie in `part`. requires: part inside the leaf.
inline openvdb::util::NodeMask<3> maskOf(const VoxelCoord& origin, const VoxelBox& part) {
  // A word of the mask is a plane of constant x, z fastest.
  const std::uint64_t along_z = ((1u << (part.hi.z - part.lo.z)) - 1) << (part.lo.z - origin.z);
  std::uint64_t plane = 0;
  for (std::int64_t y = part.lo.y; y < part.hi.y; ++y) plane |= along_z << (kLeaf * (y - origin.y));
  openvdb::util::NodeMask<3> mask;
  for (std::int64_t x = part.lo.x; x < part.hi.x; ++x) {
    mask.getWord<std::uint64_t>(static_cast<openvdb::Index>(x - origin.x)) = plane;
  }
  return mask;
}

/// Calls f(origin, part) for each cube of `edge`, aligned to multiples of `edge`, that meets the box; z fastest, as in
/// a tree. `part` is the intersection of cube and box.
template <class F>
void forCubes(const VoxelBox& box, std::int64_t edge, F&& f) {
  const auto down = [&](std::int64_t v) { return v & ~(edge - 1); };
  for (std::int64_t x = down(box.lo.x); x < box.hi.x; x += edge) {
    for (std::int64_t y = down(box.lo.y); y < box.hi.y; y += edge) {
      for (std::int64_t z = down(box.lo.z); z < box.hi.z; z += edge) {
        f(VoxelCoord{x, y, z}, intersection(VoxelBox{{x, y, z}, {x + edge, y + edge, z + edge}}, box));
      }
    }
  }
}

/// Calls leaf(origin, part) for each 8³ leaf with voxels in `box`, in tree order.
template <class F>
void forEachLeafOfTree(const VoxelBox& box, F&& leaf) {
  using Upper = openvdb::FloatTree::RootNodeType::ChildNodeType;
  forCubes(box, Upper::DIM, [&](const VoxelCoord&, const VoxelBox& upper) {
    forCubes(upper, Upper::ChildNodeType::DIM,
             [&](const VoxelCoord&, const VoxelBox& lower) { forCubes(lower, kLeaf, leaf); });
  });
}

/// Calls leaf(part) for each 8³ leaf with voxels in `box`, in the memory order of a block. In tree order each cache
/// line of a block would be visited four times, at long intervals.
template <class F>
void forEachLeaf(const VoxelBox& box, F&& leaf) {
  for (std::int64_t z = leafBelow(box.lo.z); z < box.hi.z; z += kLeaf) {
    for (std::int64_t y = leafBelow(box.lo.y); y < box.hi.y; y += kLeaf) {
      for (std::int64_t x = leafBelow(box.lo.x); x < box.hi.x; x += kLeaf) {
        leaf(intersection(leafAt({x, y, z}), box));
      }
    }
  }
}

/// Calls leaf(origin, part) in tree order for the leaves of a brick's core, or of its apron. Core boundaries are leaf
/// boundaries or the end of the volume, so no leaf has voxels of both.
template <class F>
void forEachLeafOfGrid(const VoxelBox& core, const VoxelBox& stored, bool of_core, F&& leaf) {
  forEachLeafOfTree(of_core ? core : stored, [&](const VoxelCoord& origin, const VoxelBox& part) {
    if (of_core || !core.contains(part.lo)) leaf(origin, part);
  });
}

/// The version in every brick file, in stores of every format.
inline constexpr int kBrickFileFormat = 1;

/// Metadata of the file, by which a reader recognises the right brick.
inline openvdb::MetaMap metadataOf(const BrickDesc& frame) {
  openvdb::MetaMap out;
  const BrickCoord& brick = frame.key.brick;
  out.insertMeta("kiln_format", openvdb::Int32Metadata(kBrickFileFormat));
  out.insertMeta("kiln_level", openvdb::Int32Metadata(frame.key.level));
  out.insertMeta("kiln_brick", openvdb::Vec3IMetadata(openvdb::Vec3i(brick.x, brick.y, brick.z)));
  out.insertMeta("kiln_type", openvdb::StringMetadata(std::string(nameOf(frame.type))));
  return out;
}

}  // namespace kiln
