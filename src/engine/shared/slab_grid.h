// The slabs of a frame: image-parallel layers half a pixel thick or more (of sub-pixels a quarter), the same for all
// bricks and tiles, in whose middles rays have samples. Their thickness and the pyramid's level follow depth by zones.
// An orthographic view has one zone; in perspective a zone is an eighth of an octave of depth, so that the zone of a
// depth is read off its bits, and within a zone all is uniform. Levels are thus decided by depth alone: where two of
// them meet, they meet in a plane between two slabs, whatever the bricks, tiles or crop.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "scene/camera/camera.h"
#include "scene/sampling.h"
#include "store/manifest/manifest.h"

namespace kiln {

struct SlabZone {
  double near = 0, far = 0;  // depths [near, far). unit: world, along the view
  double thickness = 1;      // of a slab: slab s of the zone is near + [s, s + 1) * thickness
  int slabs = 0;
  int level = 0;  // of the pyramid
  /// Whether samples stand for the values of a voxel that is smaller than a pixel and hides finer ones.
  bool intervals = false;

  /// The first slab of the zone with its centre at `depth` or beyond; 0 and `slabs` where there is none.
  int slabFrom(double depth) const {
    const double s = (depth - near) / thickness - 0.5;
    return s <= 0      ? 0
           : s > slabs ? slabs
                       : static_cast<int>(s) + (static_cast<double>(static_cast<int>(s)) < s ? 1 : 0);
  }
};

/// Slabs of a zone, at the most: in views of larger volumes they are thicker.
inline constexpr int kMostRaySlabs = 1 << 17;

/// A volume, and what decides its slabs.
struct ZonedVolume {
  const Manifest* manifest = nullptr;
  double near_depth = 0;                     // what is nearer is not drawn
  double sample_distance = kSampleDistance;  // Sampling's
  bool quincunx = false, finest = false;     // the same
};

/// The zones from the nearest to the farthest; levels do not fall on the way. requires: `level`, if given, is one of
/// the volume's.
std::vector<SlabZone> slabZones(const ZonedVolume& volume, const View& view, std::optional<int> level);

/// The same slabs for several volumes. shape: a list for each zone, with one for each volume; where the volume does not
/// reach, it has no slabs. All others of a zone have the same slabs, as thick as the volume with the thinnest has them,
/// and kMostSharedSlabs at most.
std::vector<std::vector<SlabZone>> sharedZones(std::span<const ZonedVolume> volumes, const View& view,
                                               std::optional<int> level);
inline constexpr int kMostSharedSlabs = 32;

}  // namespace kiln
