// Coordinates on the voxel lattice: voxels, bricks, boxes. Sizes have 64 bits, because 10 000³ voxels are a legal
// volume.
#pragma once

#include <algorithm>
#include <compare>
#include <cstdint>

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

/// Number of bricks of edge `brick_size` that cover a volume, along each axis.
inline Extent3 brickLattice(const Extent3& dims, std::int64_t brick_size) {
  const auto up = [&](std::int64_t n) { return (n + brick_size - 1) / brick_size; };
  return {up(dims.x), up(dims.y), up(dims.z)};
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
