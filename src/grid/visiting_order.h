// Front-to-back order on the lattice. A child of an octree node is nearer than its sibling if it lies on the eye's side
// of the mid-plane between them; for a parallel view, on the side the rays come from. Lee and Ihm §2.4 order by the
// distance of centres, which is only nearly right in perspective; the mid-plane rule is exact for any affine, because a
// mid-plane of index space stays a plane in the world. The order depends on the lattice alone, never on brick size.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>

#include "grid/coords.h"

namespace kiln {

class VisitingOrder {
 public:
  /// Rays run along `direction` (index space) everywhere.
  static VisitingOrder parallel(const glm::dvec3& direction_index) { return VisitingOrder(direction_index, true); }
  /// Rays start at `eye` (index space).
  static VisitingOrder fromEye(const glm::dvec3& eye_index) { return VisitingOrder(eye_index, false); }

  /// The nearest of the eight children around `mid` (the first voxel of the upper half along each axis); bit a is set
  /// where it lies in the upper half of axis a. Children nearest ^ 0, nearest ^ 1, … nearest ^ 7 are front to back.
  unsigned nearestChild(const VoxelCoord& mid) const {
    unsigned child = 0;
    for (int axis = 0; axis < 3; ++axis) {
      // The mid-plane between voxels mid-1 and mid is at mid - 1/2.
      const bool upper = parallel_ ? vector_[axis] < 0 : vector_[axis] >= static_cast<double>(mid[axis]) - 0.5;
      if (upper) child |= 1u << axis;
    }
    return child;
  }

  /// Writes the voxels first … first+count-1 of one axis in front-to-back order, as offsets from `first`.
  /// Nested loops over the three axes' orders visit a cell front to back. requires: count <= 255.
  void axisOrder(int axis, std::int64_t first, int count, std::uint8_t* offsets) const {
    // [0, split) is the eye's own voxel and those before it, and descends; [split, count) lies beyond and ascends.
    int split = vector_[axis] < 0 ? count : 0;
    if (!parallel_) {
      split = 0;
      while (split < count && static_cast<double>(first + split) - 0.5 <= vector_[axis]) ++split;
    }
    int n = 0;
    for (int i = split - 1; i >= 0; --i) offsets[n++] = static_cast<std::uint8_t>(i);
    for (int i = split; i < count; ++i) offsets[n++] = static_cast<std::uint8_t>(i);
  }

 private:
  VisitingOrder(const glm::dvec3& vector, bool parallel) : vector_(vector), parallel_(parallel) {}
  glm::dvec3 vector_;
  bool parallel_;
};

}  // namespace kiln
