// A unit of the lattice refined, classified, shaded and projected: all that is done to a sample before its slab's turn
// comes. Units are boxes of voxels, aligned in the level's index space, of at most 16 samples along an axis, so that a
// row of samples is one vector. One implementation in Highway for every instruction set, chosen at run time, without
// fused or approximate operations: they all give the same bits.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "grid/coords.h"
#include "splat/plain_light.h"
#include "splat/tile_windows.h"
#include "splat/unit_axis.h"
#include "splat/waiting_samples.h"

namespace kiln {

/// How a sample's material is spread over slabs: the projection of its cube onto the line of sight, taken as two boxes
/// folded, of its two largest edges. unit: slabs.
struct DepthSpread {
  float a = 1, b = 0, reach = 0.5f;  // a >= b; reach = (a + b) / 2
};

/// What all units of a zone share.
struct UnitLattice {
  Interpolation interpolation = Interpolation::kLinear;
  bool labels = false;      // of a label volume: the unit says what its samples are
  int label_smoothing = 0;  // of it, how far smoothing reaches. unit: voxels
  std::array<int, 3> voxels{1, 1, 1};
  int blocks = 1;                             // of a unit along x, 1 or 2, which are judged apart (softBlock)
  std::array<std::vector<UnitAxis>, 3> axes;  // of units that begin so many units after a multiple of kRefinedVoxels
  // Projection: p = origin + offsets · steps; x, y = centre + focal p.xy (/ p.z in perspective). unit: world
  bool perspective = false;
  float focal = 1, centre_x = 0, centre_y = 0, near_depth = 0;
  glm::vec3 step_x, step_y, step_z;
  // Slabs.
  float near = 0, slabs_per_depth = 1, thickness = 1;
  int slabs = 0;
  DepthSpread spread;
  bool three_slabs = false;  // whether a sample's material is in all of them that it reaches, or in its first two only
  int taps = 4;              // of a footprint, along an axis. unit: pixels
  int first_phase = 0;       // of its rows in the table
  float weight = 1;          // V_sample / (A_px D); in perspective times depth squared
  // Classification, see SampleTable.
  const float* table = nullptr;        // shape: entries of r, g, b, tau
  const float* extinctions = nullptr;  // shape: entries
  float table_scale = 1, table_last = 0;
  float visible_after = -1, visible_before = 3e38f;  // samples have extinction between these places of the table only,
  bool gaps = true;                                  // and not everywhere there
  // Where a voxel stands for the interval of values that it is the mean of: the extinction is the mean over it. Null
  // where a sample is a point.
  const float* integral = nullptr;
  float least_interval = 1;
  // What is more than that, the caller does for each sample with its details, and then there is none here.
  PlainLight light;

  /// Of the unit whose first voxel is `lo`.
  std::array<const UnitAxis*, 3> axesAt(const VoxelCoord& lo) const {
    std::array<const UnitAxis*, 3> out{};
    for (int a = 0; a < 3; ++a) {
      const auto ua = static_cast<std::size_t>(a);
      const auto first = static_cast<std::size_t>(lo[a] & (kRefinedVoxels - 1));
      out[ua] = &axes[ua][first / static_cast<std::size_t>(voxels[ua])];
    }
    return out;
  }
};

/// One unit. `values` are its voxels and those around it, less the table's offset.
struct UnitInput {
  const float* values = nullptr;  // shape: voxels + 2 margins along each axis, rows kUnitSamples apart
  // Of a label volume, the places of samples in the table, in rows and planes of kUnitSamples; `values` are opacities.
  const float* label_places = nullptr;
  std::array<const UnitAxis*, 3> axis{};        // the lattice's, where the unit is
  float least = 0, most = 0;                    // of what its samples interpolate; linear ones are kept within
  glm::vec3 origin;                             // of its first voxel's centre, in view space
  std::array<int, 3> first{}, end{};            // its samples that exist, along each axis
  std::array<int, 3> core_first{}, core_end{};  // those that are the brick's own
  bool parts = false;  // whether not all of a voxel exists everywhere, as at the volume's end; if so, of each sample
  std::array<float, kUnitSamples> part_x{}, part_y{}, part_z{};
  PixelRect tile;
  // The tile's windows, if samples whose footprints are closed are to be left out.
  const TileWindows* windows = nullptr;
};

/// A sample on its way to its slab. `front` of its weight goes there, the rest to the next one.
struct SlabSample {
  float r, g, b;
  float opacity;
  float front, back;  // what of the two slabs it fills, of a pixel's area
  FootprintPlace place;
};

/// What a caller needs who shades, clips or modulates samples itself, or tells more of them than their colour.
struct SampleDetails {
  glm::vec3 offset;    // from the unit's first voxel. unit: voxels
  glm::vec3 gradient;  // unit: value per voxel; 0 where it is not finite
  glm::vec3 view;      // place in view space
  float tau;           // unit: 1 / world
  float ray;           // through the slab. unit: world
};

/// How many the samples of a unit may be, those included that some of them have in a third slab.
inline std::size_t mostRefined(const UnitLattice& lattice, const UnitInput& unit) {
  std::size_t out = lattice.three_slabs ? 2 : 1;
  for (std::size_t a = 0; a < 3; ++a) out *= static_cast<std::size_t>(unit.end[a] - unit.first[a]);
  return out;
}

/// Where samples go: to their slabs, counted from `first_slab`, which also takes those before it; or, if `details` is
/// not null, with their slabs and details to arrays, for a caller who finishes them. shape: arrays have room for
/// mostRefined.
struct RefinedSamples {
  WaitingSamples<SlabSample>* waiting = nullptr;
  int first_slab = 0;
  SlabSample* samples = nullptr;
  std::int32_t* slabs = nullptr;
  SampleDetails* details = nullptr;
};

struct RefinedCounts {
  int samples = 0;  // that went to arrays
  int closed = 0;   // that count, and were left out because their footprints are closed
};

/// Refines the samples that are not transparent and whose footprints touch the tile.
RefinedCounts refineUnit(const UnitLattice& lattice, const UnitInput& unit, const RefinedSamples& out);

/// The instruction set in use: "AVX3" and the like.
const char* instructionSet();

}  // namespace kiln
