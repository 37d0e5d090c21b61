// Where pixels' rays meet the slabs of a zone, in a level's index space and in floats, which is enough for samples and
// takes half of a vector. Whoever asks on which side of a plane a slab of a pixel lies asks in the same words, whatever
// cell, brick or tile it asks for, so that each slab of a pixel is in one cell and in no other.
#pragma once

#include <glm/vec3.hpp>

#include "engine/shared/end_voxels.h"
#include "engine/shared/projector.h"
#include "engine/shared/slab_grid.h"
#include "occlusion/visibility.h"

namespace kiln {

/// The middle of slab k on the ray of pixel (x, y) is at place + (k - middle) · step, of which each is what `of` says.
/// Pixels are counted from the image's centre, places from the voxel `anchor`. unit: voxels.
struct RaySlabs {
  /// A vector that is linear over the image.
  struct Linear {
    glm::vec3 centre{0}, along_x{0}, along_y{0};
  };

  /// Of the i-th of a frame's zones. requires: `projector` is of the zone's level, `dims` its voxels.
  RaySlabs(const std::vector<SlabZone>& zones, std::size_t i, const Projector& projector, const Extent3& dims,
           const EndVoxels& ends, bool in_quincunx = false);

  /// In a row, the first pixel from x on that has a ray, and how far it is to the next one (Sampling::quincunx).
  int firstRay(int x, int y) const { return quincunx ? x + ((x + y) & 1) : x; }
  int rayStride() const { return quincunx ? 2 : 1; }
  /// Closes the pixel of a ray; in quincunx the pixel beside it, too, which has no ray.
  void close(Visibility& visibility, int x, int y) const {
    visibility.close(x, y);
    if (quincunx) visibility.close(x ^ 1, y);
  }

  /// The coordinate `at` of a face across an axis, as rays are asked about it: from the eye where they begin there,
  /// else from the anchor. Both in doubles, so that a ray that runs in a face, or nearly so, is on one side of it all
  /// the way.
  float faceAt(int axis, double at) const { return static_cast<float>(at - faces_from[axis]); }

  bool quincunx = false;
  VoxelCoord anchor;
  glm::dvec3 faces_from;
  float eye = 0;  // in perspective, the slab from the middle in which the eye is
  Linear place, step;
  float middle = 0;
  int first = 0, end = 0;            // the slabs that are not too near to the eye
  float before, after;               // where the slabs beside them are, of other zones. unit: slabs from the middle one
  float centre_x = 0, centre_y = 0;  // what is added to a pixel's number
  glm::dvec3 volume_hi;              // where the volume ends, which begins at -1/2
};

}  // namespace kiln
