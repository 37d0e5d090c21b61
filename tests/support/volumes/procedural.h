// Small volumes with known voxels: inputs of tests with closed-form answers, and of property tests. They are plain
// arrays in memory, because the input of a test must be simpler than the renderer.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "grid/geometry.h"
#include "grid/value_range.h"
#include "grid/voxel_type.h"
#include "ingest/source/volume_source.h"

namespace kiln::test {

/// A volume in memory. shape: `voxels` is x fastest, then y, then z, densely packed, in `type`.
struct DenseVolume {
  VolumeGeometry geometry;
  VoxelType type = VoxelType::u8;
  std::vector<std::byte> voxels;

  /// The voxel at (i,j,k), clamped to the volume's edge. requires: T is the C++ type of `type`.
  template <class T>
  T at(std::int64_t i, std::int64_t j, std::int64_t k) const {
    T value;
    std::memcpy(&value, voxels.data() + clampedOffset(i, j, k) * sizeof(T), sizeof(T));
    return value;
  }
  /// Returns the voxel as a double, which represents every voxel type exactly.
  double valueAt(std::int64_t i, std::int64_t j, std::int64_t k) const;
  /// Rounds to the nearest value of `type`, saturating. requires: (i,j,k) inside the volume.
  void set(std::int64_t i, std::int64_t j, std::int64_t k, double value);
  /// Range of the finite voxels.
  ValueRange range() const;

 private:
  std::size_t clampedOffset(std::int64_t i, std::int64_t j, std::int64_t k) const {
    const Extent3& n = geometry.dims;
    i = std::clamp<std::int64_t>(i, 0, n.x - 1);
    j = std::clamp<std::int64_t>(j, 0, n.y - 1);
    k = std::clamp<std::int64_t>(k, 0, n.z - 1);
    return static_cast<std::size_t>((k * n.y + j) * n.x + i);
  }
};

/// Shape of a generated volume. The default affine has spacing 1 and voxel (0,0,0) at the origin.
struct VolumeShape {
  Extent3 dims;
  VoxelType type = VoxelType::u8;
  glm::dmat4 world_from_index{1.0};
};

glm::dmat4 spacingAffine(const glm::dvec3& spacing, const glm::dvec3& origin = glm::dvec3(0));
/// Edges of 0.7, 0.9 and 2.1: a CT with thick slices.
glm::dmat4 anisotropicAffine();
/// Anisotropic, rotated about no axis of the world and sheared: the hardest legal affine.
glm::dmat4 obliqueAffine();
/// Voxels of these edges, turned about no axis of the world. unit: `angle`: radians.
glm::dmat4 turnedAffine(double angle, const glm::dvec3& spacing, const glm::dvec3& origin);
/// The affine of equal voxels mirrored in place: `axis` of the index space is reversed.
glm::dmat4 mirroredAffine(const glm::dmat4& world_from_index, int axis, const Extent3& dims);

/// A range that exercises the type: all of u8, i8 and u16; CT numbers for i16; for i32 and u32 more bits than a float
/// holds.
ValueRange usualRange(VoxelType type);

/// The volume whose voxel (i,j,k) is value(i,j,k). thread: `value` is called from several threads.
DenseVolume fill(const VolumeShape& shape,
                 const std::function<double(std::int64_t, std::int64_t, std::int64_t)>& value);

/// `value` in voxels [lo, hi) along `axis`, else 0. The trilinear half-value planes lie exactly at lo - 1/2 and hi -
/// 1/2.
DenseVolume slab(const VolumeShape& shape, int axis, std::int64_t lo, std::int64_t hi, double value);
/// `value` times the share of each voxel that a ball in index space covers, by 8³ sub-samples in boundary voxels. The
/// sum of the voxels is the ball's volume times `value`, and trilinear interpolation keeps the sum. unit: voxels.
DenseVolume ball(const VolumeShape& shape, const glm::dvec3& centre, double radius, double value);
/// first + slope * i.
DenseVolume ramp(const VolumeShape& shape, double first, double slope);
/// Every voxel independent and uniform in `range`: the hardest case for a hierarchy.
DenseVolume noise(const VolumeShape& shape, std::uint64_t seed, const ValueRange& range);
/// 44 × 39 × 41 voxels of 128 but for single voxels of 0 and 255: a cubic filter adds values two voxels away.
DenseVolume specks();
/// Curved walls, tunnels and islands at every level of value, a little noise, and less towards the corners.
DenseVolume cheese(const VolumeShape& shape, std::uint64_t seed, const ValueRange& range);
/// Nested ellipsoids: air, skin, skull, brain, ventricles, and two eye sockets on the side of -y.
DenseVolume head(const VolumeShape& shape, const ValueRange& range);
/// A head of 38 × 45 × 33 voxels of unequal edges; of floats some are NaN.
DenseVolume smallHead(VoxelType type);

/// 64 well-mixed bits of (seed, counter): equal on every machine, in any order of calls. source: SplitMix64.
std::uint64_t hashBits(std::uint64_t seed, std::uint64_t counter);
/// `hashBits` mapped to [0, 1).
double hashUnit(std::uint64_t seed, std::uint64_t counter);

/// A dense volume as the conversion reads a file. requires: the volume outlives the source.
class DenseSource : public VolumeSource {
 public:
  explicit DenseSource(const DenseVolume& volume);
  const SourceInfo& info() const override { return info_; }
  ReadOrder order() const override { return ReadOrder::kAnyBox; }
  void read(const VoxelBox& box, std::span<std::byte> out) override;

 private:
  const DenseVolume& volume_;
  SourceInfo info_;
};

}  // namespace kiln::test
