// Voxels of a cell in the picture: centres, footprints' sizes and the pixels that they may touch, sixteen at a time; a
// kernel of `--lattice voxel`. Centres are in double precision, the same arithmetic as Projector::viewOf: in a picture
// of any size, at any zoom, what a voxel is does not depend on its cell, brick or tile. One implementation in Highway,
// without fused or approximate operations: all instruction sets give the same bits.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <memory>

#include "engine/shared/plain_light.h"
#include "engine/shared/projector.h"
#include "engine/voxel/voxel_footprint.h"
#include "grid/coords.h"
#include "image/pixel_rect.h"

namespace kiln {

/// As many voxels go through the kernels together.
inline constexpr int kVoxelBatch = 16;

/// What the kernels know of a level: its projection and its light.
struct VoxelView {
  bool perspective = false;
  glm::dvec3 origin{0}, step[3]{};  // view = ((origin + z step[2]) + y step[1]) + x step[0]
  double focal = 1;
  glm::dvec2 centre{0};
  double near_depth = 0;
  Ellipse ellipse;  // orthographic: everywhere
  // Orthographic, where the ellipse has one.
  std::shared_ptr<const VoxelFootprint> footprint;
  // Of the kernel, by the squared focal length; in perspective over depth squared: xx, xy, yy, xz, yz, zz.
  float covariance[6]{};
  // The length of material that a voxel puts behind each pixel where its footprint's weights sum to one: the volume of
  // a voxel over the area of a pixel taken across the ray; in perspective to be divided by z² cosθ (without cosθ the
  // corner of a wide image is half too thin). unit: world.
  float length = 0;
  PlainLight light;  // without phong, colours are the caller's

  VoxelView() = default;
  VoxelView(const Projector& projector, const PlainLight& light);
};

/// shape: a number a voxel.
struct ProjectedVoxels {
  alignas(64) float u[kVoxelBatch], v[kVoxelBatch], r[kVoxelBatch];  // perspective: x/z, y/z and 1/z
  alignas(64) float xx[kVoxelBatch], yy[kVoxelBatch];                // perspective: the footprint's variances
  alignas(64) float dx[kVoxelBatch], dy[kVoxelBatch];                // from the centre to the first pixel's
  alignas(64) std::int32_t x0[kVoxelBatch], y0[kVoxelBatch],         // the footprint's pixels, not cut off by the
      x1[kVoxelBatch], y1[kVoxelBatch];                              // tile
  std::uint32_t touching = 0;  // bits of those that are drawn and whose pixels touch the tile
  std::uint32_t inside = 0;    // bits of those whose centre is in the tile
  PixelRect rect(std::size_t n) const { return {x0[n], y0[n], x1[n], y1[n]}; }
  int width(std::size_t n) const { return x1[n] - x0[n]; }
  int height(std::size_t n) const { return y1[n] - y0[n]; }
};

/// Voxels of a cell by their offsets from its first one. requires: below 16.
constexpr std::int32_t voxelCode(int x, int y, int z) { return x | y << 4 | z << 8; }
constexpr VoxelCoord voxelAt(const VoxelCoord& lo, std::int32_t code) {
  return {lo.x + (code & 15), lo.y + (code >> 4 & 15), lo.z + (code >> 8)};
}

/// The voxels at `lo` + codes[0 .. count). shape: `codes` can be read up to kVoxelBatch. requires: count <=
/// kVoxelBatch.
void projectVoxels(const VoxelView& view, const VoxelCoord& lo, const std::int32_t* codes, int count,
                   const PixelRect& tile, ProjectedVoxels& out) noexcept;

}  // namespace kiln
