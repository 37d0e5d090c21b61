// Kernel of the pixel engine: casts the rays of a tile through one cell of a brick.
// Problem. Few samples of a cell are visible, and consecutive samples of a ray depend on each other.
// Method. Each step handles many rays or samples, so that vectors are full and no sample waits for the sample before
// it. (1) Find rays through the box of visible voxels. (2) Find places along the rays where samples may be visible. (3)
// Interpolate and classify values. (4) Composite visible samples in order. (5) Light the samples that contribute.
// Invariant. One Highway implementation without approximate operations returns equal bits on all instruction sets,
// chosen at run time.
// Source: Levoy 1990 (early ray termination); Mueller et al. 1999 (classification after interpolation, tests before
// shading). Equations: README.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

#include "engine/pixel/ray_sampling.h"
#include "engine/pixel/sample_faces.h"
#include "engine/pixel/slab_context.h"
#include "engine/pixel/slab_sums.h"
#include "engine/pixel/voxels/load_patch.h"
#include "engine/shared/tile_pixels.h"
#include "image/pixel_rect.h"
#include "scene/clip_region.h"

namespace kiln {

/// Input: a cell of a brick in a tile.
struct CellInput {
  /// Edge of the voxels read for a cell (with margin); distance of the planes of voxels. unit: voxels.
  static constexpr int kReadEdge = kPatchEdge, kPlane = kReadEdge * kPatchStride;
  const float* values = nullptr;           // from loadPatch; opacities for labels
  const std::int32_t* labels = nullptr;    // label volume: LabelVoxels::ranks
  const float* mask = nullptr;             // MaskVoxels::shown; null: all voxels are shown
  const float* mask_smoothed = nullptr;    // MaskVoxels::smoothed, with `mask`
  const float* color_places = nullptr;     // ColorPatch::places; null: the volume's own colours
  glm::vec3 lo;                            // voxel before the cell's first voxel. unit: voxels from the anchor
  glm::dvec3 corner, end;                  // begin and end of the cell in index space
  PixelRect rect;                          // pixels of the tile that the cell may touch
  PixelRect bounds;                        // pixels that the cell may touch in a picture of any size
  std::array<bool, 3> ends{};              // axes along which samples may reach an end of the volume
  bool at_end = false;                     // samples may reach an end of the volume
  bool at_edge = false;                    // samples may reach two ends of the volume or more
  std::span<const SampleFace> cuts;        // faces that may end samples
  std::span<const SampleFace> lit_by;      // all faces that light samples; none if no face is near
  bool in_pairs = false;                   // one sample may cover two slabs
  bool gaps = false;                       // the cell's voxels may be NaN
  const float* color = nullptr;            // r, g, b of all samples if equal; otherwise null
  const ClipRegion::Part* part = nullptr;  // only samples in this part of the volume are drawn; null: all
  bool on_face = false;                    // a cut face may pass through the cell
  bool one_label = false;                  // all voxels have one label; `values` is not read
  SlabSums* sums = nullptr;                // several volumes: samples are added to the sums, not to the tile
};

/// Scratch memory for the rays and samples of a cell. Vectors may read undefined values beyond the last ray or sample;
/// results of these values are never used. Offsets are clamped into the cell up to the end of the last vector, so that
/// voxels may be read at the offset behind the last sample.
struct CellSamples {
  /// Most samples and rays that pass through a cell's steps together, and array sizes with room for whole vectors.
  static constexpr std::size_t kLanes = 16, kMost = 512, kRoom = kMost + 2 * kLanes;
  static constexpr std::size_t kMostRays = 512, kRayRoom = kMostRays + 2 * kLanes;
  static constexpr std::size_t kLit = 4 * kLanes;  // samples lit together

  // Per ray through the cell: code of its first slab in the cell, and end of the ray in the cell.
  alignas(64) std::int32_t ray_code[kRayRoom];
  alignas(64) float ray_end[kRayRoom];
  // Per sample found: code, index of the voxel before the sample, position between voxels, and the two values around
  // the sample along x.
  alignas(64) std::int32_t code[kRoom], offset[kRoom];
  alignas(64) float fraction[3][kRoom], pair[2 * kRoom];
  // Per visible sample: index among the samples found, code, table position, opacity, weight.
  alignas(64) std::int32_t index[kRoom], kept_code[kRoom];
  alignas(64) float entry[kRoom], opacity[kRoom], weight[kRoom];
  // Per piece of a ray, for surfaces: ends, the turn between the ends, and the values there.
  alignas(64) float begin[kRoom], end[kRoom], turn[kRoom], value_begin[kRoom], value_end[kRoom], value_turn[kRoom];
  // Per crossing of a surface: position (of a point on a cut face, too), the ends of its bracket, the values there less
  // the surface's, and the end that moved last. Before, per bent piece: turn, ends, value at the turn, and the bend.
  alignas(64) float at[kRoom], bracket[2][kRoom], excess[2][kRoom], moved[kRoom];
  // Per visible sample, if colours depend on gradients: row in the plane of values and gradients.
  alignas(64) float row[kRoom];
  // Per visible sample, if something needs them: gradient, position in index space, and slabs that it covers.
  alignas(64) float slope[3][kRoom], index_place[3][kRoom], slabs[kRoom];
  // Per visible sample that a face may light, if something needs normals: FaceSlopes::Face.
  alignas(64) float face_slope[3][kRoom], face_share[kRoom];
  // Alpha of a vector of pixels.
  alignas(64) float alpha[kLanes];
  // Per sample that is lit: position along x; rows of interpolated values.
  alignas(64) float fraction_x[kLit], rows[4][4 * kLit];
  // A pixel that a sample closed.
  struct Closed {
    std::int32_t pixel;
    float alpha;
  };
  Closed closed[kRoom];
};

/// Effect of a cell on the tile.
struct CellOutput {
  std::array<std::uint64_t, kSquareEdge> closed{};  // one bit per pixel of the rectangle
  std::uint64_t shown = 0, samples = 0;             // visible samples; samples that contribute to a pixel
};

/// Adds the cell's light to the tile, or to the sums. Closed pixels have an alpha of one; the visibility structure is
/// not updated. requires: as castRays.
void castRaysInCell(const RaySampling& rays, const SlabContext& context, const CellInput& in, const TilePixels& tile,
                    float opacity_threshold, CellSamples& samples, CellOutput& out);

}  // namespace kiln
