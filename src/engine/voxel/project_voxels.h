// Projects voxels of a cell, sixteen at a time: centre, footprint size and the rectangle of pixels that the footprint
// can touch.
// Method. README.md, equations (1) and (2). Centres are computed in double precision with the arithmetic of
// Projector::viewOf.
// Invariant. A voxel's projection does not depend on its cell, brick or tile, for any picture size and zoom. One
// Highway implementation without fused or approximate operations returns equal bits on all instruction sets.
// Source: Westover 1990; Zwicker et al. 2001 for the ellipse in perspective.
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

/// Number of voxels that the kernels handle together.
inline constexpr int kVoxelBatch = 16;

/// Projection and light of one level, as the kernels need them.
struct VoxelView {
  bool perspective = false;
  glm::dvec3 origin{0}, step[3]{};  // view = ((origin + z step[2]) + y step[1]) + x step[0]
  double focal = 1;
  glm::dvec2 centre{0};
  double near_depth = 0;
  Ellipse ellipse;  // orthographic: the ellipse of every footprint
  // Table of weights; null in perspective and for ellipses that VoxelFootprint::fits rejects.
  std::shared_ptr<const VoxelFootprint> footprint;
  // Covariance of the voxel's Gaussian times the squared focal length (perspective: to be divided by z²): xx, xy, yy,
  // xz, yz, zz.
  float covariance[6]{};
  // Length of material behind a pixel if the footprint's weights sum to one: a voxel's volume over a pixel's area
  // perpendicular to the ray. Perspective: to be divided by z² cos θ; without cos θ the corner of a wide image has half
  // its opacity. unit: world.
  float length = 0;
  PlainLight light;  // without phong the caller computes colours

  VoxelView() = default;
  VoxelView(const Projector& projector, const PlainLight& light);
};

/// Projected voxels of a batch. shape: one number per voxel.
struct ProjectedVoxels {
  alignas(64) float u[kVoxelBatch], v[kVoxelBatch], r[kVoxelBatch];  // perspective: x/z, y/z and 1/z
  alignas(64) float xx[kVoxelBatch], yy[kVoxelBatch];                // perspective: the footprint's variances
  alignas(64) float dx[kVoxelBatch], dy[kVoxelBatch];                // from the voxel's centre to the first pixel's
                                                                     // centre
  alignas(64) std::int32_t x0[kVoxelBatch], y0[kVoxelBatch],         // the footprint's pixels, not clipped to the tile
      x1[kVoxelBatch], y1[kVoxelBatch];                              // tile
  std::uint32_t touching = 0;                                        // mask of drawn voxels whose pixels touch the tile
  std::uint32_t inside = 0;                                          // mask of voxels whose centre is in the tile
  PixelRect rect(std::size_t n) const { return {x0[n], y0[n], x1[n], y1[n]}; }
  int width(std::size_t n) const { return x1[n] - x0[n]; }
  int height(std::size_t n) const { return y1[n] - y0[n]; }
};

/// Packs the offset of a voxel from the cell's first voxel. requires: each coordinate below 16.
constexpr std::int32_t voxelCode(int x, int y, int z) { return x | y << 4 | z << 8; }
constexpr VoxelCoord voxelAt(const VoxelCoord& lo, std::int32_t code) {
  return {lo.x + (code & 15), lo.y + (code >> 4 & 15), lo.z + (code >> 8)};
}

/// Projects the voxels at `lo` + codes[0 .. count). shape: `codes` can be read up to kVoxelBatch. requires: count <=
/// kVoxelBatch.
void projectVoxels(const VoxelView& view, const VoxelCoord& lo, const std::int32_t* codes, int count,
                   const PixelRect& tile, ProjectedVoxels& out) noexcept;

}  // namespace kiln
