// Slabs of a frame: layers parallel to the picture; a ray has one sample in the middle of each slab.
// Problem. Sample positions and pyramid levels must not depend on bricks, tiles or the crop.
// Method. Slabs are at least half a pixel thick (a quarter for sub-pixels). Slab thickness and level depend on depth
// alone and are constant within a zone. An orthographic view has one zone. In perspective a zone is an eighth of an
// octave of depth, so that a depth's exponent and first bits select its zone.
// Invariant. Two levels meet in a plane between two slabs.
// Source: Mueller and Crawfis 1998 (image-parallel slabs). Differs: one sample per pixel and slab, on the pixel's ray.
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
  double thickness = 1;      // thickness of a slab: slab s covers near + [s, s + 1) * thickness
  int slabs = 0;
  int level = 0;  // pyramid level
  /// A sample stands for all values of a voxel that is smaller than a pixel and hides finer voxels.
  bool intervals = false;
  /// The zone in front has a finer level. Surfaces of the level are then also found kOverlap slabs in front of the
  /// zone: the finer level may end in front of its own surface, and a ray would pass between both.
  bool behind_finer = false;
  static constexpr int kOverlap = 8;
  double overlapNear() const { return behind_finer ? near - kOverlap * thickness : near; }

  /// First slab of the zone whose centre is at `depth` or beyond, clamped to [0, slabs].
  int slabFrom(double depth) const {
    const double s = (depth - near) / thickness - 0.5;
    return s <= 0      ? 0
           : s > slabs ? slabs
                       : static_cast<int>(s) + (static_cast<double>(static_cast<int>(s)) < s ? 1 : 0);
  }
};

/// Most slabs in a zone. Slabs of a volume of more slabs are thicker.
inline constexpr int kMostRaySlabs = 1 << 17;

/// A volume and the parameters of its slabs.
struct ZonedVolume {
  const Manifest* manifest = nullptr;
  double near_depth = 0;                     // nearest depth that is drawn
  double sample_distance = kSampleDistance;  // from Sampling
  bool quincunx = false, finest = false;     // from Sampling
  int coarser = 0;                           // from Sampling
};

/// Zones from the nearest to the farthest; levels never decrease along the way. requires: `level`, if given, is a level
/// of the volume.
std::vector<SlabZone> slabZones(const ZonedVolume& volume, const View& view, std::optional<int> level);

/// Slabs shared by several volumes. shape: a list for each zone, with one entry for each volume.
/// A volume that does not reach into a zone has no slabs in it. All other volumes of a zone have equal slabs: as thick
/// as the thinnest of their own, at most kMostSharedSlabs per zone.
std::vector<std::vector<SlabZone>> sharedZones(std::span<const ZonedVolume> volumes, const View& view,
                                               std::optional<int> level);
inline constexpr int kMostSharedSlabs = 32;

}  // namespace kiln
