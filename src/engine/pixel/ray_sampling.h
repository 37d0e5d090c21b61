// Intersections of pixels' rays with the slabs of a zone, in a level's index space. Single precision suffices for
// samples and doubles the vector width.
// Invariant. All callers compute the side of a plane on which a slab of a pixel lies with equal operations, whatever
// the cell, brick or tile. Each slab of a pixel is therefore in exactly one cell.
#pragma once

#include <glm/vec3.hpp>

#include "engine/shared/end_voxels.h"
#include "engine/shared/projector.h"
#include "engine/shared/slab_grid.h"
#include "image/pixel_rect.h"
#include "occlusion/visibility.h"

namespace kiln {

/// The middle of slab k on the ray of pixel (x, y) is at place + (k - middle) · step; place and step are linear in x
/// and y. Pixels are counted from the image's centre, positions from the voxel `anchor`. unit: voxels.
struct RaySampling {
  /// A vector linear over the image: centre + x · along_x + y · along_y.
  struct Linear {
    glm::vec3 centre{0}, along_x{0}, along_y{0};
  };

  /// Rays of the i-th zone of a frame. requires: `projector` belongs to the zone's level, `dims` are the level's
  /// voxels.
  RaySampling(const std::vector<SlabZone>& zones, std::size_t i, const Projector& projector, const Extent3& dims,
              const EndVoxels& ends, bool in_quincunx = false);

  /// The voxel from which positions are counted.
  static VoxelCoord anchorOf(const Extent3& dims) { return {dims.x / 2, dims.y / 2, dims.z / 2}; }

  /// First pixel from x on in row y that has a ray; rayStride() is the distance to the next (Sampling::quincunx).
  int firstRay(int x, int y) const { return quincunx ? x + ((x + y) & 1) : x; }
  int rayStride() const { return quincunx ? 2 : 1; }
  /// Closes the pixel of a ray. In quincunx also closes the neighbouring pixel, which has no ray.
  void close(Visibility& visibility, int x, int y) const {
    visibility.close(x, y);
    if (quincunx) visibility.close(x ^ 1, y);
  }

  /// Coordinate of a face across an axis, relative to the rays' origin: the eye in perspective, otherwise the anchor.
  /// Computed in double precision, so that a ray in or nearly in a face stays on one side along its whole length.
  float faceAt(int axis, double at) const { return static_cast<float>(at - faces_from[axis]); }

  /// Longest extent of a slab along an axis, on the rays of a rectangle. unit: voxels.
  float longestStep(const PixelRect& pixels) const;

  bool quincunx = false;
  VoxelCoord anchor;
  glm::dvec3 faces_from;
  float eye = 0;  // perspective: slab coordinate of the eye, from the middle slab
  Linear place, step;
  Linear at_begin, at_end;  // positions where the zone begins and ends, with equal bits in the zones on both sides
  float middle = 0;
  float overlap = 0;                 // slabs in front of the zone in which surfaces are found, too (SlabZone::kOverlap)
  int first = 0, end = 0;            // slabs beyond the near depth
  float before, after;               // positions of the adjacent slabs in other zones. unit: slabs from the middle slab
  float centre_x = 0, centre_y = 0;  // added to a pixel's number
  glm::dvec3 volume_hi;              // far end of the volume, which begins at -1/2
};

}  // namespace kiln
