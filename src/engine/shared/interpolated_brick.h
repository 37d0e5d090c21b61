// Linear interpolation in a decoded brick, with equal arithmetic in every brick.
#pragma once

#include <algorithm>
#include <cstdint>
#include <glm/vec3.hpp>
#include <type_traits>

#include "store/codec/brick_block.h"

namespace kiln {

/// T: type of the brick's voxels.
template <class T>
class InterpolatedBrick {
 public:
  /// requires: `block`, of type T, outlives this.
  explicit InterpolatedBrick(const BrickBlock& block)
      : block_(block), voxels_(block.data<T>()), stride_{1, block.strideY(), block.strideZ()} {}

  /// Distance of neighbouring voxels along an axis.
  std::int64_t stride(int axis) const { return stride_[axis]; }
  const T* at(const VoxelCoord& voxel) const { return voxels_ + block_.offsetOf(voxel); }

  /// Value at a place in the level's index space. requires: place >= -1/2, up to rounding; the brick holds the eight
  /// voxels around the place.
  double valueAt(const glm::dvec3& place) const {
    VoxelCoord voxel;
    glm::dvec3 part;
    for (int axis = 0; axis < 3; ++axis) {
      voxel[axis] = static_cast<std::int64_t>(place[axis] + 1) - 1;
      // Fractions have float precision, so that rounding does not leave the range of the voxels unless their values
      // have more bits than a float.
      part[axis] = static_cast<float>(std::max(place[axis] - static_cast<double>(voxel[axis]), 0.0));
    }
    return between(at(voxel), part);
  }

  /// Value between the eight voxels from `corner` on.
  double between(const T* corner, const glm::dvec3& part) const {
    const auto along_x = [&](std::int64_t i) {
      return mix(static_cast<double>(corner[i]), static_cast<double>(corner[i + 1]), part.x);
    };
    const double front = mix(along_x(0), along_x(stride_[1]), part.y);
    const double back = mix(along_x(stride_[2]), along_x(stride_[2] + stride_[1]), part.y);
    return mix(front, back, part.z);
  }

 private:
  // A voxel of weight 0 may be NaN and is ignored.
  static double mix(double a, double b, double fraction) {
    if constexpr (std::is_floating_point_v<T>) {
      if (fraction == 0) return a;
      if (fraction == 1) return b;
    }
    return a + fraction * (b - a);
  }

  const BrickBlock& block_;
  const T* const voxels_;
  const std::int64_t stride_[3];
};

}  // namespace kiln
