// Problem. Octree nodes, bricks and voxels must be visited front to back.
// Method. A child of a node is nearer than its sibling if the child lies on the eye's side of the mid-plane between
// them; for a parallel view, on the side from which the rays come. The mid-plane rule is exact for any affine, because
// a mid-plane of index space stays a plane in the world.
// Two children that are neighbours across the line of sight may come in either order. The axis closest to the view
// direction is taken last: the near face of a node is drawn before anything behind the face, which hides more.
// Invariant. The order depends on the lattice alone, never on brick size.
// Source: Lee and Ihm §2.4. Differs: they order by the distance of centres, which is only approximately right in
// perspective.
#pragma once

#include <array>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include "grid/coords.h"

namespace kiln {

class VisitingOrder {
 public:
  /// For rays along `direction` (index space). unit: `spacing` holds the voxel's edges in the world.
  static VisitingOrder parallel(const glm::dvec3& direction_index, const glm::dvec3& spacing = glm::dvec3(1)) {
    return VisitingOrder(direction_index, spacing, true);
  }
  /// For rays from `eye` (index space).
  static VisitingOrder fromEye(const glm::dvec3& eye_index, const glm::dvec3& spacing = glm::dvec3(1)) {
    return VisitingOrder(eye_index, spacing, false);
  }

  /// The eight children around `mid` (the first voxel of the upper half along each axis), front to back. Bit a of a
  /// child is set if the child lies in the upper half of axis a.
  std::array<std::uint8_t, 8> children(const VoxelCoord& mid) const {
    unsigned nearest = 0;
    glm::dvec3 along = vector_;
    for (int axis = 0; axis < 3; ++axis) {
      // The mid-plane between voxels mid-1 and mid is at mid - 1/2.
      if (!parallel_) along[axis] = static_cast<double>(mid[axis]) - 0.5 - vector_[axis];
      if (parallel_ ? along[axis] < 0 : along[axis] <= 0) nearest |= 1u << axis;
    }
    along = glm::abs(along * spacing_);
    const int last = along.z >= along.x && along.z >= along.y ? 2 : along.y >= along.x ? 1 : 0;
    const unsigned first_bit = last == 0 ? 2 : 1, second_bit = last == 2 ? 2 : 4, last_bit = 1u << last;
    std::array<std::uint8_t, 8> out;
    for (unsigned i = 0; i < 8; ++i) {
      const unsigned flipped =
          ((i & 1) != 0 ? first_bit : 0) | ((i & 2) != 0 ? second_bit : 0) | ((i & 4) != 0 ? last_bit : 0);
      out[i] = static_cast<std::uint8_t>(nearest ^ flipped);
    }
    return out;
  }

  /// Writes the numbers of `count` voxels along one axis, from voxel `first` on, front to back; or of cells, each
  /// `edge` voxels long. Nested loops over the orders of three axes visit a box front to back. requires: count <= 255.
  void axisOrder(int axis, std::int64_t first, int count, std::uint8_t* offsets, std::int64_t edge = 1) const {
    // [0, split): up to the eye's voxel, descending. [split, count): beyond the eye, ascending.
    int split = vector_[axis] < 0 ? count : 0;
    if (!parallel_) {
      split = 0;
      while (split < count && static_cast<double>(first + split * edge) - 0.5 <= vector_[axis]) ++split;
    }
    int n = 0;
    for (int i = split - 1; i >= 0; --i) offsets[n++] = static_cast<std::uint8_t>(i);
    for (int i = split; i < count; ++i) offsets[n++] = static_cast<std::uint8_t>(i);
  }

 private:
  VisitingOrder(const glm::dvec3& vector, const glm::dvec3& spacing, bool parallel)
      : vector_(vector), spacing_(spacing), parallel_(parallel) {}
  glm::dvec3 vector_, spacing_;
  bool parallel_;
};

}  // namespace kiln
