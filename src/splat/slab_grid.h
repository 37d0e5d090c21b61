// The slabs of a frame (DESIGN §6): image-parallel layers half a pixel thick or more, the same for all bricks and
// tiles. Their thickness, the pyramid's level and its refinement follow depth by zones. An orthographic view has one
// zone; in perspective a zone is an eighth of an octave of depth, so that the zone of a depth is read off its bits, and
// within a zone all is uniform. Level and refinements are thus decided by depth alone: where two of them meet, they
// meet in a plane between two slabs, whatever the bricks, tiles or crop. Of a zone's two refinements, each block of
// voxels has one by its values.
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "scene/camera.h"
#include "scene/sampling.h"
#include "splat/unit_axis.h"
#include "store/manifest.h"

namespace kiln {

struct SlabZone {
  double near = 0, far = 0;  // depths [near, far). unit: world, along the view
  double thickness = 1;      // of a slab: slab s of the zone is near + [s, s + 1) * thickness
  int slabs = 0;
  int level = 0;         // of the pyramid
  bool on_rays = false;  // samples are where pixels' rays meet slabs' middles: then the rest says nothing
  std::array<Refinement, 3> refinement;
  /// Of blocks of voxels that are soft (SampleTable::soft), which have a whole number of samples of either; the same
  /// where nothing would be saved.
  std::array<Refinement, 3> soft_refinement;
  double sigma_px = 0.3, soft_sigma_px = 0.3;  // of a footprint
  float erosion = 0;                           // of pixels at edges, at most: splat/coverage.h
  /// Whether samples stand for the values of a voxel that is smaller than a pixel and hides finer ones.
  bool intervals = false;
  /// Whether there are samples between voxels.
  bool refined() const { return refinement != std::array<Refinement, 3>{}; }
  bool judgesBlocks() const { return soft_refinement != refinement; }

  /// The first slab of the zone with its centre at `depth` or beyond; 0 and `slabs` where there is none.
  int slabFrom(double depth) const {
    const double s = (depth - near) / thickness - 0.5;
    return s <= 0      ? 0
           : s > slabs ? slabs
                       : static_cast<int>(s) + (static_cast<double>(static_cast<int>(s)) < s ? 1 : 0);
  }
};

/// Slabs of a zone on rays, at the most: in views of larger volumes they are thicker.
inline constexpr int kMostRaySlabs = 1 << 17;

/// Whether soft voxels have samples of their own: never; where the others need not be more for it, so that a block has
/// a whole number of them; or anyway.
enum class SoftSamples { kNever, kWhereFree, kAnyway };

/// What is judged soft or not, as a whole: so many voxels along an axis with that many samples, from a multiple of them
/// on, 4 or less. A brick has all of the blocks that its own samples and those beside it (ghosts) are in, with what
/// they interpolate, so that whoever draws a sample finds the same.
int softBlock(const Refinement& refinement);
inline constexpr int kMostSoftBlock = 4;

/// A volume, and what of its look decides its lattice. Of several in one picture the steepest decides for all.
struct ZonedVolume {
  const Manifest* manifest = nullptr;
  double near_depth = 0;                                       // what is nearer is not drawn
  double steepness = std::numeric_limits<double>::infinity();  // steepnessOf, of level 0
  SoftSamples soft = SoftSamples::kNever;
  double sample_distance = kSampleDistance;  // Sampling's
  bool on_rays = false, quincunx = false;    // the same
};

/// The zones from the nearest to the farthest; levels do not fall on the way. requires: `level`, if given, is one of
/// the volume's.
std::vector<SlabZone> slabZones(const ZonedVolume& volume, const View& view, std::optional<int> level);

/// The same slabs for several volumes. shape: a list for each zone, with one for each volume; where the volume does not
/// reach, it has no slabs. All others of a zone have the same slabs, as thick as the samples are apart of that whose
/// are the farthest, on rays of that whose are the nearest, and kMostSharedSlabs at most.
std::vector<std::vector<SlabZone>> sharedZones(std::span<const ZonedVolume> volumes, const View& view,
                                               std::optional<int> level);
inline constexpr int kMostSharedSlabs = 32;

}  // namespace kiln
