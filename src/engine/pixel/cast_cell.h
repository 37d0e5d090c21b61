// One cell of a brick on pixels' rays: the kernel of the pixel lattice, in steps that each go through many rays or
// samples, so that vectors are full and no sample waits for what was done to the one before: rays are found that go
// through what may show something; along them places where samples may; their values are interpolated and classified;
// those that do show something hide each other, one after the other; what is seen of them is lit. One implementation in
// Highway for every instruction set, chosen at run time; nothing in it is approximate, so that they all give the same
// bits.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>

#include "engine/pixel/ray_slabs.h"
#include "engine/pixel/slab_frame.h"
#include "engine/pixel/slab_sums.h"
#include "engine/pixel/unit_load.h"
#include "engine/shared/tile_pixels.h"
#include "image/pixel_rect.h"
#include "scene/clip_region.h"

namespace kiln {

/// A cell in a tile.
struct CellInput {
  /// Edge of what is read for a cell, and from plane to plane of it. unit: voxels.
  static constexpr int kReadEdge = kUnitVoxels + 2 * kUnitMargin, kPlane = kReadEdge * kUnitSamples;
  const float* values = nullptr;           // loadUnit's; of labels their opacities
  const std::int32_t* labels = nullptr;    // of a label volume: LabelVoxels::ranks
  glm::vec3 lo;                            // the voxel before its first. unit: voxels from the anchor
  glm::dvec3 corner, end;                  // where it begins and ends, in index space
  PixelRect rect;                          // what of the tile it may be seen in
  bool at_end = false;                     // of the volume
  bool in_pairs = false;                   // whether two samples may be one, twice as long
  bool gaps = false;                       // whether there may be NaN among its voxels
  const ClipRegion::Part* part = nullptr;  // of the volume: only samples in it are drawn; null where all are
  bool one_label = false;                  // whether all of them are of one label: then `values` is not read
  SlabSums* sums = nullptr;                // of several volumes: samples are added to the sums, not to the tile
};

/// What is known of rays and samples, for one cell after the other. Beyond the last one vectors read anything, and use
/// none of it.
struct CellSamples {
  /// That go through a cell's steps together, at the most; and room for what vectors go beyond.
  static constexpr std::size_t kLanes = 16, kMost = 512, kRoom = kMost + 2 * kLanes;
  static constexpr std::size_t kMostRays = 512, kRayRoom = kMostRays + 2 * kLanes;
  static constexpr std::size_t kLit = 4 * kLanes;  // that are lit together

  // Of each ray through the cell, the code of its first slab there, and where it ends.
  alignas(64) std::int32_t ray_code[kRayRoom];
  alignas(64) float ray_end[kRayRoom];
  // Of each sample that was found: its code, which voxels it is between, how far, and the values around it along x.
  alignas(64) std::int32_t code[kRoom], offset[kRoom];
  alignas(64) float fraction[3][kRoom], pair[2 * kRoom];
  // Of each that is kept: which of them it is, its code and its place in the table, and so on.
  alignas(64) std::int32_t index[kRoom], kept_code[kRoom];
  alignas(64) float entry[kRoom], opacity[kRoom], weight[kRoom];
  // The same, where samples are finished one by one.
  alignas(64) float slope[3][kRoom], index_place[3][kRoom];
  // Of a vector of pixels.
  alignas(64) float alpha[kLanes];
  // Of samples that are lit together.
  alignas(64) float fraction_x[kLit], rows[4][4 * kLit];
  // Of each that closed its pixel.
  struct Closed {
    std::int32_t pixel;
    float alpha;
  };
  Closed closed[kRoom];
};

/// What a cell did to the tile.
struct CellOutput {
  std::array<std::uint64_t, kSquareEdge> closed{};  // a bit a pixel of the rectangle
  std::uint64_t shown = 0, samples = 0;             // that show something, and that are seen
};

/// Adds what the cell shows to the tile, or to the sums. Closed pixels have an alpha of one; the visibility structure
/// is not told. requires: as castCells.
void castCell(const RaySlabs& rays, const SlabFrame& frame, const CellInput& in, const TilePixels& tile,
              float opaque_at, CellSamples& samples, CellOutput& out);

}  // namespace kiln
