// Coordinates on the voxel lattice: voxels, bricks, boxes. Sizes have 64 bits, because 10 000³ voxels are a legal
// volume.
#pragma once

#include <algorithm>
#include <compare>
#include <cstdint>
#include <utility>

namespace kiln {

/// Numbers of voxels along x, y, z.
struct Extent3 {
  std::int64_t x = 0, y = 0, z = 0;
  bool operator==(const Extent3&) const = default;
  std::int64_t operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
  std::int64_t count() const { return x * y * z; }
};

/// A voxel by its global index coordinates; its cube is [i-1/2, i+1/2] along each axis.
struct VoxelCoord {
  std::int64_t x = 0, y = 0, z = 0;
  bool operator==(const VoxelCoord&) const = default;
  std::int64_t operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
  std::int64_t& operator[](int axis) { return axis == 0 ? x : axis == 1 ? y : z; }
};

/// A brick of one level, by its coordinates in the brick lattice; holds voxels [b*size, (b+1)*size).
struct BrickCoord {
  std::int32_t x = 0, y = 0, z = 0;
  auto operator<=>(const BrickCoord&) const = default;
};

/// A brick of one level of the pyramid; level 0 is the finest.
struct BrickKey {
  int level = 0;
  BrickCoord brick;
  auto operator<=>(const BrickKey&) const = default;
};

/// A half-open box of voxels [lo, hi).
struct VoxelBox {
  VoxelCoord lo, hi;
  bool operator==(const VoxelBox&) const = default;
  bool empty() const { return lo.x >= hi.x || lo.y >= hi.y || lo.z >= hi.z; }
  Extent3 extent() const { return {hi.x - lo.x, hi.y - lo.y, hi.z - lo.z}; }
  std::int64_t count() const { return empty() ? 0 : extent().count(); }
  bool contains(const VoxelCoord& v) const {
    return v.x >= lo.x && v.x < hi.x && v.y >= lo.y && v.y < hi.y && v.z >= lo.z && v.z < hi.z;
  }
};

inline VoxelBox boxOf(const Extent3& dims) { return {{0, 0, 0}, {dims.x, dims.y, dims.z}}; }

inline VoxelBox intersection(const VoxelBox& a, const VoxelBox& b) {
  VoxelBox out;
  for (int axis = 0; axis < 3; ++axis) {
    out.lo[axis] = std::max(a.lo[axis], b.lo[axis]);
    out.hi[axis] = std::min(a.hi[axis], b.hi[axis]);
  }
  return out;
}

/// The smallest box that contains both. requires: neither is empty.
inline VoxelBox bounding(const VoxelBox& a, const VoxelBox& b) {
  VoxelBox out;
  for (int axis = 0; axis < 3; ++axis) {
    out.lo[axis] = std::min(a.lo[axis], b.lo[axis]);
    out.hi[axis] = std::max(a.hi[axis], b.hi[axis]);
  }
  return out;
}

/// The box grown by `voxels` on every side.
inline VoxelBox dilated(const VoxelBox& box, std::int64_t voxels) {
  return {{box.lo.x - voxels, box.lo.y - voxels, box.lo.z - voxels},
          {box.hi.x + voxels, box.hi.y + voxels, box.hi.z + voxels}};
}

/// Calls each(coordinate) for all coordinates in a box, x fastest.
template <class Each>
void forEachCoord(const VoxelBox& box, const Each& each) {
  VoxelCoord at;
  for (at.z = box.lo.z; at.z < box.hi.z; ++at.z)
    for (at.y = box.lo.y; at.y < box.hi.y; ++at.y)
      for (at.x = box.lo.x; at.x < box.hi.x; ++at.x) each(std::as_const(at));
}

/// The coarse box that a box meets, where a coarse element spans `by` voxels along each axis. requires: no coordinate
/// is negative.
inline VoxelBox coarseBox(const VoxelBox& fine, const Extent3& by) {
  VoxelBox out;
  for (int axis = 0; axis < 3; ++axis) {
    out.lo[axis] = fine.lo[axis] / by[axis];
    out.hi[axis] = (fine.hi[axis] + by[axis] - 1) / by[axis];
  }
  return out;
}

/// The cells or bricks of edge `edge` that a box meets. requires: no coordinate is negative.
inline VoxelBox coarseBox(const VoxelBox& fine, std::int64_t edge) { return coarseBox(fine, {edge, edge, edge}); }

/// Number of bricks of edge `brick_size` that cover a volume, along each axis.
inline Extent3 brickLattice(const Extent3& dims, std::int64_t brick_size) {
  return coarseBox(boxOf(dims), brick_size).extent();
}

/// The brick that holds a voxel. requires: no coordinate is negative.
inline BrickCoord brickOf(const VoxelCoord& v, std::int64_t brick_size) {
  return {static_cast<std::int32_t>(v.x / brick_size), static_cast<std::int32_t>(v.y / brick_size),
          static_cast<std::int32_t>(v.z / brick_size)};
}

/// The `i`-th brick of a lattice, x fastest: the order of a store's index. requires: 0 <= i < lattice.count().
inline BrickCoord brickAt(const Extent3& lattice, std::int64_t i) {
  return {static_cast<std::int32_t>(i % lattice.x), static_cast<std::int32_t>(i / lattice.x % lattice.y),
          static_cast<std::int32_t>(i / lattice.x / lattice.y)};
}

/// Index of a brick in the order of brickAt. requires: the brick lies in the lattice.
inline std::size_t placeOf(const Extent3& lattice, const BrickCoord& brick) {
  return static_cast<std::size_t>((brick.z * lattice.y + brick.y) * lattice.x + brick.x);
}

/// The core voxels of a brick, clipped at the end of the volume.
inline VoxelBox coreBox(const BrickCoord& brick, std::int64_t brick_size, const Extent3& dims) {
  const VoxelCoord lo = {brick.x * brick_size, brick.y * brick_size, brick.z * brick_size};
  return intersection({lo, {lo.x + brick_size, lo.y + brick_size, lo.z + brick_size}}, boxOf(dims));
}

}  // namespace kiln
